//! Theis' well, with its parameters taken from the plan.

use super::{domain, require, storage, text, uniform};
use crate::load::Load;
use crate::plan::types::{MaterialPlan, PermeabilityPlan, Plan, ReferenceKind, WellPlan};
use crate::reference::{ExactPressure, Theis, TheisParameters, TheisSeries};

/// The only well, and Theis' solution around it for the rate at the start.
fn around(plan: &Plan) -> Result<(&WellPlan, Theis), String> {
    let (permeability, shape, storage) = match plan.materials.as_slice() {
        [
            material @ MaterialPlan {
                permeability: Some(PermeabilityPlan::Tensor { largest, shape }),
                ..
            },
        ] => (*largest, *shape, storage(material)?),
        _ => {
            let (mobility, storage) = uniform(plan)?;
            (mobility * plan.fluid.viscosity, [1.0, 1.0, 0.0], storage)
        }
    };
    require(plan.dimension == 2, "the Theis solution is for the plane")?;
    let [well] = plan.wells.as_slice() else {
        return Err("the Theis solution needs exactly one well".to_owned());
    };
    let rate = well.rate();
    let rate = rate.ok_or_else(|| "the Theis solution needs a well of a `rate`".to_owned())?;
    let (_, size) = domain(plan)?;
    let default = 0.05 * size.iter().copied().fold(f64::INFINITY, f64::min);
    let theis = Theis::new(TheisParameters {
        well: [well.at[0], well.at[1]],
        rate: rate.at(0.0),
        mobility: permeability / plan.fluid.viscosity,
        shape,
        storage,
        initial_pressure: plan.flow.as_ref().map_or(0.0, |flow| flow.initial_pressure),
        excluded_radius: plan.reference.and_then(|r| r.exclude).unwrap_or(default),
    });
    Ok((well, theis.map_err(text)?))
}

/// Times and rates of a load; a constant has one pair.
fn table(rate: &Load) -> Vec<[f64; 2]> {
    let times = rate.breakpoints().iter().chain(&[0.0]);
    times
        .zip(rate.values())
        .map(|(time, rate)| [*time, *rate])
        .collect()
}

/// Theis' solution, superposed where the rate changes.
pub(super) fn theis(plan: &Plan) -> Result<Box<dyn ExactPressure>, String> {
    let (well, theis) = around(plan)?;
    Ok(match well.rate().filter(|rate| !rate.is_constant()) {
        Some(rate) => Box::new(TheisSeries::new(theis, table(rate))),
        None => Box::new(theis),
    })
}

/// Exact bottom-hole pressure at `time` of the only well, Pa, and the largest change since the start so far, where the plan names
/// Theis' solution and the hole: the pressure at the radius of the hole, and q μ skin/(2πk).
///
/// Not where flow has a preferred direction, around which no hole is round.
pub fn exact_well_pressure(plan: &Plan, time: f64) -> Option<(f64, f64)> {
    plan.reference
        .filter(|reference| reference.kind == ReferenceKind::Theis)?;
    let (well, around) = around(plan).ok()?;
    let (bore, rate) = (well.bore?, well.rate()?);
    let TheisParameters {
        mobility,
        shape,
        initial_pressure,
        ..
    } = *around.parameters();
    if plan.has_tensors() || time <= 0.0 {
        return None;
    }
    debug_assert!(shape[2].abs() <= 0.0);
    let series = TheisSeries::new(around, table(rate));
    let rim = [well.at[0] + bore.radius, well.at[1]];
    let skin = bore.skin / (std::f64::consts::TAU * mobility);
    let at = |time: f64| series.pressure(&rim, time) + skin * rate.at(time);
    let breaks = rate.breakpoints().iter().copied();
    let changes = (breaks.filter(|own| *own > 0.0 && *own < time).chain([time]))
        .map(|time| (at(time) - initial_pressure).abs());
    Some((at(time), changes.fold(0.0, f64::max)))
}
