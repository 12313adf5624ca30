//! Failures and their exit codes.

use std::io::{IsTerminal, Write};
use std::process::ExitCode;

use crate::model::ModelError;
use crate::output::OutputError;
use crate::run::RunError;
use crate::scene::SceneErrors;
use crate::schemes::StepError;

/// A failure of a verb, as told to the user.
#[derive(Debug)]
pub enum Failure {
    /// Wrong words on the command line.
    Usage(String),
    /// The scene is at fault.
    Scene(Box<SceneErrors>),
    /// The run failed.
    Run(RunError),
    /// A file could not be written.
    Output(OutputError),
    /// Standard output went away.
    Broken,
}

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Failure::Usage(_) => 2,
            Failure::Scene(_) | Failure::Run(RunError::Model(_)) => 3,
            Failure::Run(RunError::Step { source, .. }) => match source {
                StepError::Solve(_) | StepError::Unstable { .. } | StepError::NotFinite { .. } => 4,
                StepError::Spec(_) | StepError::NoSteadyState { .. } => 3,
            },
            Failure::Run(RunError::Interrupted { .. }) => 130,
            Failure::Run(_) | Failure::Output(_) => 1,
            Failure::Broken => 0,
        }
    }

    /// Tells the user on standard error and gives the exit code.
    pub fn report(&self) -> ExitCode {
        let mut stderr = std::io::stderr().lock();
        let text = match self {
            Failure::Usage(message) => format!("error: {message}"),
            Failure::Scene(errors) => errors.render(colourful()),
            Failure::Run(error) => format!("error: {error}"),
            Failure::Output(error) => format!("error: {error}"),
            Failure::Broken => return ExitCode::SUCCESS,
        };
        // Nothing can be done if even standard error is gone.
        let _ = writeln!(stderr, "{}", text.trim_end());
        ExitCode::from(self.code())
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
        Failure::Run(error)
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Failure::Run(RunError::Model(error))
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Failure::Output(error)
    }
}

/// Prints to standard output; a closed pipe ends the program quietly.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{}", text.trim_end())
        .and_then(|()| stdout.flush())
        .map_err(|_| Failure::Broken)
}
