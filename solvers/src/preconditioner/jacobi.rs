//! Preconditioner `jacobi`: the diagonal, by absolute value if the matrix is symmetric, so that it
//! is positive definite.

use super::Preconditioner;
use super::scaling::magnitudes;
use crate::parallel;
use crate::problem::Symmetry;
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError, matrix};

/// Entries per parallel task: large enough to hide the cost of a task.
const ENTRIES_PER_TASK: usize = 4096;

pub(super) fn build(_options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(Jacobi {
        signed: false,
        inverse: Vec::new(),
    }))
}

struct Jacobi {
    signed: bool,
    inverse: Vec<f64>,
}

impl Preconditioner for Jacobi {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.signed = problem.symmetry == Symmetry::General;
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.inverse = magnitudes(matrix).iter().map(|size| 1.0 / size).collect();
        if self.signed {
            for (inverse, diagonal) in self.inverse.iter_mut().zip(matrix::diagonal(matrix)) {
                *inverse = inverse.copysign(diagonal);
            }
        }
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        parallel::chunks(correction, ENTRIES_PER_TASK, 1, |task, correction| {
            let first = task * ENTRIES_PER_TASK;
            let given = residual[first..].iter().zip(&self.inverse[first..]);
            for (correction, (residual, inverse)) in correction.iter_mut().zip(given) {
                *correction = inverse * residual;
            }
        });
    }

    fn is_symmetric(&self) -> bool {
        !self.signed
    }
}
