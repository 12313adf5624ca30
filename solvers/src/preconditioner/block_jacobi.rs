//! Preconditioner `block-jacobi`: the diagonal blocks of the points.
//!
//! A symmetric block is replaced by the positive definite one with the absolute values of its
//! eigenvalues, after its rows are scaled by the diagonal so that units do not matter.

use super::scaling::magnitudes;
use super::{Preconditioner, PreconditionerWork, dense};
use crate::matrix::Rows;
use crate::parallel;
use crate::problem::Symmetry;
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError};

/// Points per parallel task: large enough to hide the cost of a task.
const POINTS_PER_TASK: usize = 512;

pub(super) fn build(_options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(BlockJacobi {
        symmetric: true,
        per_point: 1,
        inverses: Vec::new(),
        setups: 0,
    }))
}

struct BlockJacobi {
    symmetric: bool,
    per_point: usize,
    /// Inverse blocks by rows, point after point.
    inverses: Vec<f64>,
    setups: u64,
}

impl Preconditioner for BlockJacobi {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.symmetric = problem.symmetry != Symmetry::General;
        self.per_point = problem.unknowns_per_point;
        self.inverses = vec![0.0; problem.unknowns() * self.per_point];
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let (rows, sizes, size) = (Rows::new(&matrix), magnitudes(matrix), self.per_point);
        let symmetric = self.symmetric;
        let invert = |point: usize, inverse: &mut [f64]| {
            let first = point * size;
            let scale = |i: usize| 1.0 / sizes[first + i].sqrt();
            let mut block = vec![0.0; size * size];
            for (index, entry) in block.iter_mut().enumerate() {
                let (i, j) = (index / size, index % size);
                *entry = rows.get(first + i, first + j) * scale(i) * scale(j);
            }
            if symmetric {
                dense::invert_absolute(&mut block, size, inverse);
            } else {
                dense::invert(&mut block, size, inverse);
            }
            for (index, entry) in inverse.iter_mut().enumerate() {
                *entry *= scale(index / size) * scale(index % size);
            }
        };
        parallel::chunks(&mut self.inverses, size * size, POINTS_PER_TASK, invert);
        self.setups += 1;
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        let size = self.per_point;
        parallel::chunks(correction, size, POINTS_PER_TASK, |point, correction| {
            let residual = &residual[point * size..][..size];
            let inverse = &self.inverses[point * size * size..][..size * size];
            for (correction, row) in correction.iter_mut().zip(inverse.chunks(size)) {
                *correction = row.iter().zip(residual).map(|(a, r)| a * r).sum();
            }
        });
    }

    fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    fn work(&self) -> PreconditionerWork {
        let nonzeros = self.inverses.len() as u64;
        PreconditionerWork {
            factorisations: self.setups,
            nonzeros,
            bytes: 8 * nonzeros,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{jittered_grid, noisy_vector, positive_definite, wide_stencil};

    #[test]
    fn it_solves_a_matrix_of_blocks_exactly() {
        let cloud = jittered_grid(5, 4, 0.2);
        let mut a = wide_stencil(&cloud, 3, 2.3, 1);
        for (row, mut vector) in a.outer_iterator_mut().enumerate() {
            for (column, value) in vector.iter_mut() {
                if row / 3 != column / 3 {
                    *value = 0.0;
                }
            }
        }
        let mut blocks = build(&Options::new(&crate::krylov::gmres::BACKEND, &[])).unwrap();
        blocks
            .analyse(&positive_definite(&a, Some(&cloud), 3))
            .unwrap();
        blocks.refresh(a.view()).unwrap();
        let x = noisy_vector(a.rows());
        let (mut b, mut found) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        crate::multiply(a.view(), &x, &mut b);
        blocks.apply(&b, &mut found);
        assert!(crate::test_support::relative_error(&found, &x) < 1e-11);
        assert_eq!(blocks.work().nonzeros, 20 * 9);
    }
}
