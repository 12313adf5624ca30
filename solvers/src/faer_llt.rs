//! Backend `faer-llt`: sparse Cholesky factorisation with iterative refinement.

use crate::cholesky::Kind;
use crate::direct::{Direct, ORDERING};
use crate::problem::Symmetry;
use crate::registry::{Backend, Options};
use crate::{LinearSolver, SpecError};

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: "faer-llt",
    summary: "sparse Cholesky (direct), ordering from the coordinates",
    symmetries: &[Symmetry::PositiveDefinite],
    distributed: false,
    lattices_only: false,
    options: &[ORDERING],
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    Ok(Box::new(Direct::cholesky(&BACKEND, Kind::Llt, options)))
}

#[cfg(test)]
mod tests;
