//! The folder of a run: what in it are results and may be replaced.

use std::path::{Path, PathBuf};

use crate::output::{OutputError, write_atomically};

const MARK: &str = "resolved.toml";

/// Starts of the names of results.
const RESULTS: [&str; 9] = [
    "fields",
    "pressure-",
    "displacement-",
    "damage",
    "permeability",
    "history",
    "profile-",
    "crack-",
    "summary.json",
];

/// Makes the folder if need be; gives what is in it, which must be results.
///
/// # Errors
/// [`OutputError::Foreign`] for other things in it, else why it cannot be used.
pub fn prepare(folder: &Path) -> Result<Vec<PathBuf>, OutputError> {
    let io = |source: std::io::Error| OutputError::from_io(folder, "prepare the folder", source);
    if !folder.exists() {
        std::fs::create_dir_all(folder).map_err(io)?;
    }
    let entries: Vec<PathBuf> = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| entry.map(|e| e.path())).collect())
        .map_err(io)?;
    if !entries.is_empty() && !folder.join(MARK).exists() {
        return Err(OutputError::Foreign {
            path: folder.to_owned(),
        });
    }
    Ok(entries)
}

/// Removes the results of an earlier run; the mark is replaced afterwards.
///
/// # Errors
/// As [`prepare`].
pub fn clear(folder: &Path) -> Result<(), OutputError> {
    let io = |source: std::io::Error| OutputError::from_io(folder, "prepare the folder", source);
    for path in prepare(folder)?.iter().filter(|path| is_result(path)) {
        std::fs::remove_file(path).map_err(io)?;
    }
    Ok(())
}

/// Writes the resolved scene, which also marks the folder as one of results.
///
/// # Errors
/// Those of [`write_atomically`].
pub fn write_mark(folder: &Path, resolved: &str) -> Result<(), OutputError> {
    write_atomically(folder.join(MARK), |file| {
        file.write_all(resolved.as_bytes())
    })
}

fn is_result(path: &Path) -> bool {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    path.is_file() && RESULTS.iter().any(|start| name.starts_with(start))
}
