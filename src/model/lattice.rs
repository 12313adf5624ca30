//! The points as a lattice whose rows repeat, with what varies from point to point.

use perifrac_solvers::Lattice;

use super::properties::Properties;
use crate::assembly::{Pattern, Repetition};
use crate::geometry::Cloud;
use crate::operators::{Lame, Neighbourhood};
use crate::plan::capability::System;
use crate::plan::{Plan, lattice as planned};

/// The points of a cloud as a lattice for a linear system: rows do not repeat along axes on which a property varies.
///
/// # Errors
/// Why rows repeat along no axis at all, in words that end a sentence.
pub(super) fn lattice<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    points: &Properties,
    system: System,
) -> Result<Lattice, String> {
    let mut lattice = planned(plan, system)?;
    let (size, cell) = (cloud.domain.size(), &cloud.cell[0]);
    let mut stride = 1;
    for (axis, own) in lattice.axes.iter_mut().enumerate() {
        own.count = (size[axis] / cell[axis]).round() as usize;
        if own.mirrors.is_ok() && varies(points, stride, own.count) {
            own.mirrors = Err("the rock varies".to_owned());
        }
        stride *= own.count;
    }
    Ok(lattice)
}

/// Whether that lattice separates, see [`Lattice::separates`].
///
/// # Errors
/// Why not, likewise.
pub(super) fn separates<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    points: &Properties,
    system: System,
) -> Result<(), String> {
    lattice(plan, cloud, points, system).and_then(|own| own.separates())
}

/// Which points have the rows of mechanics of which others; none where rows differ everywhere, and in parts of
/// a cloud.
pub(super) fn repetition<const D: usize>(
    plan: &Plan,
    points: &Properties,
    around: &Neighbourhood<D>,
    pattern: &Pattern,
) -> Option<Repetition> {
    let (cloud, families) = (&around.cloud, &around.families);
    let lattice = lattice(plan, cloud, points, System::Mechanics).ok()?;
    let counts: [usize; D] = std::array::from_fn(|axis| lattice.axes[axis].count);
    let same = |own: &Lame| [own.lambda, own.mu].map(f64::to_bits);
    let uniform = points
        .lame
        .windows(2)
        .all(|pair| same(&pair[0]) == same(&pair[1]));
    if !uniform || families.share.partition().is_some() {
        return None;
    }
    let reach = families.horizon.iter().copied().fold(0.0, f64::max);
    // A row holds families of all that see its point.
    let margin = |axis: usize| 2 * (reach / cloud.cell[0][axis]).ceil() as usize;
    let repetition = Repetition::new(counts, std::array::from_fn(margin));
    Some(repetition).filter(|own| own.fits(pattern))
}

/// Whether a property differs between neighbours along an axis of `count` points that are `stride` apart.
fn varies(points: &Properties, stride: usize, count: usize) -> bool {
    let differs = |values: &[f64]| differs(values, stride, count);
    let lame = |part: fn(&Lame) -> f64| -> Vec<f64> { points.lame.iter().map(part).collect() };
    differs(&points.permeability)
        || differs(&points.storage)
        || differs(&points.biot_coefficient)
        || differs(&lame(|own| own.lambda))
        || differs(&lame(|own| own.mu))
}

fn differs(values: &[f64], stride: usize, count: usize) -> bool {
    let pairs = values.iter().zip(values.iter().skip(stride));
    pairs.enumerate().any(|(point, (own, next))| {
        point / stride % count + 1 < count && own.to_bits() != next.to_bits()
    })
}
