//! A rate of fluid that is spread over points.

use super::{Context, Effect};
use crate::geometry::{Side, Vector};
use crate::operators::Parity;
use crate::plan::Load;

/// Fluid that enters some points at a rate that may change over time.
pub(super) struct SourceDistribution {
    pub(super) name: &'static str,
    /// Full-plane rate, m^D/s.
    pub(super) rate: Load,
    /// Points and their shares; they add up to `inside`.
    pub(super) share: Vec<(u32, f64)>,
    /// Share of the rate that enters the domain.
    pub(super) inside: f64,
}

impl Effect for SourceDistribution {
    fn name(&self) -> &'static str {
        self.name
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

/// Planes of symmetry, each with the distance of a place to it, m; 0 where it stands on it.
pub(super) fn planes_of_symmetry<const D: usize>(
    context: &Context<'_, D>,
    at: &Vector<D>,
) -> Vec<(Side, f64)> {
    let domain = &context.operator.neighbourhood().cloud.domain;
    let sealed = |side: &Side| domain.planes && context.extension.parity(*side) == Parity::Even;
    let gap = |side: Side| {
        let gap = (at[side.axis] - domain.plane(side)).abs();
        let stands = gap < 1e-9 * domain.size()[side.axis];
        (side, if stands { 0.0 } else { gap })
    };
    Side::all(D).filter(sealed).map(gap).collect()
}
