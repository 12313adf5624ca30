//! Krylov methods behind one driver: a method iterates, the driver verifies.
//!
//! ```text
//! driver.rs    measures the true residual, restarts, renews what the preconditioner has kept
//! <method>.rs  one run from a given residual; says how it ended
//! ```
//!
//! A new method is one new module here and one line in [`crate::BACKENDS`].

mod advice;
pub(crate) mod bicgstab;
pub(crate) mod conjugate_gradient;
mod driver;
mod faer_adapter;
pub(crate) mod gmres;
mod hessenberg;
#[cfg(test)]
mod method_tests;
pub(crate) mod minres;
mod options;
#[cfg(test)]
mod tests;
mod vectors;

use crate::CsrView;
use crate::preconditioner::Preconditioner;

/// A Krylov method with its memory.
pub(crate) trait Method: Send {
    /// Takes the number of unknowns; allocates all memory.
    fn allocate(&mut self, unknowns: usize);

    /// Whether the preconditioner may differ between its applications.
    fn is_flexible(&self) -> bool {
        false
    }

    /// Improves `x` until the residual the recursion knows reaches `pass.target`, or until
    /// `pass.limit` iterations are done, or until it is interrupted. Allocates nothing.
    fn run(&mut self, pass: Pass<'_>, x: &mut [f64]) -> Run;
}

/// What one run starts from.
pub(crate) struct Pass<'a> {
    pub(crate) matrix: CsrView<'a>,
    pub(crate) preconditioner: &'a mut dyn Preconditioner,
    pub(crate) rhs: &'a [f64],
    /// b − A x of the x the run starts from; not zero.
    pub(crate) residual: &'a [f64],
    /// Norm of the residual to reach.
    pub(crate) target: f64,
    /// Most iterations, at least one.
    pub(crate) limit: usize,
}

/// How one run went.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    pub(crate) iterations: usize,
    pub(crate) end: End,
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// The recursion says that the target is reached.
    Reached,
    /// The limit on the iterations is met.
    Limit,
    /// The basis is full: start again from here, as long as that helps.
    Full,
    /// The iteration cannot be continued.
    Broken(Cause),
}

/// Why an iteration cannot be continued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// A direction of zero or negative curvature.
    NotDefinite,
    /// xᵀ M⁻¹ x ≤ 0 for some x.
    PreconditionerNotDefinite,
    /// The Krylov space is exhausted and holds no solution.
    Singular,
    /// The residual is orthogonal to the range of the matrix.
    LeastSquares,
    /// A scalar of the recursion, by which it divides, vanishes; other starts may do better.
    Orthogonal,
    /// NaN or infinity.
    Overflow,
}

impl Cause {
    /// The cause in words.
    pub(crate) fn describe(self) -> &'static str {
        match self {
            Self::NotDefinite => "the matrix or the preconditioner is not positive definite",
            Self::PreconditionerNotDefinite => "the preconditioner is not positive definite",
            Self::Singular => "the matrix is singular, and no correction of the residual is left",
            Self::LeastSquares => {
                "the matrix is singular and the right-hand side is not in its range"
            }
            Self::Orthogonal => "two vectors of the recursion became orthogonal",
            Self::Overflow => "a number overflowed",
        }
    }
}
