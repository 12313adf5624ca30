//! The largest stable explicit step, from the largest eigenvalue of C⁻¹ L.
//!
//! Eq. 63 as printed lacks the storage and bounds the eigenvalue by the five-point stencil's. Here it
//! comes from a Lanczos iteration on C^(−1/2) L C^(−1/2), good to a fraction of a per cent.

use std::borrow::Cow;

use nalgebra::{DMatrix, SymmetricEigen};
use perifrac_solvers::{dot, multiply, norm2};
use serde::{Deserialize, Serialize};

use crate::model::FlowModel;
use crate::report::lenient;

/// A stability limit and where it comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepLimit {
    /// Largest stable step, s.
    #[serde(deserialize_with = "lenient")]
    pub dt: f64,
    /// What limits it.
    pub reason: Cow<'static, str>,
    /// The point with the fastest exchange.
    pub point: usize,
    /// Its position, m.
    pub position: Vec<f64>,
}

const MOST_ITERATIONS: usize = 120;
/// Relative change of the eigenvalue below which the iteration stops.
const CONVERGED: f64 = 2e-4;

/// Limit 2/λ_max of forward Euler for S ṗ = q − L p with the given storage per point, m^D/Pa.
pub fn diffusion_limit<const D: usize>(flow: &FlowModel<D>, storage: &[f64]) -> StepLimit {
    let flow = &*flow.stiffest();
    let (point, bound) = fastest_exchange(flow, storage);
    let largest = largest_eigenvalue(flow, storage).min(bound);
    at(flow, point, largest)
}

/// A limit from Gershgorin's bound, which is quick and at most a few times too small, for coefficients
/// that change with every step and strain that lags behind.
///
/// Where the split overestimates the strain, the pressure swings, and the swings fade over tens of
/// steps: their periods take a tenth of the limit of diffusion alone.
pub(super) fn lagged_limit<const D: usize>(flow: &FlowModel<D>, storage: &[f64]) -> StepLimit {
    let (point, bound) = fastest_exchange(flow, storage);
    StepLimit {
        reason: "a tenth of the diffusion limit (Eq. 63 with storage and the compliance of fractures), so that \
                 swings of lagging strain fade".into(),
        ..at(flow, point, SWINGS * bound)
    }
}

/// Part of the diffusion limit that lagging strain needs, inverse.
const SWINGS: f64 = 10.0;

fn at<const D: usize>(flow: &FlowModel<D>, point: usize, largest: f64) -> StepLimit {
    let position = flow.operator.neighbourhood().cloud.position[point];
    StepLimit {
        dt: 2.0 / largest,
        reason: "diffusion (Eq. 63 with storage and the operator's own eigenvalue)".into(),
        point,
        position: position.iter().copied().collect(),
    }
}

/// Gershgorin's bound: the point with the largest Σ|L_ij|/C_i, and that value.
fn fastest_exchange<const D: usize>(flow: &FlowModel<D>, storage: &[f64]) -> (usize, f64) {
    let rate = |point: usize| flow.exchange_rate(point) / storage[point];
    let rates = (0..flow.points()).map(|point| (point, rate(point)));
    rates.fold(
        (0, 0.0),
        |best, next| if next.1 > best.1 { next } else { best },
    )
}

/// Upper estimate of the largest eigenvalue of C⁻¹ L, 1/s.
fn largest_eigenvalue<const D: usize>(flow: &FlowModel<D>, storage: &[f64]) -> f64 {
    let scale: Vec<f64> = storage.iter().map(|c| 1.0 / c.sqrt()).collect();
    let matrix = flow.matrix();
    let apply = |x: &[f64]| {
        let scaled: Vec<f64> = x.iter().zip(&scale).map(|(x, s)| x * s).collect();
        let mut y = vec![0.0; x.len()];
        multiply(matrix, &scaled, &mut y);
        y.iter_mut().zip(&scale).for_each(|(y, s)| *y *= s);
        y
    };
    lanczos(flow.points(), apply)
}

/// Upper estimate of the largest eigenvalue of a symmetric positive operator of `size` unknowns.
pub(super) fn largest_eigenvalue_of(size: usize, apply: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    lanczos(size, apply)
}

/// Largest Ritz value plus its residual bound.
fn lanczos(size: usize, mut apply: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    let mut current = start_vector(size);
    let mut previous = vec![0.0; size];
    let (mut diagonal, mut off): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut estimate = 0.0;
    for iteration in 0..MOST_ITERATIONS.min(size) {
        let mut next = apply(&current);
        let alpha = dot(&next, &current);
        let beta = off.last().copied().unwrap_or(0.0);
        for ((n, c), p) in next.iter_mut().zip(&current).zip(&previous) {
            *n -= alpha * c + beta * p;
        }
        let norm = norm2(&next);
        diagonal.push(alpha);
        if iteration % 10 == 9 || norm <= 1e-14 * alpha.abs() || iteration + 1 == size {
            let (ritz, residual) = largest_ritz(&diagonal, &off, norm);
            let settled = (ritz - estimate).abs() < CONVERGED * ritz;
            estimate = ritz;
            if settled || norm <= 1e-14 * alpha.abs() {
                return ritz + residual.min(1e-2 * ritz);
            }
        }
        off.push(norm);
        next.iter_mut().for_each(|n| *n /= norm);
        previous = std::mem::replace(&mut current, next);
    }
    estimate * (1.0 + 10.0 * CONVERGED)
}

/// Unit vector with a share of every mode, the same in every run.
fn start_vector(size: usize) -> Vec<f64> {
    let hash = |i: usize| (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11;
    let mut start: Vec<f64> = (0..size)
        .map(|i| hash(i) as f64 / (1_u64 << 53) as f64 - 0.5)
        .collect();
    let norm = norm2(&start);
    start.iter_mut().for_each(|x| *x /= norm);
    start
}

fn largest_ritz(diagonal: &[f64], off: &[f64], norm: f64) -> (f64, f64) {
    let size = diagonal.len();
    let matrix = DMatrix::from_fn(size, size, |row, column| match row.abs_diff(column) {
        0 => diagonal[row],
        1 => off[row.min(column)],
        _ => 0.0,
    });
    let eigen = SymmetricEigen::new(matrix);
    let largest = eigen.eigenvalues.imax();
    (
        eigen.eigenvalues[largest],
        norm * eigen.eigenvectors[(size - 1, largest)].abs(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 1-D Laplacian with Dirichlet ends has λ_max = 2 + 2 cos(π/(n + 1)).
    #[test]
    fn the_largest_eigenvalue_of_a_chain() {
        let size = 200;
        let apply = |x: &[f64]| -> Vec<f64> {
            let at = |i: isize| {
                if i < 0 || i >= size as isize {
                    0.0
                } else {
                    x[i as usize]
                }
            };
            (0..size as isize)
                .map(|i| 2.0 * at(i) - at(i - 1) - at(i + 1))
                .collect()
        };
        let exact = 2.0 + 2.0 * (std::f64::consts::PI / (size as f64 + 1.0)).cos();
        let found = lanczos(size, apply);
        assert!((found / exact - 1.0).abs() < 5e-3, "{found} {exact}");
    }
}
