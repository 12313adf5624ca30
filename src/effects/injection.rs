//! Fluid that is pumped into a crack: spread over the points of the crack around a place.

use super::{Context, Effect, EffectError, vector};
use crate::geometry::{Side, Vector};
use crate::operators::{Neighbourhood, Parity};
use crate::plan::{CrackPlan, InjectionPlan, Load};

struct Injection {
    rate: Load,
    share: Vec<(u32, f64)>,
    inside: f64,
}

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let pumped = |(crack, band): (&CrackPlan, &Vec<u32>)| {
        let injection = crack.injection.as_ref()?;
        Some(Injection::new(context, crack, injection, band))
    };
    let cracks = context.plan.cracks.iter().zip(context.bands);
    cracks
        .filter_map(pumped)
        .map(|injection| Ok(Box::new(injection?) as Box<dyn Effect>))
        .collect()
}

/// Points of a band within one horizon of a place, each with its share of what is pumped in there.
pub fn injection_shares<const D: usize>(
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

impl Injection {
    fn new<const D: usize>(
        context: &Context<'_, D>,
        crack: &CrackPlan,
        injection: &InjectionPlan,
        band: &[u32],
    ) -> Result<Self, EffectError> {
        let at = vector(&injection.at);
        let mut share = injection_shares(context.operator.neighbourhood(), &at, band);
        if share.is_empty() {
            return Err(EffectError::EmptyInjection {
                name: crack.name.clone(),
                at: injection.at.clone(),
            });
        }
        // A place on a plane of symmetry has half of what it gets outside.
        let domain = &context.operator.neighbourhood().cloud.domain;
        let on = |side: &Side| {
            let gap = (at[side.axis] - domain.plane(*side)).abs();
            let sealed = context.extension.parity(*side) == Parity::Even;
            domain.planes && sealed && gap < 1e-9 * domain.size()[side.axis]
        };
        let inside = 0.5_f64.powi(Side::all(D).filter(on).count() as i32);
        share.iter_mut().for_each(|(_, share)| *share *= inside);
        let rate = injection.rate.clone();
        Ok(Injection {
            rate,
            share,
            inside,
        })
    }
}

impl Effect for Injection {
    fn name(&self) -> &'static str {
        "injection"
    }

    fn add_rate(&self, time: f64, rate: &mut [f64]) {
        let total = self.rate.at(time);
        for &(point, share) in &self.share {
            rate[point as usize] += total * share;
        }
    }

    fn injection(&self, time: f64) -> f64 {
        self.rate.at(time) * self.inside
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.rate.breakpoints().to_vec()
    }

    fn bytes(&self) -> usize {
        self.share.len() * size_of::<(u32, f64)>()
    }
}
