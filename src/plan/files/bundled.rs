//! Arrays that come with the program, for its cases: `bundled:NAME` stands for a path.

use std::path::Path;

use super::FileError;

/// What names of bundled files begin with.
pub(crate) const BUNDLED: &str = "bundled:";

/// Name and content of every bundled file.
const FILES: &[(&str, &[u8])] = &[(
    "spe10-1.csv",
    include_bytes!("../../../cases/spe10-1/permeability.csv"),
)];

/// The content of a bundled file; nothing for a path of another kind.
///
/// # Errors
/// [`FileError::NotBundled`] with the names that there are.
pub(super) fn read(path: &Path) -> Result<Option<&'static [u8]>, FileError> {
    let Some(name) = path.to_str().and_then(|path| path.strip_prefix(BUNDLED)) else {
        return Ok(None);
    };
    let found = FILES.iter().find(|(own, _)| *own == name);
    match found {
        Some((_, bytes)) => Ok(Some(bytes)),
        None => Err(FileError::NotBundled {
            name: name.to_owned(),
            known: FILES.iter().map(|(own, _)| *own).collect(),
        }),
    }
}
