//! Chebyshev polynomials of the matrix preconditioned by the inverses of its diagonal blocks.

use super::block::{BlockMatrix, BlockPattern, BlockRows, ROWS_PER_TASK, Update, rows_of};
use super::dense::{invert, largest_eigenvalue};
use crate::dot;
use crate::parallel;

/// Lanczos steps for the largest eigenvalue.
const STEPS: usize = 20;
/// Lanczos approaches the largest eigenvalue from below.
const MARGIN: f64 = 1.1;

/// A symmetric positive definite smoother S ≈ A⁻¹ for the upper part of the spectrum.
pub(super) struct Smoother {
    /// D⁻¹, one block a row.
    inverse: BlockMatrix<f64>,
    /// Bound of the spectrum of D⁻¹ A.
    pub(super) bound: f64,
}

/// Degree of the polynomial and part of the spectrum it damps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polynomial {
    pub(super) degree: usize,
    /// Upper end of the damped interval over its lower end.
    pub(super) ratio: f64,
}

impl Smoother {
    pub(super) fn new(source: &dyn BlockRows, matrix: &BlockMatrix<f32>) -> Self {
        let rows = matrix.rows();
        let pattern = BlockPattern::from_rows((0..rows as u32).map(|row| vec![row]));
        let mut smoother = Self {
            inverse: BlockMatrix::zeros(pattern, matrix.height, matrix.height),
            bound: 0.0,
        };
        smoother.refresh(source, matrix, None);
        smoother
    }

    /// Takes new values; `changed` tells the rows that are not as before, all if there is none.
    ///
    /// Where few rows changed, a larger eigenvalue can only belong to a vector that lives on them,
    /// so it is looked for there.
    pub(super) fn refresh(
        &mut self,
        source: &dyn BlockRows,
        matrix: &BlockMatrix<f32>,
        changed: Option<&[bool]>,
    ) {
        let is_changed = |row: usize| changed.is_none_or(|changed| changed[row]);
        let (size, pattern) = (matrix.height, &matrix.pattern);
        let mut rows = rows_of(&self.inverse.pattern, &mut self.inverse.values, size * size);
        parallel::each_with(
            &mut rows,
            ROWS_PER_TASK,
            Vec::new,
            |buffer, row, inverse| {
                if is_changed(row) {
                    source.load(row, buffer);
                    let own = pattern.find(row, row).unwrap_or(pattern.starts[row]);
                    let offset = (own - pattern.starts[row]) * size * size;
                    invert(&buffer[offset..][..size * size], size, inverse);
                }
            },
        );
        let found = MARGIN * self.largest_eigenvalue(matrix, is_changed);
        self.bound = if changed.is_some() {
            self.bound.max(found)
        } else {
            found
        };
    }

    /// Lanczos in the inner product of D, as the coefficients of conjugate gradients, on the
    /// chosen rows and columns.
    fn largest_eigenvalue(
        &self,
        matrix: &BlockMatrix<f32>,
        chosen: impl Fn(usize) -> bool + Sync,
    ) -> f64 {
        let length = matrix.rows() * matrix.height;
        let start = |i: usize| {
            if chosen(i / matrix.height) {
                noise(i)
            } else {
                0.0
            }
        };
        let scale = |x: &[f64], out: &mut [f64]| {
            self.inverse.apply_where(&chosen, x, out, Update::Set);
        };
        let mut residual: Vec<f64> = (0..length).map(start).collect();
        let (mut scaled, mut product) = (vec![0.0; length], vec![0.0; length]);
        scale(&residual, &mut scaled);
        let mut direction = scaled.clone();
        let mut size = dot(&residual, &scaled);
        let first = size;
        let mut lanczos = Lanczos::default();
        for _ in 0..STEPS {
            matrix.apply_where(&chosen, &direction, &mut product, Update::Set);
            let curvature = dot(&direction, &product);
            if size <= f64::EPSILON * first || curvature <= 0.0 {
                break;
            }
            let step = size / curvature;
            residual
                .iter_mut()
                .zip(&product)
                .for_each(|(r, p)| *r -= step * p);
            scale(&residual, &mut scaled);
            let ratio = dot(&residual, &scaled) / size;
            direction
                .iter_mut()
                .zip(&scaled)
                .for_each(|(d, s)| *d = s + ratio * *d);
            size *= ratio;
            lanczos.push(step, ratio);
        }
        lanczos.largest_eigenvalue()
    }

    /// D⁻¹ x.
    pub(super) fn scale(&self, x: &[f64], out: &mut [f64]) {
        self.inverse.apply(x, out, Update::Set);
    }

    /// The diagonal block of D⁻¹ of a row.
    pub(super) fn inverse_block(&self, row: usize) -> &[f64] {
        self.inverse.row_values(row)
    }

    /// Adds S r to x. With `keep_residual`, `r` becomes r − A S r; else its content is of no use
    /// afterwards. `work` is memory for two vectors.
    pub(super) fn smooth(
        &self,
        matrix: &BlockMatrix<f32>,
        polynomial: Polynomial,
        r: &mut [f64],
        x: &mut [f64],
        work: (&mut [f64], &mut [f64]),
        keep_residual: bool,
    ) {
        let (direction, scaled) = work;
        let (high, low) = (self.bound, self.bound / polynomial.ratio);
        let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = middle / half;
        let mut rho = 1.0 / sigma;
        let (mut carry, mut gain) = (0.0, 1.0 / middle);
        for step in 0..polynomial.degree {
            self.scale(r, scaled);
            advance(direction, scaled, x, carry, gain, step == 0);
            if keep_residual || step + 1 < polynomial.degree {
                matrix.apply(direction, r, Update::Subtract);
            }
            let next = 1.0 / (2.0 * sigma - rho);
            (carry, gain) = (next * rho, 2.0 * next / half);
            rho = next;
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.inverse.bytes()
    }
}

/// The tridiagonal matrix that steps of conjugate gradients build (Golub & Van Loan 2013, §11.3).
#[derive(Debug, Default)]
struct Lanczos {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    carried: f64,
}

impl Lanczos {
    /// Takes the step length of an iteration and the ratio of its residuals.
    fn push(&mut self, step: f64, ratio: f64) {
        self.diagonal.push(1.0 / step + self.carried);
        self.beside.push(ratio.max(0.0).sqrt() / step);
        self.carried = ratio / step;
    }

    /// 1, the eigenvalue of a diagonal matrix, if there was no step.
    fn largest_eigenvalue(&self) -> f64 {
        if self.diagonal.is_empty() {
            return 1.0;
        }
        largest_eigenvalue(&self.diagonal, &self.beside)
    }
}

/// d ← carry d + gain z, x ← x + d; at the first step d has no content yet.
fn advance(d: &mut [f64], z: &[f64], x: &mut [f64], carry: f64, gain: f64, first: bool) {
    let chunk = 4 * ROWS_PER_TASK;
    parallel::chunk_pairs((d, x), (chunk, chunk), 1, |task, d, x| {
        let z = &z[task * chunk..];
        for ((d, z), x) in d.iter_mut().zip(z).zip(x) {
            *d = if first {
                gain * z
            } else {
                carry * *d + gain * z
            };
            *x += *d;
        }
    });
}

/// Deterministic numbers in [−1, 1] without any pattern a matrix could share.
fn noise(index: usize) -> f64 {
    let mut hash = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    hash = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((hash ^ (hash >> 32)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}
