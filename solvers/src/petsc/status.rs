//! Whether PETSc is there, and which.

use perifrac_petsc_sys::run;

use super::options::Flags;
use super::outcome::petsc_error;
use crate::SolveError;

/// The PETSc in use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PetscStatus {
    /// Version, as in `3.18.5`.
    pub version: String,
    /// File of the library.
    pub path: String,
    /// External packages it was built with, of those that matter here.
    pub packages: Vec<&'static str>,
    /// Number of this process, from 0.
    pub process: usize,
    /// Number of processes.
    pub processes: usize,
}

/// Opens and starts PETSc, if it is not yet, and says which it is.
///
/// # Errors
/// [`SolveError::Unavailable`] with the reason and what to install.
pub fn petsc_status() -> Result<PetscStatus, SolveError> {
    let info = run(|session| session.info().clone());
    let info = info.map_err(|error| petsc_error(error, &Flags::parse("")))?;
    Ok(PetscStatus {
        version: info.version,
        path: info.path,
        packages: info.packages,
        process: info.rank,
        processes: info.size,
    })
}
