//! The one error type of the output writers.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a file could not be written or read back; every message names the file and the remedy.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The device holding the file has no room, or a quota is used up.
    #[error(
        "{path}: no space left on the device; free some space or choose another output directory"
    )]
    DiskFull {
        /// The file that was being written.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The user may not write there, or the file system is read-only.
    #[error(
        "{path}: the directory or file is not writable; change its permissions or choose another \
         output directory"
    )]
    NotWritable {
        /// The file that was being written.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file, or the directory it should go into, does not exist.
    #[error("{path}: file or directory not found; create the directory or correct the path")]
    NotFound {
        /// The file that was asked for.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file was wanted where a directory already stands.
    #[error("{path} is a directory; give the name of a file inside it, or remove it")]
    IsDirectory {
        /// The directory.
        path: PathBuf,
    },
    /// A folder that holds something other than results.
    #[error(
        "{path} is not empty and holds no results of perifrac; choose another folder with --out, or \
         empty it"
    )]
    Foreign {
        /// The folder.
        path: PathBuf,
    },
    /// A folder into which another run writes now.
    #[error(
        "{path} is in use: process {process} is writing there; wait until it has ended, end it, or choose \
         another folder with --out"
    )]
    Busy {
        /// The folder.
        path: PathBuf,
        /// Number of the process.
        process: u32,
    },
    /// Any other failure of the operating system.
    #[error("{path}: could not {action}: {source}; check the path and the device, then try again")]
    Io {
        /// The file concerned.
        path: PathBuf,
        /// What was being done, as a verb phrase.
        action: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The arrays handed over do not fit together.
    #[error(
        "{path}: {what} needs {expected} values but has {found}; pass arrays of matching length"
    )]
    Shape {
        /// The file that was to be written.
        path: PathBuf,
        /// The array concerned.
        what: String,
        /// Number of values it should have.
        expected: usize,
        /// Number of values it has.
        found: usize,
    },
    /// An argument is outside what the format can hold.
    #[error("{path}: {what} is {found}; it must be {allowed}")]
    Unsupported {
        /// The file that was to be written.
        path: PathBuf,
        /// The argument concerned.
        what: String,
        /// Its value.
        found: String,
        /// The values that are possible.
        allowed: &'static str,
    },
    /// A file being read back is not what this program writes.
    #[error("{path}, line {line}: {reason}; repair or delete the file")]
    Malformed {
        /// The file that was read.
        path: PathBuf,
        /// Line number, counted from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A value could not be turned into JSON.
    #[error("{path}: the value cannot be written as JSON: {source}; map keys must be text")]
    Json {
        /// The file that was to be written.
        path: PathBuf,
        /// The error of the serializer.
        source: serde_json::Error,
    },
    /// A picture could not be drawn.
    #[error(
        "{path}: the plot could not be drawn: {reason}; choose another size or leave plots out"
    )]
    Drawing {
        /// The picture that was to be written.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
}

impl OutputError {
    /// Sorts an error of the operating system into the variant whose remedy fits.
    pub(crate) fn from_io(path: &Path, action: &'static str, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                Self::DiskFull { path, source }
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                Self::NotWritable { path, source }
            }
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                Self::NotFound { path, source }
            }
            io::ErrorKind::IsADirectory => Self::IsDirectory { path },
            _ => Self::Io {
                path,
                action,
                source,
            },
        }
    }

    /// Fails with [`OutputError::Shape`] unless `found` equals `expected`.
    pub(crate) fn check_length(
        path: &Path,
        what: &str,
        expected: usize,
        found: usize,
    ) -> Result<(), Self> {
        if expected == found {
            return Ok(());
        }
        Err(Self::Shape {
            path: path.to_path_buf(),
            what: what.to_owned(),
            expected,
            found,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permission_errors_tell_the_path_and_the_remedy() {
        for kind in [
            io::ErrorKind::PermissionDenied,
            io::ErrorKind::ReadOnlyFilesystem,
        ] {
            let error = OutputError::from_io(Path::new("out/a.vtu"), "create it", kind.into());
            assert!(matches!(error, OutputError::NotWritable { .. }));
            let text = error.to_string();
            assert!(
                text.contains("out/a.vtu") && text.contains("permissions"),
                "{text}"
            );
        }
    }

    #[test]
    fn unknown_errors_keep_the_message_of_the_system() {
        let source = io::Error::other("cable unplugged");
        let text = OutputError::from_io(Path::new("a"), "flush it", source).to_string();
        assert!(
            text.contains("cable unplugged") && text.contains("flush it"),
            "{text}"
        );
    }
}
