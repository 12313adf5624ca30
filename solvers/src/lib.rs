//! Sparse linear solvers behind one trait.
//!
//! A system is analysed once per sparsity pattern, refreshed whenever its values change, and
//! then solved for one right-hand side at a time:
//!
//! ```text
//! SolverSpec ("faer-cg:preconditioner=stale") ── build ──▶ Box<dyn LinearSolver>
//! Problem (pattern, symmetry, coordinates)   ── analyse ─▶ ordering and symbolic factorisation
//! CsrView (values)                           ── refresh ─▶ numeric factor or preconditioner
//! right-hand side, initial guess             ── solve ───▶ solution, SolveReport
//! ```
//!
//! Every solution is checked against the residual computed afresh from the matrix, and every
//! result has the same bits for any number of threads. The crate knows nothing of the physics.
//!
//! A new backend is one new module and one line in [`BACKENDS`], a new preconditioner of the Krylov
//! backends one module and one line in [`PRECONDITIONERS`].

#![warn(unreachable_pub)]

mod auto;
mod cholesky;
mod direct;
mod error;
mod estimate;
mod faer_ldlt;
mod faer_llt;
mod faer_lu;
mod fourier;
mod interrupt;
mod krylov;
mod lattice;
mod matrix;
mod ordering;
pub mod parallel;
mod partition;
mod petsc;
mod preconditioner;
mod problem;
mod registry;
mod repeated;
mod report;
mod share;
#[cfg(test)]
mod shelf_tests;
mod spec;
mod system;
mod team;
#[cfg(test)]
mod test_support;

pub use auto::{Choice, choose};
pub use cholesky::predict;
pub use error::{SolveError, SpecError};
pub use estimate::{FactorEstimate, Outline};
pub use interrupt::{Interrupt, interrupted};
pub use lattice::{Lattice, LatticeAxis, Mirror};
pub use matrix::{CsrMatrix, CsrView, dot, is_symmetric, magnitude, multiply, norm2, residual};
pub use ordering::{Permutation, nested_dissection};
pub use partition::Partition;
pub use petsc::{
    PetscStatus, abort as petsc_abort, finish as petsc_finish, petsc_status, petsc_team,
};
pub use preconditioner::{PRECONDITIONERS, PreconditionerInfo};
pub use problem::{Coordinates, NearNullspace, Problem, Symmetry};
pub use registry::{BACKENDS, Backend, OptionSpec, OptionValue, Options};
pub use repeated::RepeatedRows;
pub use report::{FactorPrediction, SolveReport, SolverCounters};
pub use spec::{Demand, SolverSpec};
pub use team::{Communicator, thread_team};

/// A linear solver for one sparsity pattern at a time: analyse, refresh, solve.
///
/// The three stages must be called in this order; `refresh` and `solve` may then be repeated
/// as often as values or right-hand sides change.
pub trait LinearSolver: Send {
    /// The name of the backend that does the work, as it stands in [`BACKENDS`].
    fn name(&self) -> &'static str;

    /// Takes the sparsity pattern: ordering and symbolic factorisation. The values of
    /// `problem.pattern` are not read. Call it again only when the pattern changes.
    ///
    /// # Errors
    /// [`SolveError::Refused`] if the backend cannot treat this symmetry, and the errors of
    /// [`Problem::validate`].
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError>;

    /// Takes new values on the analysed pattern: numeric factorisation or preconditioner.
    ///
    /// # Errors
    /// [`SolveError::NotAnalysed`], [`SolveError::PatternChanged`], [`SolveError::NotFinite`],
    /// [`SolveError::Singular`], [`SolveError::NotPositiveDefinite`], [`SolveError::ZeroPivot`],
    /// [`SolveError::IncompletePivot`].
    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError>;

    /// Drops what was learned from earlier matrices, so that the next refresh, which must follow, builds
    /// everything from its own matrix: kept factors, aggregates and the like.
    fn begin_anew(&mut self) {}

    /// Solves `matrix · x = rhs`. `matrix` must be the one last given to `refresh`, or, for a solver
    /// that is not [direct](LinearSolver::is_direct), one on the same pattern that differs little.
    ///
    /// `x` holds the initial guess on entry (iterative backends only) and the solution on
    /// return. After an error its content is of no use.
    ///
    /// # Errors
    /// [`SolveError::NotConverged`], [`SolveError::Stagnated`], [`SolveError::Breakdown`],
    /// [`SolveError::Inaccurate`] and the errors of `refresh`.
    fn solve(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<SolveReport, SolveError> {
        self.solve_to(matrix, rhs, x, 0.0)
    }

    /// As [`LinearSolver::solve`], for a correction of which few digits matter: iterative backends
    /// stop at a relative residual of `tolerance` where that is more than their own.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    fn solve_to(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport, SolveError>;

    /// Whether solutions are those of a factorisation. A direct solver must be refreshed with every
    /// change of the values; an iterative one also solves with a preconditioner that lags behind them.
    /// Known once a pattern is analysed.
    fn is_direct(&self) -> bool;

    /// What the solver has done since it was built.
    fn counters(&self) -> &SolverCounters;
}
