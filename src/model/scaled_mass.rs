//! Mass that makes waves as slow as explicit steps of the pressure allow.
//!
//! Algorithm 1 takes one step of the solid a step of the pressure. With the mass of rock such a step is stable for
//! microseconds only; where inertia does not matter, mass is free, and every point gets what makes the two limits,
//! Eqs. 60 and 63 with storage, the same.

use super::{Coupling, FlowModel, SolidModel};
use crate::geometry::Cloud;

/// Share of the step of Eq. 60 that is taken (Eq. 61).
pub const SHARE: f64 = 0.7;

/// λ + 2μ + α²/s of a point, Pa: what waves feel that leave the fluid no time to flow.
pub fn undrained_modulus<const D: usize>(
    cloud: &Cloud<D>,
    solid: &SolidModel<D>,
    fluid: Option<(&Coupling, &FlowModel<D>)>,
    point: usize,
) -> f64 {
    let fluid = fluid.map_or(0.0, |(coupling, flow)| {
        let held = flow.capacity[point] * cloud.volume[point];
        coupling.divergence.weight[point].powi(2) / held
    });
    solid.elastic.stiffest(point) + fluid
}

/// Mass per point, kg, with which Eq. 61 allows the steps that the pressure allows.
pub(super) fn scaled_mass<const D: usize>(
    cloud: &Cloud<D>,
    solid: &SolidModel<D>,
    coupling: &Coupling,
    flow: &FlowModel<D>,
) -> Vec<f64> {
    let rate = |point: usize| flow.exchange_rate(point) / flow.capacity[point];
    // Gershgorin's bound of the eigenvalue, no larger than the limit that steps obey.
    let step = 2.0 / (0..cloud.len()).map(rate).fold(f64::MIN_POSITIVE, f64::max);
    let mass = |point: usize| {
        let modulus = undrained_modulus(cloud, solid, Some((coupling, flow)), point);
        let slowness = step / (SHARE * cloud.spacing(point));
        modulus * slowness * slowness * cloud.volume[point]
    };
    (0..cloud.len()).map(mass).collect()
}
