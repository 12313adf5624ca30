//! Effective widths of the families of sampled points.

use crate::geometry::{Cloud, SampledBond, Sampler};
use crate::model::damage::{band_law, law};
use crate::model::properties::Properties;
use crate::operators::{FamilyWidths, WholeFamily, WidthRange};
use crate::plan::Plan;

/// Widths over 2δ in all directions, averaged over `samples`; `None` if no rock breaks.
pub(super) fn range<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    sampler: &Sampler<'_, D>,
    points: &Properties,
    samples: &[usize],
) -> Option<WidthRange> {
    let mechanics = plan.mechanics.as_ref()?;
    let law = band_law(law(plan)?, mechanics);
    let family = |point: &usize| {
        let horizon = sampler.horizon()[*point];
        let weigh = |(end, _, xi): SampledBond<D>| {
            let weight = plan.influence.weight(xi.norm(), horizon);
            (xi, weight * cloud.volume[end])
        };
        let bonds = sampler.family(*point).into_iter();
        WholeFamily {
            horizon,
            lame: points.lame[*point],
            bonds: bonds.map(weigh).collect(),
        }
    };
    let families: Vec<WholeFamily<D>> = samples.iter().map(family).collect();
    Some(FamilyWidths::of_families(&families, &law).range())
}
