//! Wells: point sources spread over a few cells (Eqs. 77 and 78).
//!
//! The kernel is weighted so that the sum over the cloud and its mirror images is the full-plane rate exactly
//! (raw sums are off by up to one per cent), and that its first moments, and the second ones without their
//! trace, vanish (see [`weights`]). A well on a corner of a mirrored domain
//! therefore feeds a quarter of its rate into it, on a side a half. Where a well's support reaches
//! across a sealed plane it does not stand on, its mirror well feeds back what is lost.

use super::moments::weights;
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
    let one = |(well, &radius): (&WellPlan, &f64)| {
        // Those that may be held at a pressure are a part of the operator.
        let rate = well.rate().filter(|_| !well.holds())?;
        let spread = spread(context, well, radius);
        Some(spread.map(|spread| -> Box<dyn Effect> {
            Box::new(SourceDistribution {
                name: "wells",
                rate: rate.clone(),
                share: spread.share,
                inside: spread.inside,
            })
        }))
    };
    wells.iter().zip(&radius).filter_map(one).collect()
}

/// Points that a well feeds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WellSpread {
    /// Points and their shares s_i; they add up to `inside`.
    pub share: Vec<(u32, f64)>,
    /// Share of the rate that enters the domain.
    pub inside: f64,
    /// Radius λ over which it is spread, m.
    pub radius: f64,
}

/// How the wells are spread whose bottom-hole pressure is known, each with its place in the plan.
///
/// # Errors
/// [`EffectError::EmptyWell`].
pub(crate) fn known_wells<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<(usize, WellSpread)>, EffectError> {
    let around = context.operator.neighbourhood();
    let wells = context.plan.wells.iter().enumerate();
    let known = wells.filter(|(_, well)| well.bore.is_some());
    let spread = |(place, well)| Ok((place, spread(context, well, radius(around, well))?));
    known.map(spread).collect()
}

/// Eq. 77 with the spacing and horizon of the nearest point.
fn radius<const D: usize>(around: &Neighbourhood<D>, well: &WellPlan) -> f64 {
    let nearest = around.cloud.nearest(&vector(&well.at)).unwrap_or(0);
    let equation =
        0.385 * around.families.horizon[nearest] + 1.2925 * around.cloud.spacing(nearest);
    well.radius.unwrap_or(equation)
}

/// A contribution to the rate of a well.
struct Item<const D: usize> {
    point: usize,
    /// Kernel times volume.
    base: f64,
    /// From the well, or from the place where a mirror well sees it, in radii.
    place: Vector<D>,
    /// Whether it enters the domain: what mirrors in planes on which the well stands see does not.
    enters: bool,
}

/// Spreads one well over the points within its radius.
fn spread<const D: usize>(
    context: &Context<'_, D>,
    well: &WellPlan,
    radius: f64,
) -> Result<WellSpread, EffectError> {
    let cloud = &context.operator.neighbourhood().cloud;
    let images = well_images(context, &vector(&well.at), radius);
    let mut items = Vec::new();
    for (point, x) in cloud.position.iter().enumerate() {
        for image in &images {
            let arm = x - image.place;
            let base = kernel(arm.norm(), radius) * cloud.volume[point];
            if base > 0.0 {
                items.push(Item {
                    point,
                    base,
                    place: arm.component_mul(&image.signs) / radius,
                    enters: image.feeds,
                });
            }
        }
    }
    if items.is_empty() {
        let (name, at) = (well.name.clone(), well.at.clone());
        return Err(EffectError::EmptyWell { name, at, radius });
    }
    let base: Vec<f64> = items.iter().map(|item| item.base).collect();
    let places: Vec<Vector<D>> = items.iter().map(|item| item.place).collect();
    let mut share: Vec<(u32, f64)> = Vec::new();
    for (item, weight) in items.iter().zip(weights(&base, &places)) {
        let point = item.point as u32;
        match share.last_mut() {
            _ if !item.enters => {}
            Some((last, sum)) if *last == point => *sum += weight,
            _ => share.push((point, weight)),
        }
    }
    // Exactly what enters, whatever rounding does to the sum.
    let inside = standing(context, &vector(&well.at));
    let sum: f64 = share.iter().map(|(_, s)| s).sum();
    share.iter_mut().for_each(|(_, s)| *s *= inside / sum);
    Ok(WellSpread {
        share,
        inside,
        radius,
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

/// A well, or its mirror image.
struct WellImage<const D: usize> {
    place: Vector<D>,
    /// −1 along the axes in which it is mirrored.
    signs: Vector<D>,
    /// Whether what it feeds counts: a mirror image in a plane on which the well stands is the well itself.
    feeds: bool,
}

/// Share of the rate of a well that enters the domain: on each plane of symmetry it stands on it loses half.
fn standing<const D: usize>(context: &Context<'_, D>, at: &Vector<D>) -> f64 {
    let planes = planes_of_symmetry(context, at);
    let on = planes.iter().filter(|(_, gap)| *gap <= 0.0).count();
    0.5_f64.powi(on as i32)
}

/// The well and its mirror wells behind sealed planes within reach.
fn well_images<const D: usize>(
    context: &Context<'_, D>,
    at: &Vector<D>,
    radius: f64,
) -> Vec<WellImage<D>> {
    let domain = &context.operator.neighbourhood().cloud.domain;
    let mut images = vec![WellImage {
        place: *at,
        signs: Vector::repeat(1.0),
        feeds: true,
    }];
    let planes = planes_of_symmetry(context, at);
    for (side, gap) in planes.into_iter().filter(|(_, gap)| *gap < radius) {
        let mirror = |image: &WellImage<D>| {
            let (mut place, mut signs) = (image.place, image.signs);
            place[side.axis] = 2.0 * domain.plane(side) - place[side.axis];
            signs[side.axis] = -signs[side.axis];
            let feeds = image.feeds && gap > 0.0;
            WellImage {
                place,
                signs,
                feeds,
            }
        };
        let mirrored: Vec<WellImage<D>> = images.iter().map(mirror).collect();
        images.extend(mirrored);
    }
    images
}
