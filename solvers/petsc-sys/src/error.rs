//! What can go wrong, with the remedy.

/// Failure to load PETSc or of one of its functions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PetscError {
    /// No library under any of the names.
    #[error(
        "the library PETSc was not found (looked for {tried}); install it, on Debian and Ubuntu \
         with `apt-get install libpetsc-real-dev openmpi-bin`, or name its file in the \
         environment variable PERIFRAC_PETSC"
    )]
    NotFound {
        /// Names that were tried.
        tried: String,
    },
    /// The library is too old or too new.
    #[error("{path} is PETSc {found}; versions 3.18 to 3.23 can be used")]
    Version {
        /// Name of the library.
        path: String,
        /// Its version.
        found: String,
    },
    /// The library was built for other numbers.
    #[error(
        "{path} was built with {found}; use a build with real numbers in double precision and \
         32-bit integers, on Debian and Ubuntu `libpetsc-real-dev`"
    )]
    Build {
        /// Name of the library.
        path: String,
        /// What does not fit.
        found: String,
    },
    /// A function is missing from the library.
    #[error("the PETSc library has no function `{0}`; use versions 3.18 to 3.23")]
    Symbol(&'static str),
    /// It could not be started.
    #[error("PETSc did not start: {0}")]
    Start(String),
    /// It was shut down before.
    #[error("PETSc has been shut down and cannot be used again in this process")]
    Finished,
    /// A function reported an error.
    #[error("{function} reports error {code}: {message}")]
    Call {
        /// Name of the function.
        function: &'static str,
        /// PETSc's code.
        code: i32,
        /// PETSc's message.
        message: String,
    },
    /// Something given by the caller does not fit.
    #[error("{0}")]
    Input(String),
}
