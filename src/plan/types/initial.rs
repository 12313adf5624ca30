//! What a plan says about the stress of the in-situ state.

use super::{MaterialPlan, Plan};
use crate::geometry::Shape;

/// Stress that is in equilibrium before the run, Pa, tension positive; components xx, yy, zz, xy, yz, xz.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InitialPlan {
    /// Whether the stresses are total ones, pore pressure included.
    pub total: bool,
    /// Stress at the datum, Pa.
    pub stress: [f64; 6],
    /// What a metre of depth adds, Pa/m.
    pub gradient: [f64; 6],
    /// Height from which depth counts, m, counted against gravity from the origin (along the last axis without
    /// gravity); that of the highest corner of the domain if absent.
    pub datum: Option<f64>,
    /// Ratio of horizontal to vertical effective stress where the latter comes from the weight.
    pub k0: Option<f64>,
    /// Uniform stresses of parts, in place of the others; later ones win.
    pub regions: Vec<(Shape, [f64; 6])>,
}

impl InitialPlan {
    /// Whether the effective stress is the same at all points, as far as the plan tells.
    pub fn is_uniform(&self, plan: &Plan) -> bool {
        let zero = |values: &[f64; 6]| values.iter().all(|value| value.abs() <= 0.0);
        let plain = zero(&self.gradient) && self.k0.is_none() && self.regions.is_empty();
        plain && (!self.total || plan.coupling.is_none() || pushes_evenly(plan))
    }
}

/// Whether α p is the same everywhere at the start.
fn pushes_evenly(plan: &Plan) -> bool {
    let Some(flow) = &plan.flow else { return true };
    let uniform = |own: &MaterialPlan| own.biot_coefficient.as_ref()?.uniform();
    let mut all = plan.materials.iter().map(uniform);
    let first = all.next().flatten();
    let same = first.is_some() && all.all(|own| own == first);
    !flow.hydrostatic_start && (same || flow.initial_pressure.abs() <= 0.0)
}
