//! Preconditioner `ic0`: Cholesky factor on the pattern of the matrix (Meijerink & van der Vorst
//! 1977, Math. Comput. 31, 148), of the matrix scaled to a diagonal of 1.
//!
//! Where a pivot fails, the diagonal is raised by a shift until all hold (Manteuffel 1980, Math.
//! Comput. 34, 473). The next matrix is tried with a quarter of the last shift first.

use super::scaling::by_diagonal;
use super::triangle::{LowerPattern, Shifts};
use super::{Preconditioner, PreconditionerWork};
use crate::matrix::Rows;
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError};

/// Smallest pivot, the diagonal being 1.
const SMALLEST_PIVOT: f64 = 1e-6;

pub(super) fn build(_options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(IncompleteCholesky::default()))
}

#[derive(Default)]
struct IncompleteCholesky {
    pattern: LowerPattern,
    /// Entries of L left of the diagonal.
    lower: Vec<f64>,
    /// Inverses of the diagonal of L.
    inverse: Vec<f64>,
    scale: Vec<f64>,
    /// A row of L as a full vector.
    row: Vec<f64>,
    shifts: Shifts,
    setups: u64,
}

impl IncompleteCholesky {
    /// Factors the scaled matrix with `1 + shift` on the diagonal. Fails with the row.
    fn factorise(&mut self, matrix: &CsrView<'_>, shift: f64) -> Result<(), usize> {
        let rows = Rows::new(matrix);
        for i in 0..matrix.rows() {
            let range = self.pattern.range(i);
            let (columns, values) = rows.row(i);
            let mut pivot = 1.0 + shift;
            for (position, (column, value)) in range.clone().zip(columns.iter().zip(values)) {
                let j = *column as usize;
                let (earlier, done) = (self.pattern.range(j), self.inverse[j]);
                let known: f64 = self.pattern.columns[earlier.clone()]
                    .iter()
                    .zip(&self.lower[earlier])
                    .map(|(k, entry)| entry * self.row[*k as usize])
                    .sum();
                let entry = (value * self.scale[i] * self.scale[j] - known) * done;
                self.row[j] = entry;
                self.lower[position] = entry;
                pivot -= entry * entry;
            }
            for column in &self.pattern.columns[range] {
                self.row[*column as usize] = 0.0;
            }
            // Written so that NaN fails.
            let usable = pivot > SMALLEST_PIVOT;
            if !usable {
                return Err(i);
            }
            self.inverse[i] = 1.0 / pivot.sqrt();
        }
        Ok(())
    }
}

impl Preconditioner for IncompleteCholesky {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        let unknowns = problem.unknowns();
        self.pattern = LowerPattern::new(problem.pattern);
        self.lower = vec![0.0; self.pattern.columns.len()];
        self.inverse = vec![0.0; unknowns];
        self.row = vec![0.0; unknowns];
        self.shifts = Shifts::default();
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.scale = by_diagonal(matrix);
        let mut shifts = self.shifts;
        let outcome = shifts.search(|shift| self.factorise(&matrix, shift));
        self.shifts = shifts;
        outcome.map_err(|(row, shift)| SolveError::IncompletePivot {
            preconditioner: "ic0",
            row,
            diagonal: Rows::new(&matrix).get(row, row),
            shift,
        })?;
        self.setups += 1;
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        for i in 0..residual.len() {
            let range = self.pattern.range(i);
            let entries = self.pattern.columns[range.clone()]
                .iter()
                .zip(&self.lower[range]);
            let known: f64 = entries
                .map(|(j, entry)| entry * correction[*j as usize])
                .sum();
            correction[i] = (residual[i] * self.scale[i] - known) * self.inverse[i];
        }
        for i in (0..residual.len()).rev() {
            let value = correction[i] * self.inverse[i];
            correction[i] = value * self.scale[i];
            let range = self.pattern.range(i);
            let entries = self.pattern.columns[range.clone()]
                .iter()
                .zip(&self.lower[range]);
            for (j, entry) in entries {
                correction[*j as usize] -= entry * value;
            }
        }
    }

    fn work(&self) -> PreconditionerWork {
        let nonzeros = (self.lower.len() + self.inverse.len()) as u64;
        PreconditionerWork {
            factorisations: self.setups,
            nonzeros,
            bytes: 8 * nonzeros + self.pattern.bytes(),
        }
    }
}
