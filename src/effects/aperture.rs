//! Opening of cracks from the bonds of broken points (Eq. 42).
//!
//! A bond across a crack of opening w is stretched by w cos φ along itself, φ being its angle to the
//! normal, so that the plain mean of Eq. 42 is about 0.76 w, and sliding leaks into it. Divided by the
//! cosine every bond across tells w.

use crate::geometry::Vector;
use crate::material::eigen;
use crate::operators::{Elastic, Response};
use crate::plan::ApertureRule;

/// Cosine up to which a bond runs along the crack, and from which it counts in full as one across it.
const ACROSS: [f64; 2] = [0.5, 0.7];
/// The same of an opening relative to the largest: bonds that do not cross the crack hardly open.
const CROSSING: [f64; 2] = [0.25, 0.75];

/// Opening at a broken point, m; 0 where nothing opens. `share(j)` tells how far a neighbour is
/// broken, 0 to 1.
///
/// Every criterion is a ramp: with a jump, flow and fracture would have no common state where a bond
/// counts for one opening and not for the other.
pub(crate) fn aperture<const D: usize>(
    rule: ApertureRule,
    elastic: &Elastic<D>,
    response: &Response<D>,
    point: usize,
    difference: impl Fn(usize) -> Vector<D>,
    share: impl Fn(usize) -> f64,
) -> f64 {
    let around = &elastic.around;
    let family = around.families.family(point);
    let weighted = family.map(|bond| (bond, share(around.families.neighbour(bond))));
    let broken = weighted.filter(|(_, share)| *share > 0.0);
    match rule {
        ApertureRule::Mean => {
            let opening =
                |bond: usize| difference(bond).dot(&around.bond_vector(point, bond).normalize());
            let all = broken.map(|(bond, share)| (opening(bond), share));
            mean(all.filter(|(opening, _)| *opening >= 0.0))
        }
        ApertureRule::Normal => {
            let (values, axes) = eigen(&response.strain[point]);
            let normal: Vector<D> = axes.column(values.imax()).into_owned();
            let opening = |(bond, share): (usize, f64)| {
                let direction = around.bond_vector(point, bond).normalize();
                let cosine = direction.dot(&normal).abs();
                let weight = share * ramp(cosine, ACROSS);
                (weight > 0.0).then(|| (difference(bond).dot(&direction) / cosine, weight))
            };
            let openings: Vec<(f64, f64)> = broken.filter_map(opening).collect();
            let largest = openings
                .iter()
                .map(|(opening, weight)| opening * weight)
                .fold(0.0, f64::max);
            if largest <= 0.0 {
                return 0.0;
            }
            let crossing = |(opening, weight): &(f64, f64)| {
                (*opening, weight * ramp(opening / largest, CROSSING))
            };
            mean(openings.iter().map(crossing))
        }
    }
}

/// From 0 to 1 between two bounds.
fn ramp(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((value - low) / (high - low)).clamp(0.0, 1.0)
}

/// Mean of openings with their weights; 0 without any.
fn mean(openings: impl Iterator<Item = (f64, f64)>) -> f64 {
    let sum = |(sum, weights), (opening, weight)| (sum + weight * opening, weights + weight);
    let (sum, weights) = openings.fold((0.0, 0.0), sum);
    if weights > 0.0 { sum / weights } else { 0.0 }
}
