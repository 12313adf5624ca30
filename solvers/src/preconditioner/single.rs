//! Preconditioner `f32`: the factor of the current matrix in single precision.
//!
//! The rows are scaled first, so that contrasts of stiffness, however large, do not reach the limits
//! of the numbers. What is left of the condition costs a few iterations of the outer method. Where it costs many, a
//! factor in double precision takes over for that matrix.

use super::scaling::by_largest;
use super::{Preconditioner, PreconditionerWork};
use crate::cholesky::{CholeskyFactor, Kind, Ordering};
use crate::matrix::Rows;
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError};

/// Shares of the diagonal that are added to it until the factor exists: single precision resolves
/// 6e-8, so a nearly singular positive definite matrix may need one.
const SHIFTS: [f64; 4] = [0.0, 1e-6, 1e-5, 1e-4];

/// Iterations of a solve after which a factor in double precision is cheaper: one costs seven to ten of them in plane
/// coupled systems of 5,000 to 20,000 points, and solves with a fresh factor take two to fifteen.
const PATIENCE: usize = 30;

pub(super) fn build(_options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(Single {
        factor: None,
        double: None,
        exact: false,
        kind: Kind::Llt,
        values: Vec::new(),
        scale: Vec::new(),
        work: Vec::new(),
        factorisations: 0,
    }))
}

struct Single {
    factor: Option<CholeskyFactor<f32>>,
    /// Made where single precision does not do.
    double: Option<CholeskyFactor<f64>>,
    /// The factor in double precision belongs to the current matrix.
    exact: bool,
    kind: Kind,
    /// Values of the scaled matrix, kept for the next one.
    values: Vec<f32>,
    scale: Vec<f64>,
    work: Vec<f32>,
    factorisations: u64,
}

impl Single {
    fn load(&mut self, matrix: &CsrView<'_>, shift: f64) {
        let rows = Rows::new(matrix);
        let mut position = 0;
        for row in 0..matrix.rows() {
            let (columns, values) = rows.row(row);
            for (column, value) in columns.iter().zip(values) {
                let column = *column as usize;
                let scaled = value * self.scale[row] * self.scale[column];
                let raised = if row == column {
                    scaled * (1.0 + shift)
                } else {
                    scaled
                };
                self.values[position] = raised as f32;
                position += 1;
            }
        }
    }
}

impl Preconditioner for Single {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.factor = None;
        self.double = None;
        self.exact = false;
        self.kind = Kind::of(problem.symmetry);
        let factor = CholeskyFactor::analyse(problem, self.kind, Ordering::Automatic)?;
        self.values = vec![0.0; problem.pattern.nnz()];
        self.work = vec![0.0; problem.unknowns()];
        self.factor = Some(factor);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.exact = false;
        self.scale = by_largest(matrix);
        let mut outcome = Ok(());
        for shift in SHIFTS {
            self.load(&matrix, shift);
            let Some(factor) = &mut self.factor else {
                return Ok(());
            };
            outcome = factor.factorise_values(matrix, &self.values);
            if outcome.is_ok() {
                self.factorisations += 1;
                return Ok(());
            }
        }
        // Double precision may do, or names the row as it is.
        outcome.or_else(|_| self.renew(matrix))
    }

    fn patience(&self) -> Option<usize> {
        (!self.exact).then_some(PATIENCE)
    }

    fn renew(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        if self.double.is_none() {
            let factor = self.factor.as_ref();
            self.double = factor
                .map(CholeskyFactor::in_double_precision)
                .transpose()?;
        }
        if let Some(double) = &mut self.double {
            double.factorise(matrix)?;
            self.factorisations += 1;
            self.exact = true;
        }
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        if let Some(double) = self.double.as_mut().filter(|_| self.exact) {
            correction.copy_from_slice(residual);
            double.solve_in_place(correction);
            return;
        }
        let scaled = residual.iter().zip(&self.scale).map(|(r, scale)| r * scale);
        let largest = scaled
            .clone()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        if largest <= 0.0 {
            correction.fill(0.0);
            return;
        }
        for (work, value) in self.work.iter_mut().zip(scaled) {
            *work = (value / largest) as f32;
        }
        if let Some(factor) = &mut self.factor {
            factor.solve_in_place(&mut self.work);
        }
        let solved = self.work.iter().zip(&self.scale);
        for (correction, (value, scale)) in correction.iter_mut().zip(solved) {
            *correction = f64::from(*value) * scale * largest;
        }
    }

    fn is_symmetric(&self) -> bool {
        self.kind == Kind::Llt
    }

    fn work(&self) -> PreconditionerWork {
        let size = self.factor.as_ref().map(CholeskyFactor::prediction);
        let double = self.double.as_ref().map(CholeskyFactor::prediction);
        PreconditionerWork {
            factorisations: self.factorisations,
            nonzeros: size.map_or(0, |size| size.nonzeros),
            bytes: size.map_or(0, |size| size.bytes) + double.map_or(0, |size| size.bytes),
        }
    }
}
