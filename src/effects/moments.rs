//! Weights of a well that stands anywhere between points: what they feed in has the moments of a point source.
//!
//! A kernel whose weights are only normalised feeds in around the centre of the points that it happens to cover,
//! and more along one axis than along another. Far away that is a dipole and a quadrupole. With the factors exp(λ·P),
//! P the first moments and the second ones without their trace, both vanish and all weights stay positive; λ is the
//! minimum of a convex function. (The trace is a source of its own Laplacian, which vanishes away from the well.)

use nalgebra::{DMatrix, DVector};

use crate::geometry::Vector;

/// Moments, relative to the reach of the kernel, that are rounding error.
const ROUNDING: f64 = 1e-14;
/// Steps that are taken whole: what they save is lost in the rounding of the sum.
const NEAR: f64 = 1e-3;
/// Newton steps; places between points take 5 or fewer.
const STEPS: usize = 40;
/// Halvings of a step.
const HALVINGS: usize = 30;
/// Factors beyond which a moment can only be had by feeding nearly all into few points.
const STEEPEST: f64 = 20.0;

/// Weights of unit sum for sources of the given `base` weights at `places`, relative to the well and in units of
/// its reach. As many moments vanish as the points around allow: all, the first ones, or none.
pub(super) fn weights<const D: usize>(base: &[f64], places: &[Vector<D>]) -> Vec<f64> {
    let sum: f64 = base.iter().sum();
    let plain: Vec<f64> = base.iter().map(|b| b / sum).collect();
    [second::<D>(), D]
        .into_iter()
        .find_map(|count| balanced(&plain, places, count))
        .unwrap_or(plain)
}

/// Number of first moments, and second ones without the trace.
const fn second<const D: usize>() -> usize {
    D + D * (D + 1) / 2 - 1
}

/// The first `count` moments of a place.
fn moments<const D: usize>(z: &Vector<D>, count: usize) -> DVector<f64> {
    let first = (0..D).map(|axis| z[axis]);
    let mixed = (0..D).flat_map(|a| (0..a).map(move |b| (a, b)));
    let mixed = mixed.map(|(a, b)| 2.0 * z[a] * z[b]);
    let apart = (1..D).map(|axis| z[axis].powi(2) - z[0].powi(2));
    DVector::from_iterator(count, first.chain(mixed).chain(apart).take(count))
}

/// Weights whose first `count` moments vanish; `None` if there are none, or only very uneven ones.
fn balanced<const D: usize>(plain: &[f64], places: &[Vector<D>], count: usize) -> Option<Vec<f64>> {
    let moments: Vec<DVector<f64>> = places.iter().map(|z| moments(z, count)).collect();
    let tilted = |lambda: &DVector<f64>| -> Vec<f64> {
        let pairs = plain.iter().zip(&moments);
        pairs.map(|(b, m)| b * lambda.dot(m).exp()).collect()
    };
    let mut lambda = DVector::zeros(count);
    let mut now = tilted(&lambda);
    for _ in 0..STEPS {
        let sum: f64 = now.iter().sum();
        let mean = mean(&now, &moments, count) / sum;
        if mean.amax() <= ROUNDING {
            now.iter_mut().for_each(|w| *w /= sum);
            return Some(now);
        }
        let step = spread(&now, &moments, &mean, sum)
            .cholesky()?
            .solve(&-&mean);
        let mut length = 1.0;
        let next = (0..HALVINGS).find_map(|_| {
            let ahead = &lambda + &step * length;
            length *= 0.5;
            let found = tilted(&ahead);
            let total: f64 = found.iter().sum();
            (total < sum || step.amax() <= NEAR).then_some((ahead, found))
        });
        (lambda, now) = next?;
        if lambda.amax() > STEEPEST {
            return None;
        }
    }
    None
}

/// Σ w P.
fn mean(weights: &[f64], moments: &[DVector<f64>], count: usize) -> DVector<f64> {
    let pairs = weights.iter().zip(moments);
    pairs.fold(DVector::zeros(count), |sum, (w, m)| sum + m * *w)
}

/// Covariance of the moments.
fn spread(
    weights: &[f64],
    moments: &[DVector<f64>],
    mean: &DVector<f64>,
    sum: f64,
) -> DMatrix<f64> {
    let count = mean.len();
    let pairs = weights.iter().zip(moments);
    let second = pairs.fold(DMatrix::zeros(count, count), |sum, (w, m)| {
        sum + m * m.transpose() * *w
    });
    second / sum - mean * mean.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a square lattice around a place, with the kernel of Eq. 78.
    fn around(offset: [f64; 2]) -> (Vec<f64>, Vec<Vector<2>>) {
        const REACH: f64 = 2.2;
        let points = (-4..=4).flat_map(|a| (-4..=4).map(move |b| [f64::from(a), f64::from(b)]));
        let relative = points.map(|p| Vector::<2>::new(p[0] - offset[0], p[1] - offset[1]) / REACH);
        let near: Vec<Vector<2>> = relative.filter(|z| z.norm() < 1.0).collect();
        let kernel = |z: &Vector<2>| 1.0 + (std::f64::consts::PI * z.norm()).cos();
        (near.iter().map(kernel).collect(), near)
    }

    #[test]
    fn a_well_between_points_is_a_point_source_to_second_order() {
        let grid = (0..=50).map(|k| f64::from(k) / 50.0);
        let offsets = grid.clone().flat_map(|x| grid.clone().map(move |y| [x, y]));
        for offset in offsets {
            let (base, places) = around(offset);
            let found = weights(&base, &places);
            assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            assert!(found.iter().all(|w| *w >= 0.0), "{offset:?}");
            let sum = |f: &dyn Fn(&Vector<2>) -> f64| -> f64 {
                found.iter().zip(&places).map(|(w, z)| w * f(z)).sum()
            };
            let all: [&dyn Fn(&Vector<2>) -> f64; 4] =
                [&|z| z[0], &|z| z[1], &|z| z[0] * z[1], &|z| {
                    z[0] * z[0] - z[1] * z[1]
                }];
            for moment in all {
                assert!(sum(moment).abs() < 1e-13, "{offset:?} {}", sum(moment));
            }
        }
    }

    #[test]
    fn on_a_point_of_a_lattice_nothing_changes() {
        let (base, places) = around([0.0, 0.0]);
        let total: f64 = base.iter().sum();
        for (found, own) in weights(&base, &places).iter().zip(&base) {
            assert!((found - own / total).abs() < 1e-15);
        }
    }

    /// Outside of all points no positive weights have the moment of the well.
    #[test]
    fn where_points_are_on_one_side_only_the_kernel_stays_as_it_is() {
        let (base, places) = around([0.3, 0.1]);
        let one_sided: (Vec<f64>, Vec<Vector<2>>) = base
            .into_iter()
            .zip(places)
            .filter(|(_, z)| z[0] > 0.05)
            .unzip();
        let found = weights(&one_sided.0, &one_sided.1);
        let total: f64 = one_sided.0.iter().sum();
        for (found, own) in found.iter().zip(&one_sided.0) {
            assert!((found - own / total).abs() < 1e-15);
        }
    }
}
