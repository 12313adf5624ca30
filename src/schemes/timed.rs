//! A linear solver whose work is timed by phase.

use perifrac_solvers::{CsrView, LinearSolver, Problem, SolveError, SolveReport, SolverCounters};

use crate::report::Timers;

/// Adds the time of every stage of a solver to its phase: `analysis`, `factor` (factors and
/// preconditioners), and `substitution` with a factor or `krylov` iterations.
pub(super) struct TimedSolver {
    solver: Box<dyn LinearSolver>,
    timers: Timers,
}

impl TimedSolver {
    /// Times `solver`.
    pub(super) fn new(solver: Box<dyn LinearSolver>, timers: Timers) -> Self {
        TimedSolver { solver, timers }
    }
}

impl LinearSolver for TimedSolver {
    fn name(&self) -> &'static str {
        self.solver.name()
    }

    fn is_direct(&self) -> bool {
        self.solver.is_direct()
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        let solver = &mut self.solver;
        self.timers.time("analysis", || solver.analyse(problem))
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let solver = &mut self.solver;
        self.timers.time("factor", || solver.refresh(matrix))
    }

    fn begin_anew(&mut self) {
        self.solver.begin_anew();
    }

    fn solve_to(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport, SolveError> {
        let phase = if self.is_direct() {
            "substitution"
        } else {
            "krylov"
        };
        let solver = &mut self.solver;
        let work = || solver.solve_to(matrix, rhs, x, tolerance);
        self.timers.time(phase, work)
    }

    fn counters(&self) -> &SolverCounters {
        self.solver.counters()
    }
}
