//! Direct solution on the coarsest level.

use super::block::BlockRows;
use crate::cholesky::{CholeskyFactor, Kind, Ordering};
use crate::problem::{Problem, Symmetry};
use crate::{CsrMatrix, SolveError};

/// Relative shifts of the diagonal tried one after the other. A coarse matrix is singular to
/// rounding where a part of the body hardly hangs on the rest.
const SHIFTS: [f64; 6] = [0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6];

/// A Cholesky factor of the coarsest matrix.
pub(super) struct Coarsest {
    factor: CholeskyFactor<f64>,
    matrix: CsrMatrix,
}

impl Coarsest {
    pub(super) fn new(source: &dyn BlockRows) -> Result<Self, SolveError> {
        let matrix = pattern_of(source);
        let problem = Problem::new(matrix.view(), Symmetry::PositiveDefinite, 1);
        let factor = CholeskyFactor::analyse(&problem, Kind::Llt, Ordering::MinimumDegree)?;
        let mut coarsest = Self { factor, matrix };
        coarsest.refresh(source)?;
        Ok(coarsest)
    }

    /// Factorises new values.
    pub(super) fn refresh(&mut self, source: &dyn BlockRows) -> Result<(), SolveError> {
        fill(&mut self.matrix, source);
        let mut outcome = Ok(());
        for (index, shift) in SHIFTS.iter().enumerate() {
            if index > 0 {
                add_relative_shift(&mut self.matrix, *shift);
            }
            outcome = self.factor.factorise(self.matrix.view());
            if outcome.is_ok() {
                break;
            }
        }
        outcome
    }

    pub(super) fn unknowns(&self) -> usize {
        self.matrix.rows()
    }

    pub(super) fn nonzeros(&self) -> u64 {
        self.factor.prediction().nonzeros
    }

    pub(super) fn bytes(&self) -> usize {
        self.factor.prediction().bytes as usize + 12 * self.matrix.nnz()
    }

    /// Overwrites a right-hand side by the solution.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        self.factor.solve_in_place(x);
    }
}

/// The scalar pattern of a block matrix, with values of zero.
fn pattern_of(source: &dyn BlockRows) -> CsrMatrix {
    let (pattern, (size, _)) = (source.pattern(), source.shape());
    let unknowns = pattern.rows() * size;
    let entries = pattern.columns.len() * size * size;
    let mut starts = Vec::with_capacity(unknowns + 1);
    let mut columns = Vec::with_capacity(entries);
    starts.push(0);
    for row in 0..pattern.rows() {
        for _ in 0..size {
            for block in pattern.row(row) {
                columns.extend((0..size as u32).map(|local| block * size as u32 + local));
            }
            starts.push(columns.len() as u32);
        }
    }
    CsrMatrix::new((unknowns, unknowns), starts, columns, vec![0.0; entries])
}

fn fill(matrix: &mut CsrMatrix, source: &dyn BlockRows) {
    let (pattern, (size, _)) = (source.pattern(), source.shape());
    let (data, mut buffer) = (matrix.data_mut(), Vec::new());
    for row in 0..pattern.rows() {
        source.load(row, &mut buffer);
        let range = pattern.range(row);
        let length = range.len() * size;
        let rows = data[range.start * size * size..][..length * size].chunks_exact_mut(length);
        for (local, out) in rows.enumerate() {
            let lines = buffer.chunks_exact(size).skip(local).step_by(size);
            for (out, line) in out.chunks_exact_mut(size).zip(lines) {
                out.copy_from_slice(line);
            }
        }
    }
}

fn add_relative_shift(matrix: &mut CsrMatrix, shift: f64) {
    for (row, mut vector) in matrix.outer_iterator_mut().enumerate() {
        if let Some(diagonal) = vector.get_mut(row) {
            *diagonal += shift * diagonal.abs();
        }
    }
}
