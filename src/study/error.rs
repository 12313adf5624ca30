//! How a study can fail.

use std::io;
use std::path::PathBuf;

use crate::output::OutputError;

/// A study that could not be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The program could not be started for a run.
    #[error("cannot start a run of this program: {0}")]
    Program(#[source] io::Error),
    /// The case has not what the study varies.
    #[error("{study} of {case}: {reason}")]
    Unsuited {
        /// What was asked for.
        study: &'static str,
        /// The case.
        case: String,
        /// What is missing, and what to do.
        reason: String,
    },
    /// A folder does not hold the results of a run.
    #[error("{} holds no results of a run: {reason}; give the folder that `perifrac run` names at its end", .folder.display())]
    NoRun {
        /// The folder.
        folder: PathBuf,
        /// What is missing.
        reason: String,
    },
    /// A run has no such field at its outputs.
    #[error("{} has no field `{field}` at its outputs; {}", .folder.display(), choice(.known))]
    NoField {
        /// The folder of the run.
        folder: PathBuf,
        /// What was asked for.
        field: String,
        /// What there is.
        known: Vec<String>,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

fn choice(known: &[String]) -> String {
    match known.is_empty() {
        true => {
            "its pictures tell of no file with fields: run it with `output.plots = true`".to_owned()
        }
        false => format!("choose one of {}", known.join(", ")),
    }
}
