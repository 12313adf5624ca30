//! Fluid that is pumped into a crack: spread over the points of the crack around a place.

use super::spread::{SourceDistribution, planes_of_symmetry};
use super::{Context, Effect, EffectError, vector};
use crate::geometry::Vector;
use crate::operators::Neighbourhood;
use crate::plan::{CrackPlan, InjectionPlan};

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let pumped = |(crack, band): (&CrackPlan, &Vec<u32>)| {
        let injection = crack.injection.as_ref()?;
        Some(pump(context, crack, injection, band))
    };
    let cracks = context.plan.cracks.iter().zip(context.bands);
    cracks
        .filter_map(pumped)
        .map(|injection| Ok(Box::new(injection?) as Box<dyn Effect>))
        .collect()
}

/// Points of a band within one horizon of a place, each with its share of what is pumped in there.
pub(crate) fn injection_shares<const D: usize>(
    around: &Neighbourhood<D>,
    at: &Vector<D>,
    band: &[u32],
) -> Vec<(u32, f64)> {
    let near = |point: &&u32| {
        let i = **point as usize;
        (around.cloud.position[i] - at).norm() <= around.families.horizon[i]
    };
    let near: Vec<u32> = band.iter().filter(near).copied().collect();
    let volume = |point: u32| around.cloud.volume[point as usize];
    let sum: f64 = near.iter().map(|point| volume(*point)).sum();
    near.iter()
        .map(|point| (*point, volume(*point) / sum))
        .collect()
}

fn pump<const D: usize>(
    context: &Context<'_, D>,
    crack: &CrackPlan,
    injection: &InjectionPlan,
    band: &[u32],
) -> Result<SourceDistribution, EffectError> {
    let at = vector(&injection.at);
    let mut share = injection_shares(context.operator.neighbourhood(), &at, band);
    if share.is_empty() {
        return Err(EffectError::EmptyInjection {
            name: crack.name.clone(),
            at: injection.at.clone(),
        });
    }
    // A place on a plane of symmetry has half of what it gets outside.
    let planes = planes_of_symmetry(context, &at).into_iter();
    let inside = 0.5_f64.powi(planes.filter(|(_, gap)| *gap <= 0.0).count() as i32);
    share.iter_mut().for_each(|(_, share)| *share *= inside);
    Ok(SourceDistribution {
        name: "injection",
        rate: injection.rate.clone(),
        share,
        inside,
    })
}
