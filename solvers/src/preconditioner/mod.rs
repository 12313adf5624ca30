//! Preconditioners of the Krylov backends: one file each, chosen by the option `preconditioner`.
//!
//! A new one is one new module and one line in [`PRECONDITIONERS`].

mod block_jacobi;
mod dense;
mod ic0;
mod ilu0;
mod jacobi;
mod none;
mod scaling;
mod schur;
mod single;
mod stale;
mod table;
mod triangle;

pub(crate) use table::{Demand, build, count, find, words};
pub use table::{PRECONDITIONERS, PreconditionerInfo};

#[allow(dead_code, reason = "chosen by the Krylov driver")]
pub(crate) mod amg;

use crate::{CsrView, Problem, SolveError};

/// An approximate inverse M⁻¹ of one matrix at a time, with the stages of [`crate::LinearSolver`].
///
/// What is held may belong to an earlier matrix (a stale factor, a kept hierarchy): `refresh` then
/// does as little as possible, and the Krylov driver asks for more with [`Self::renew`] when a
/// solve takes longer than [`Self::patience`].
pub(crate) trait Preconditioner: Send {
    /// Takes the pattern. Its values are not read.
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError>;

    /// Takes new values on the analysed pattern.
    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError>;

    /// Sets `correction` to M⁻¹ `residual`. Allocates nothing; same bits for any number of threads.
    fn apply(&mut self, residual: &[f64], correction: &mut [f64]);

    /// Iterations of a solve after which renewing is cheaper than going on; `None` if what is held
    /// belongs wholly to the current matrix.
    fn patience(&self) -> Option<usize> {
        None
    }

    /// Rebuilds for the current matrix all that belongs to an earlier one.
    fn renew(&mut self, _matrix: CsrView<'_>) -> Result<(), SolveError> {
        Ok(())
    }

    /// Drops what belongs to earlier matrices: the next refresh builds all of it.
    fn begin_anew(&mut self) {}

    /// Told how many iterations a finished solve took.
    fn observe(&mut self, _iterations: usize) {}

    /// Whether M⁻¹ is symmetric positive definite, which CG and MINRES need.
    fn is_symmetric(&self) -> bool {
        true
    }

    /// Whether M⁻¹ differs between applications, which flexible methods alone allow.
    fn is_variable(&self) -> bool {
        false
    }

    /// What it has done and holds.
    fn work(&self) -> PreconditionerWork {
        PreconditionerWork::default()
    }
}

/// Work and memory of a preconditioner, for the counters of its solver.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PreconditionerWork {
    /// Numeric factorisations or full set-ups.
    pub(crate) factorisations: u64,
    /// Stored entries, 0 if it holds no matrix.
    pub(crate) nonzeros: u64,
    /// Bytes held.
    pub(crate) bytes: u64,
}

#[cfg(test)]
mod tests;
