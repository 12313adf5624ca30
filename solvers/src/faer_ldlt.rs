//! Backend `faer-ldlt`: sparse L D Lᵀ factorisation without pivoting, for quasi-definite systems.
//!
//! Such a matrix is positive definite in one block of unknowns and negative definite in the other.
//! Its factor exists for every ordering (Vanderbei 1995, SIAM J. Optim. 5, 100), but a tiny pivot
//! spoils it (Gill, Saunders & Shinnerl 1996, SIAM J. Matrix Anal. Appl. 17, 35). So the unknowns
//! of a point should list the negative block last, and every solution is checked by its residual.

use crate::cholesky::Kind;
use crate::direct::{Direct, ORDERING};
use crate::problem::Symmetry;
use crate::registry::{Backend, Options};
use crate::{LinearSolver, SpecError};

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: "faer-ldlt",
    summary: "sparse LDLT without pivoting (direct), ordering from the coordinates",
    symmetries: &[Symmetry::QuasiDefinite, Symmetry::PositiveDefinite],
    distributed: false,
    lattices_only: false,
    options: &[ORDERING],
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    Ok(Box::new(Direct::cholesky(&BACKEND, Kind::Ldlt, options)))
}

#[cfg(test)]
mod tests;
