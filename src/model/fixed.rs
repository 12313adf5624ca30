//! Points of prescribed pressure.

use super::ModelError;
use super::bands::Bands;
use crate::geometry::Cloud;
use crate::plan::{FlowPlan, Load, Plan};

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
