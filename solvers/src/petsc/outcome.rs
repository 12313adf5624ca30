//! What PETSc reports, in the terms of this crate.

use perifrac_petsc_sys::{Failure, PetscError};

use super::NAME;
use super::engine::SetUp;
use super::options::Flags;
use crate::SolveError;

/// The error behind a failed call.
pub(crate) fn petsc_error(error: PetscError, flags: &Flags) -> SolveError {
    match error {
        PetscError::Call { .. } | PetscError::Input(_) => SolveError::External {
            solver: NAME,
            message: error.to_string(),
            options: match flags.text.as_str() {
                "" => "(none given)".into(),
                text => text.into(),
            },
        },
        _ => SolveError::Unavailable {
            solver: NAME,
            reason: error.to_string(),
        },
    }
}

/// Whether a set-up can be used.
pub(crate) fn of_set_up(set_up: &SetUp) -> Result<(), SolveError> {
    if let Some(failure) = set_up.failure {
        let stage = if set_up.direct {
            "the factorisation"
        } else {
            "setting up the preconditioner"
        };
        return Err(failed(stage, failure));
    }
    of_flags(&set_up.missed)
}

/// Whether all flags were read.
pub(crate) fn of_flags(missed: &[String]) -> Result<(), SolveError> {
    if missed.is_empty() {
        return Ok(());
    }
    Err(SolveError::UnusedFlags {
        solver: NAME,
        flags: missed.join(", "),
    })
}

/// Whether a solve that failed may be followed by another pass.
pub(crate) fn of_solve(failure: Failure, iterations: usize) -> Result<(), SolveError> {
    match failure {
        // The residual measured afterwards decides.
        Failure::Iterations | Failure::Divergence => Ok(()),
        Failure::IndefinitePreconditioner => Err(broke_down(
            "the preconditioner is not positive definite",
            iterations,
        )),
        Failure::IndefiniteMatrix => Err(broke_down(
            "the matrix is not positive definite",
            iterations,
        )),
        other => Err(failed("the iteration", other)),
    }
}

fn broke_down(cause: &'static str, iterations: usize) -> SolveError {
    SolveError::Breakdown {
        method: NAME,
        iterations,
        cause,
        advice: "try petsc:-ksp_type minres or -ksp_type gmres, or `faer-llt`, which names the row"
            .into(),
    }
}

fn failed(stage: &'static str, failure: Failure) -> SolveError {
    let reason = match failure {
        Failure::ZeroPivot => "a pivot is zero".to_string(),
        Failure::OutOfMemory => "there is not enough memory".to_string(),
        Failure::NotFinite => "a number became infinite or undefined".to_string(),
        Failure::NotSymmetric => "the method needs a symmetric matrix".to_string(),
        Failure::Breakdown => "the method broke down".to_string(),
        Failure::Preconditioner => "the preconditioner failed".to_string(),
        Failure::Other(number) => format!("PETSc gives reason {number}"),
        other => format!("{other:?}"),
    };
    let advice = match failure {
        Failure::ZeroPivot => {
            "prescribe enough values to exclude rigid motion or a free constant, and check that \
             every unknown has an equation"
        }
        Failure::OutOfMemory => "use an iterative method, as in petsc:-ksp_type cg -pc_type gamg",
        _ => "try another method or preconditioner, as in petsc:-ksp_type preonly -pc_type lu",
    };
    SolveError::Failed {
        solver: NAME,
        stage,
        reason,
        advice,
    }
}
