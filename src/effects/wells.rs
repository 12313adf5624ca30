//! Wells: point sources spread over a few cells (Eqs. 77 and 78).
//!
//! The kernel is renormalised so that the sum over the cloud and its mirror images is the full-plane
//! rate exactly: raw sums are off by up to one per cent. A well on a corner of a mirrored domain
//! therefore feeds a quarter of its rate into it, on a side a half. Where a well's support reaches
//! across a sealed plane it does not stand on, its mirror well feeds back what is lost.

use super::spread::{SourceDistribution, planes_of_symmetry};
use super::{Context, Effect, EffectError, vector};
use crate::geometry::Vector;
use crate::operators::Neighbourhood;
use crate::plan::WellPlan;

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let around = context.operator.neighbourhood();
    let wells = &context.plan.wells;
    let radius: Vec<f64> = wells.iter().map(|well| radius(around, well)).collect();
    for second in 0..wells.len() {
        for first in 0..second {
            let gap = vector::<D>(&wells[first].at) - vector::<D>(&wells[second].at);
            let radii = radius[first] + radius[second];
            if gap.norm() < radii {
                return Err(EffectError::OverlappingWells {
                    first: wells[first].name.clone(),
                    second: wells[second].name.clone(),
                    distance: gap.norm(),
                    radii,
                });
            }
        }
    }
    let one = |(well, &radius): (&WellPlan, &f64)| -> Result<Box<dyn Effect>, EffectError> {
        Ok(Box::new(spread(context, well, radius)?))
    };
    wells.iter().zip(&radius).map(one).collect()
}

/// Eq. 77 with the spacing and horizon of the nearest point.
fn radius<const D: usize>(around: &Neighbourhood<D>, well: &WellPlan) -> f64 {
    let nearest = around.cloud.nearest(&vector(&well.at)).unwrap_or(0);
    let equation =
        0.385 * around.families.horizon[nearest] + 1.2925 * around.cloud.spacing(nearest);
    well.radius.unwrap_or(equation)
}

/// Spreads one well over the points within its radius.
fn spread<const D: usize>(
    context: &Context<'_, D>,
    well: &WellPlan,
    radius: f64,
) -> Result<SourceDistribution, EffectError> {
    let cloud = &context.operator.neighbourhood().cloud;
    let images = well_images(context, &vector(&well.at), radius);
    let mut share = Vec::new();
    for (point, x) in cloud.position.iter().enumerate() {
        let weight: f64 = images
            .places
            .iter()
            .map(|well| kernel((x - well).norm(), radius))
            .sum();
        if weight > 0.0 {
            share.push((point as u32, weight * cloud.volume[point]));
        }
    }
    let sum: f64 = share.iter().map(|(_, s)| s).sum();
    if share.is_empty() || sum <= 0.0 {
        let (name, at) = (well.name.clone(), well.at.clone());
        return Err(EffectError::EmptyWell { name, at, radius });
    }
    let inside = images.inside;
    share.iter_mut().for_each(|(_, s)| *s *= inside / sum);
    Ok(SourceDistribution {
        name: "wells",
        rate: well.rate.clone(),
        share,
        inside,
    })
}

/// Shape of Eq. 78; its factor cancels in the normalisation.
fn kernel(distance: f64, radius: f64) -> f64 {
    if distance < radius {
        1.0 + (std::f64::consts::PI * distance / radius).cos()
    } else {
        0.0
    }
}

struct WellImages<const D: usize> {
    /// The well and its distinct mirror wells within reach.
    places: Vec<Vector<D>>,
    /// Share of the rate that enters the domain.
    inside: f64,
}

/// Mirror wells behind sealed planes; on each plane the well stands on it loses half.
fn well_images<const D: usize>(
    context: &Context<'_, D>,
    at: &Vector<D>,
    radius: f64,
) -> WellImages<D> {
    let domain = &context.operator.neighbourhood().cloud.domain;
    let mut images = WellImages {
        places: vec![*at],
        inside: 1.0,
    };
    for (side, gap) in planes_of_symmetry(context, at) {
        if gap <= 0.0 {
            images.inside *= 0.5;
        } else if gap < radius {
            let mirror = |place: &Vector<D>| {
                let mut mirrored = *place;
                mirrored[side.axis] = 2.0 * domain.plane(side) - place[side.axis];
                mirrored
            };
            let mirrored: Vec<Vector<D>> = images.places.iter().map(mirror).collect();
            images.places.extend(mirrored);
        }
    }
    images
}
