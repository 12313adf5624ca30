//! Linear systems of passes: the tangent, the solver, and what of it may lag.

use perifrac_solvers::{CsrView, Demand, LinearSolver, Problem};

use super::reuse::PreconditionerReuse;
use super::{DescentSettings, TangentMatrix, Trial, damage_of};
use crate::material::TangentKind;
use crate::model::SolidModel;
use crate::schemes::solid::{Chosen, build_solver};
use crate::schemes::{State, StepError};

/// The tangent of a solid that breaks, and the solver of systems with it, or with a matrix that contains it.
pub(crate) struct TangentSolver<const D: usize> {
    solver: Box<dyn LinearSolver>,
    /// The solver in use, and why.
    pub chosen: Chosen,
    /// The tangent.
    pub tangent: TangentMatrix<D>,
    reuse: PreconditionerReuse,
    /// Whether the matrix has moved since the last solve.
    moved: bool,
    /// Iterations so far.
    pub iterations: usize,
}

impl<const D: usize> TangentSolver<D> {
    /// Chooses and analyses the solver once.
    ///
    /// # Errors
    /// [`StepError`] if it is refused.
    pub(crate) fn new(
        demand: &Demand,
        problem: &Problem<'_>,
        solid: &SolidModel<D>,
        settings: &DescentSettings,
    ) -> Result<Self, StepError> {
        let (solver, chosen) = build_solver(&demand.spec, problem, &solid.timers)?;
        Ok(TangentSolver {
            solver,
            chosen,
            tangent: TangentMatrix::new(solid, settings),
            reuse: PreconditionerReuse::new(settings.preconditioner_renewal),
            moved: true,
            iterations: 0,
        })
    }

    /// Brings the tangent to a trial.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without damage.
    pub(crate) fn follow(
        &mut self,
        solid: &SolidModel<D>,
        state: &State,
        at: &Trial<D>,
        kind: TangentKind,
    ) -> Result<(), StepError> {
        let (response, damage) = (&at.response, damage_of(solid)?);
        let fields = state.view().damage(&response.fluid);
        self.moved |= self.tangent.update(solid, damage, fields, response, kind);
        Ok(())
    }

    /// Solution of the system of the displacement alone to a residual of `tolerance` relative to the force, m.
    ///
    /// # Errors
    /// [`StepError`] if the solver refuses.
    pub(crate) fn solve(&mut self, force: &[f64], tolerance: f64) -> Result<Vec<f64>, StepError> {
        let mut displacement = vec![0.0; force.len()];
        let matrix = self.tangent.matrix.view();
        let solver = &mut *self.solver;
        let moved = std::mem::take(&mut self.moved);
        let solved =
            (self.reuse).solve((solver, matrix, moved), force, &mut displacement, tolerance);
        self.took(solved)?;
        Ok(displacement)
    }

    /// Solution of a system with a matrix that contains the tangent and has been filled for it.
    ///
    /// # Errors
    /// [`StepError`] if the solver refuses.
    pub(crate) fn solve_with(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        tolerance: f64,
    ) -> Result<Vec<f64>, StepError> {
        let mut x = vec![0.0; rhs.len()];
        self.moved = false;
        let solved = (self.reuse).solve((&mut *self.solver, matrix, true), rhs, &mut x, tolerance);
        self.took(solved)?;
        Ok(x)
    }

    /// Counts a solve; a solver that refused starts anew.
    fn took(
        &mut self,
        solved: Result<usize, perifrac_solvers::SolveError>,
    ) -> Result<(), StepError> {
        if solved.is_err() {
            self.reuse.forget();
        }
        self.iterations += solved?;
        Ok(())
    }

    /// Forgets all that lags behind: it does so within a step only.
    pub(crate) fn begin_anew(&mut self) {
        self.tangent.forget();
        self.reuse.forget();
        self.solver.begin_anew();
        self.moved = true;
    }

    /// What the solver did.
    pub(crate) fn counters(&self) -> perifrac_solvers::SolverCounters {
        self.solver.counters().clone()
    }
}
