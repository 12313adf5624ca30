//! Opening of cracks from the bonds of broken points (Eq. 42).
//!
//! A bond across a crack of opening w is stretched by w cos φ along itself, φ being its angle to the
//! normal, so that the plain mean of Eq. 42 is about 0.76 w, and sliding leaks into it. Divided by the
//! cosine every bond across tells w.

use crate::geometry::Vector;
use crate::material::eigen;
use crate::operators::{Answer, Elastic};
use crate::plan::ApertureRule;

/// Cosine below which a bond runs along the crack rather than across it.
const ACROSS: f64 = 0.5;
/// Share of the largest opening from which a bond counts as one that crosses the crack.
const CROSSING: f64 = 0.5;

/// Opening at a broken point, m; 0 where nothing opens. `broken(j)` tells whether a neighbour is.
pub fn aperture<const D: usize>(
    rule: ApertureRule,
    elastic: &Elastic<D>,
    answer: &Answer<D>,
    point: usize,
    difference: impl Fn(usize) -> Vector<D>,
    broken: impl Fn(usize) -> bool,
) -> f64 {
    let around = &elastic.around;
    let family = around.families.family(point);
    let across = family.filter(|bond| broken(around.families.neighbour(*bond)));
    match rule {
        ApertureRule::Mean => {
            let opening =
                |bond: usize| difference(bond).dot(&around.bond_vector(point, bond).normalize());
            mean(across.map(opening), 0.0)
        }
        ApertureRule::Normal => {
            let (values, axes) = eigen(&answer.strain[point]);
            let normal: Vector<D> = axes.column(values.imax()).into_owned();
            let opening = |bond: usize| {
                let direction = around.bond_vector(point, bond).normalize();
                let cosine = direction.dot(&normal).abs();
                (cosine >= ACROSS).then(|| difference(bond).dot(&direction) / cosine)
            };
            let openings: Vec<f64> = across.filter_map(opening).collect();
            let largest = openings.iter().copied().fold(0.0, f64::max);
            mean(openings.into_iter(), CROSSING * largest)
        }
    }
}

/// Mean of what is at least `least` and not negative; 0 without any.
fn mean(openings: impl Iterator<Item = f64>, least: f64) -> f64 {
    let open = openings.filter(|opening| *opening >= least.max(0.0));
    let (sum, count) = open.fold((0.0, 0), |(sum, count), opening| (sum + opening, count + 1));
    if count == 0 {
        0.0
    } else {
        sum / f64::from(count)
    }
}
