//! Failures and their exit codes.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use super::interrupt;
use super::stages::way_on;
use crate::model::ModelError;
use crate::output::{CheckpointError, OutputError, checkpoint};
use crate::run::RunError;
use crate::scene::SceneErrors;
#[cfg(feature = "study")]
use crate::study::StudyError;

/// A failure of a verb, as told to the user.
#[derive(Debug)]
pub(super) enum Failure {
    /// Wrong words on the command line.
    Usage(String),
    /// The scene is at fault.
    Scene(Box<SceneErrors>),
    /// The run failed.
    Run(Box<RunError>),
    /// The run was stopped by what is no fault of its own, and can go on in its folder.
    Stopped(Box<RunError>, PathBuf),
    /// The run needs more memory than there is.
    Memory(String),
    /// A file could not be written.
    Output(OutputError),
    #[cfg(feature = "study")]
    /// A study or a report could not be made.
    Study(StudyError),
    #[cfg(feature = "study")]
    /// A study was interrupted; what is done is kept.
    Interrupted(String),
    /// Standard output went away.
    Broken,
}

impl Failure {
    /// The exit code.
    pub(super) fn code(&self) -> u8 {
        match self {
            Failure::Usage(_) => 2,
            Failure::Scene(_) => 3,
            Failure::Run(error) | Failure::Stopped(error, _) => run_code(error),
            Failure::Memory(_) | Failure::Output(_) => 1,
            #[cfg(feature = "study")]
            Failure::Study(
                StudyError::Unsuited { .. } | StudyError::NoRun { .. } | StudyError::NoField { .. },
            ) => 2,
            #[cfg(feature = "study")]
            Failure::Study(_) => 1,
            #[cfg(feature = "study")]
            Failure::Interrupted(_) => interrupt::code(),
            Failure::Broken => 0,
        }
    }

    /// Says how to go on in a folder after what is no fault of the scene, if there is a checkpoint.
    #[must_use]
    pub(super) fn with_way_on(self, folder: &Path) -> Self {
        let whole = way_on(folder);
        // A stage that kept nothing begins anew.
        let goes_on = || whole != folder || !checkpoint::list(folder).is_empty();
        match self {
            Failure::Run(error)
                if matches!(*error, RunError::Interrupted { .. } | RunError::Output(_))
                    && goes_on() =>
            {
                Failure::Stopped(error, whole.to_owned())
            }
            other => other,
        }
    }

    /// Tells the user on standard error and gives the exit code.
    pub(super) fn report(&self) -> u8 {
        let mut stderr = std::io::stderr().lock();
        let text = match self {
            Failure::Usage(message) | Failure::Memory(message) => format!("error: {message}"),
            Failure::Scene(errors) => errors.render(colourful()),
            Failure::Run(error) => format!("error: {error}"),
            Failure::Stopped(error, folder) => format!(
                "error: {error}; go on with `perifrac resume {}`",
                folder.display()
            ),
            Failure::Output(error) => format!("error: {error}"),
            #[cfg(feature = "study")]
            Failure::Study(error) => format!("error: {error}"),
            #[cfg(feature = "study")]
            Failure::Interrupted(message) => format!("interrupted: {message}"),
            Failure::Broken => return 0,
        };
        // Nothing can be done if even standard error is gone.
        let _ = writeln!(stderr, "{}", text.trim_end());
        self.code()
    }
}

fn run_code(error: &RunError) -> u8 {
    match error {
        RunError::Interrupted { .. } => interrupt::code(),
        error => error.exit_code(),
    }
}

/// Whether messages may be coloured.
fn colourful() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

impl From<SceneErrors> for Failure {
    fn from(errors: SceneErrors) -> Self {
        Failure::Scene(Box::new(errors))
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        Failure::Run(Box::new(error))
    }
}

impl From<CheckpointError> for Failure {
    fn from(error: CheckpointError) -> Self {
        RunError::Checkpoint(error).into()
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        RunError::Model(error).into()
    }
}

#[cfg(feature = "study")]
impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        Failure::Study(error)
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Failure::Output(error)
    }
}

/// Prints to standard output; a closed pipe ends the program quietly.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    let printed = writeln!(stdout, "{}", text.trim_end()).and_then(|()| stdout.flush());
    printed.map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => Failure::Broken,
        _ => OutputError::from_io(Path::new("standard output"), "print", error).into(),
    })
}

/// Prints a warning on standard error; a run goes on even if nobody can read it.
pub(super) fn warn(message: &str) {
    say(&format!("warning: {message}"));
}

/// Prints a line on standard error, if there is someone to read it.
pub(super) fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Says which files of the user stood where results belong, by their new names.
pub(super) fn tell_of_kept(paths: &[PathBuf]) {
    for path in paths {
        let path = path.display();
        warn(&format!(
            "a file that no run wrote, or that was changed since, stood where a result belongs; it is now \
             {path}"
        ));
    }
}
