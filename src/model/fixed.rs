//! Points of prescribed pressure.

use super::bands::Bands;
use super::{FlowModel, ModelError};
use crate::geometry::Cloud;
use crate::plan::{FlowPlan, Load, Plan};
use crate::report::Flows;

/// A point whose pressure is prescribed.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedPressure {
    /// The point.
    pub point: usize,
    /// Index into [`FlowModel::fixed_loads`](super::FlowModel::fixed_loads).
    pub load: usize,
}

/// Points of the regions and cracks with prescribed pressure; a later one wins, cracks after regions.
pub(super) fn fixed_points<const D: usize>(
    plan: &Plan,
    flow: &FlowPlan,
    cloud: &Cloud<D>,
    bands: &Bands,
) -> Result<(Vec<FixedPressure>, Vec<Load>), ModelError> {
    let pressed = plan.cracks.iter().zip(&bands.points);
    let pressed = pressed.filter_map(|(crack, band)| Some((crack.pressure.as_ref()?, band)));
    let none = flow.regions.is_empty() && pressed.clone().next().is_none();
    let mut chosen = vec![None; if none { 0 } else { cloud.len() }];
    for (load, region) in flow.regions.iter().enumerate() {
        let mut found = false;
        for (own, x) in chosen.iter_mut().zip(&cloud.position) {
            if region.region.contains(x.as_slice()) {
                (*own, found) = (Some(load), true);
            }
        }
        if !found {
            return Err(ModelError::EmptyPressureRegion { number: load + 1 });
        }
    }
    let mut loads: Vec<Load> = flow
        .regions
        .iter()
        .map(|region| region.pressure.clone())
        .collect();
    for (pressure, band) in pressed {
        for &point in band {
            chosen[point as usize] = Some(loads.len());
        }
        loads.push(pressure.clone());
    }
    let lost = (0..flow.regions.len()).find(|load| !chosen.contains(&Some(*load)));
    if let Some(lost) = lost {
        return Err(ModelError::CoveredPressureRegion { number: lost + 1 });
    }
    let points = chosen.into_iter().enumerate();
    let fixed = points.filter_map(|(point, load)| load.map(|load| FixedPressure { point, load }));
    Ok((fixed.collect(), loads))
}

impl<const D: usize> FlowModel<D> {
    /// Adds the rate that enters at the points of prescribed pressure, from the imbalance q − L p with
    /// the rate of storage taken off, m^D/s.
    pub fn add_fixed_inflow(&self, imbalance: &[f64], flows: &mut Flows) {
        for fixed in &self.fixed {
            flows.hold(fixed.load, -imbalance[fixed.point]);
        }
    }

    /// Whether the pressure of a point is prescribed, shape `(n,)`.
    pub fn fixed_mask(&self) -> Vec<bool> {
        let mut mask = vec![false; self.points()];
        self.fixed.iter().for_each(|fixed| mask[fixed.point] = true);
        mask
    }

    /// Sets the entries of `change` at fixed points to what leads from `base` to their pressure at
    /// `time`, Pa.
    pub fn fix(&self, time: f64, base: &[f64], change: &mut [f64]) {
        for fixed in &self.fixed {
            change[fixed.point] = self.fixed_loads[fixed.load].at(time) - base[fixed.point];
        }
    }

    /// Sets the prescribed pressures to those at `time`, Pa.
    pub fn fix_values(&self, time: f64, pressure: &mut [f64]) {
        for fixed in &self.fixed {
            pressure[fixed.point] = self.fixed_loads[fixed.load].at(time);
        }
    }
}
