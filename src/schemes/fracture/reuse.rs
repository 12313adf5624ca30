//! When a preconditioner that lags behind its matrix is worth renewing.

use perifrac_solvers::{CsrView, LinearSolver, SolveError};

/// Iterations that renewing it costs, as measured with multigrid on 20 000 points.
const COST: usize = 16;

/// Iterations wasted since the preconditioner was renewed.
#[derive(Default)]
pub struct PreconditionerReuse {
    /// Iterations of the first solve after that; `None` if there was none yet.
    fresh: Option<usize>,
    wasted: usize,
}

impl PreconditionerReuse {
    /// Solves `matrix · x = rhs` from rest to a relative residual of `tolerance`; gives the iterations.
    /// What lags behind the matrix is renewed where that pays, and before a failure counts.
    ///
    /// # Errors
    /// [`SolveError`] of a solve with what belongs to the matrix.
    pub fn solve(
        &mut self,
        solver: &mut dyn LinearSolver,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<usize, SolveError> {
        // A factor of another matrix is none of this one: direct solvers have nothing that may lag.
        if !solver.is_direct() && self.may_lag() {
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
    pub fn forget(&mut self) {
        *self = PreconditionerReuse::default();
    }

    fn may_lag(&self) -> bool {
        self.fresh.is_some() && self.wasted < COST
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
    fn refreshes(direct: bool, most: usize) -> u64 {
        let mut solver = Lagging {
            direct,
            lag: 0,
            most,
            counters: SolverCounters::default(),
        };
        let matrix = CsrMatrix::zero((0, 0));
        let mut reuse = PreconditionerReuse::default();
        for _ in 0..9 {
            let solved = reuse.solve(&mut solver, matrix.view(), &[], &mut [], 1e-4);
            assert!(solved.is_ok());
        }
        solver.counters.refreshes
    }

    /// A direct solver may count its substitution as an iteration, as PETSc does; a lagging
    /// preconditioner is renewed once 6 + 12 iterations are wasted, every third solve.
    #[test]
    fn it_is_renewed_once_the_waste_outweighs_it_and_always_for_direct_solvers() {
        assert_eq!(refreshes(true, usize::MAX), 9);
        assert_eq!(refreshes(false, usize::MAX), 3);
    }

    #[test]
    fn a_solve_that_fails_with_what_lags_behind_is_done_again_with_what_does_not() {
        assert_eq!(refreshes(false, 0), 9);
        assert_eq!(refreshes(false, 1), 5);
    }
}
