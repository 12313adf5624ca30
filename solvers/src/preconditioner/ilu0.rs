//! Preconditioner `ilu0`: L U on the pattern of the matrix, scaled so that the diagonal is ±1 where
//! it is not zero (Saad, Iterative Methods for Sparse Linear Systems, 10.3).
//!
//! Where a pivot fails, every diagonal entry is moved away from zero by a growing shift. Note that a
//! symmetric matrix need not give positive pivots, so only `gmres` and its like can take it.
//!
//! It is made for transport-like matrices. A quasi-definite matrix with small storage gives tiny
//! pivots in the order of the points: with S = 0.01 K on 3000 points GMRES stagnates at once.

use super::scaling::by_diagonal;
use super::triangle::Shifts;
use super::{Preconditioner, PreconditionerWork};
use crate::matrix::Rows;
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError};

/// Smallest pivot, the diagonal being ±1.
const SMALLEST_PIVOT: f64 = 1e-6;
/// Marks columns that a row does not have.
const ABSENT: u32 = u32::MAX;

pub(super) fn build(_options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(IncompleteLu::default()))
}

#[derive(Default)]
struct IncompleteLu {
    starts: Vec<u32>,
    columns: Vec<u32>,
    /// Position of the diagonal entry of every row.
    diagonals: Vec<u32>,
    /// L without its diagonal of ones, and U with the inverse of its diagonal.
    values: Vec<f64>,
    scale: Vec<f64>,
    /// Position of every column in the row at work.
    positions: Vec<u32>,
    shifts: Shifts,
    setups: u64,
}

fn missing(row: usize, diagonal: f64, shift: f64) -> SolveError {
    SolveError::IncompletePivot {
        preconditioner: "ilu0",
        row,
        diagonal,
        shift,
    }
}

impl IncompleteLu {
    fn load(&mut self, matrix: &CsrView<'_>, shift: f64) {
        let rows = Rows::new(matrix);
        self.values.copy_from_slice(rows.values());
        for i in 0..self.diagonals.len() {
            for position in self.starts[i] as usize..self.starts[i + 1] as usize {
                let j = self.columns[position] as usize;
                self.values[position] *= self.scale[i] * self.scale[j];
            }
            let diagonal = &mut self.values[self.diagonals[i] as usize];
            *diagonal += shift.copysign(*diagonal);
        }
    }

    /// Factors the scaled matrix with the diagonal moved by `shift`. Fails with the row.
    fn factorise(&mut self, matrix: &CsrView<'_>, shift: f64) -> Result<(), usize> {
        self.load(matrix, shift);
        for i in 0..self.diagonals.len() {
            let range = self.starts[i] as usize..self.starts[i + 1] as usize;
            for position in range.clone() {
                self.positions[self.columns[position] as usize] = position as u32;
            }
            for position in range.start..self.diagonals[i] as usize {
                self.eliminate(position);
            }
            for position in range {
                self.positions[self.columns[position] as usize] = ABSENT;
            }
            let pivot = self.values[self.diagonals[i] as usize];
            if !pivot.is_finite() || pivot.abs() < SMALLEST_PIVOT {
                return Err(i);
            }
            self.values[self.diagonals[i] as usize] = 1.0 / pivot;
        }
        Ok(())
    }

    /// Subtracts the multiple of an earlier row that removes the entry at `position`.
    fn eliminate(&mut self, position: usize) {
        let k = self.columns[position] as usize;
        let diagonal = self.diagonals[k] as usize;
        let factor = self.values[position] * self.values[diagonal];
        self.values[position] = factor;
        for other in diagonal + 1..self.starts[k + 1] as usize {
            let target = self.positions[self.columns[other] as usize];
            if target != ABSENT {
                self.values[target as usize] -= factor * self.values[other];
            }
        }
    }
}

impl Preconditioner for IncompleteLu {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        let rows = Rows::new(&problem.pattern);
        self.starts = rows.starts().to_vec();
        self.columns = rows.columns().to_vec();
        let mut diagonals = Vec::with_capacity(problem.unknowns());
        for row in 0..problem.unknowns() {
            let found = rows.row(row).0.binary_search(&(row as u32));
            let offset = found.map_err(|_| missing(row, 0.0, 0.0))?;
            diagonals.push(self.starts[row] + offset as u32);
        }
        self.diagonals = diagonals;
        self.values = vec![0.0; self.columns.len()];
        self.positions = vec![ABSENT; problem.unknowns()];
        self.shifts = Shifts::default();
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.scale = by_diagonal(matrix);
        let mut shifts = self.shifts;
        let outcome = shifts.search(|shift| self.factorise(&matrix, shift));
        self.shifts = shifts;
        outcome.map_err(|(row, shift)| missing(row, Rows::new(&matrix).get(row, row), shift))?;
        self.setups += 1;
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        let entries = |range: std::ops::Range<usize>, x: &[f64]| -> f64 {
            let values = self.values[range.clone()].iter();
            let columns = &self.columns[range];
            values
                .zip(columns)
                .map(|(value, j)| value * x[*j as usize])
                .sum()
        };
        for i in 0..residual.len() {
            let left = self.starts[i] as usize..self.diagonals[i] as usize;
            correction[i] = residual[i] * self.scale[i] - entries(left, correction);
        }
        for i in (0..residual.len()).rev() {
            let diagonal = self.diagonals[i] as usize;
            let right = diagonal + 1..self.starts[i + 1] as usize;
            correction[i] = (correction[i] - entries(right, correction)) * self.values[diagonal];
        }
        for (correction, scale) in correction.iter_mut().zip(&self.scale) {
            *correction *= scale;
        }
    }

    fn is_symmetric(&self) -> bool {
        false
    }

    fn work(&self) -> PreconditionerWork {
        let nonzeros = self.values.len() as u64;
        let indices = self.starts.len() + self.columns.len() + self.diagonals.len();
        PreconditionerWork {
            factorisations: self.setups,
            nonzeros,
            bytes: 8 * nonzeros + 4 * indices as u64,
        }
    }
}
