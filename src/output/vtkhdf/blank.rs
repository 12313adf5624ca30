//! What stands for files of VTKHDF in a program that cannot write them.

use std::path::Path;

use crate::output::{Field, OutputError, VtuData};

fn refuse(path: &Path) -> Result<(), OutputError> {
    Err(OutputError::Unsupported {
        path: path.to_owned(),
        what: "the format".to_owned(),
        found: "vtkhdf".to_owned(),
        allowed: "vtu in a program that was built without the feature `vtkhdf`",
    })
}

/// Begins a file.
///
/// # Errors
/// [`OutputError::Unsupported`], always.
pub fn create_vtkhdf(path: impl AsRef<Path>, _: &VtuData<'_>) -> Result<(), OutputError> {
    refuse(path.as_ref())
}

/// Adds an output.
///
/// # Errors
/// [`OutputError::Unsupported`], always.
pub fn append_vtkhdf(path: impl AsRef<Path>, _: f64, _: &[Field<'_>]) -> Result<(), OutputError> {
    refuse(path.as_ref())
}

/// Leaves out the last outputs.
///
/// # Errors
/// [`OutputError::Unsupported`], always.
pub fn cut_vtkhdf(path: impl AsRef<Path>, _: usize) -> Result<(), OutputError> {
    refuse(path.as_ref())
}
