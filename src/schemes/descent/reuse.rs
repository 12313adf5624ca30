//! When a preconditioner that lags behind its matrix is worth renewing.

use perifrac_solvers::{CsrView, LinearSolver, SolveError};

/// Iterations wasted since the preconditioner was renewed.
pub(crate) struct PreconditionerReuse {
    /// Iterations that renewing it costs.
    cost: usize,
    /// Iterations of the first solve after that; `None` if there was none yet.
    fresh: Option<usize>,
    wasted: usize,
}

impl PreconditionerReuse {
    /// Nothing is known yet; renewing costs so many iterations.
    pub(crate) fn new(cost: usize) -> Self {
        PreconditionerReuse {
            cost,
            fresh: None,
            wasted: 0,
        }
    }

    /// Solves `matrix · x = rhs` from rest to a relative residual of `tolerance`; gives the iterations.
    /// What lags behind a matrix that has `moved` is renewed where that pays, and before a failure counts.
    ///
    /// # Errors
    /// [`SolveError`] of a solve with what belongs to the matrix.
    pub(crate) fn solve(
        &mut self,
        (solver, matrix, moved): (&mut dyn LinearSolver, CsrView<'_>, bool),
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<usize, SolveError> {
        // A factor of another matrix is none of this one: direct solvers have nothing that may lag.
        let lags = moved && solver.is_direct();
        if !lags && self.may_lag() {
            x.fill(0.0);
            if let Ok(solved) = solver.solve_to(matrix, rhs, x, tolerance) {
                self.took(solved.iterations);
                return Ok(solved.iterations);
            }
        }
        self.forget();
        solver.refresh(matrix)?;
        x.fill(0.0);
        let solved = solver.solve_to(matrix, rhs, x, tolerance)?;
        self.took(solved.iterations);
        Ok(solved.iterations)
    }

    /// The next solve renews.
    pub(crate) fn forget(&mut self) {
        *self = PreconditionerReuse::new(self.cost);
    }

    fn may_lag(&self) -> bool {
        self.fresh.is_some() && self.wasted < self.cost
    }

    fn took(&mut self, iterations: usize) {
        match self.fresh {
            None => self.fresh = Some(iterations),
            Some(fresh) => self.wasted += iterations.saturating_sub(fresh),
        }
    }
}

#[cfg(test)]
mod tests {
    use perifrac_solvers::{CsrMatrix, Problem, SolveReport, SolverCounters};

    use super::*;

    /// Takes so many iterations, more the longer it lags, and fails where it lags too far.
    struct Lagging {
        direct: bool,
        lag: usize,
        most: usize,
        counters: SolverCounters,
    }

    impl LinearSolver for Lagging {
        fn name(&self) -> &'static str {
            "lagging"
        }

        fn analyse(&mut self, _problem: &Problem<'_>) -> Result<(), SolveError> {
            Ok(())
        }

        fn refresh(&mut self, _matrix: CsrView<'_>) -> Result<(), SolveError> {
            self.lag = 0;
            self.counters.refreshes += 1;
            Ok(())
        }

        fn solve_to(
            &mut self,
            _matrix: CsrView<'_>,
            _rhs: &[f64],
            _x: &mut [f64],
            _tolerance: f64,
        ) -> Result<SolveReport, SolveError> {
            if self.lag > self.most {
                return Err(SolveError::Singular { row: 0 });
            }
            let iterations = if self.direct { 1 } else { 20 + 6 * self.lag };
            self.lag += 1;
            Ok(SolveReport {
                iterations,
                true_residual: 0.0,
                scaled_residual: 0.0,
            })
        }

        fn is_direct(&self) -> bool {
            self.direct
        }

        fn counters(&self) -> &SolverCounters {
            &self.counters
        }
    }

    /// Refreshes of nine solves.
    fn refreshes(direct: bool, most: usize, moved: bool) -> u64 {
        let mut solver = Lagging {
            direct,
            lag: 0,
            most,
            counters: SolverCounters::default(),
        };
        let matrix = CsrMatrix::zero((0, 0));
        let mut reuse = PreconditionerReuse::new(16);
        for _ in 0..9 {
            let solved = reuse.solve((&mut solver, matrix.view(), moved), &[], &mut [], 1e-4);
            assert!(solved.is_ok());
        }
        solver.counters.refreshes
    }

    /// A direct solver may count its substitution as an iteration, as PETSc does; a lagging
    /// preconditioner is renewed once 6 + 12 iterations are wasted, every third solve.
    #[test]
    fn it_is_renewed_once_the_waste_outweighs_it_and_always_for_direct_solvers() {
        assert_eq!(refreshes(true, usize::MAX, true), 9);
        assert_eq!(refreshes(false, usize::MAX, true), 3);
        assert_eq!(
            refreshes(true, usize::MAX, false),
            1,
            "the factor is of this matrix"
        );
    }

    #[test]
    fn a_solve_that_fails_with_what_lags_behind_is_done_again_with_what_does_not() {
        assert_eq!(refreshes(false, 0, true), 9);
        assert_eq!(refreshes(false, 1, true), 5);
    }
}
