//! Errors of the library as exceptions of `perifrac.errors`.

use perifrac::prelude::{LoadedScene, RunError, SceneErrors, locate};
use pyo3::prelude::*;

/// An error on its way to Python, without the interpreter.
#[derive(Debug)]
pub(crate) struct Fault {
    /// Class in `perifrac.errors`.
    class: &'static str,
    message: String,
    /// Message and remedy of each fault of a scene.
    details: Vec<(String, Option<String>)>,
}

impl Fault {
    pub(crate) fn new(class: &'static str, message: impl ToString) -> Self {
        Fault {
            class,
            message: message.to_string(),
            details: Vec::new(),
        }
    }

    fn of_scene(class: &'static str, errors: &SceneErrors) -> Self {
        let details = errors.diagnostics.iter();
        Fault {
            details: details
                .map(|fault| (fault.message.clone(), fault.help.clone()))
                .collect(),
            ..Fault::new(class, errors)
        }
    }

    /// An error of a run, underlined in its scene where it has a place there.
    pub(crate) fn of_run(loaded: &LoadedScene, error: &RunError) -> Self {
        if let RunError::Model(error) = error {
            return Self::of_scene("PlanError", &locate(loaded, error));
        }
        let class = match error {
            RunError::Output(_) => "OutputError",
            RunError::Checkpoint(_) | RunError::Start(_) => "CheckpointError",
            RunError::Interrupted { .. } => "Interrupted",
            error => match error.exit_code() {
                2 => "SolverUnavailable",
                3 => "RefusedError",
                4 => "NotConverged",
                _ => "RunError",
            },
        };
        Self::new(class, error)
    }

    /// The exception. One that cannot be made is an error of the interpreter.
    pub(crate) fn raise(&self, py: Python<'_>) -> PyErr {
        let exception = || -> PyResult<Bound<'_, PyAny>> {
            let class = py.import("perifrac.errors")?.getattr(self.class)?;
            let exception = class.call1((&self.message,))?;
            if !self.details.is_empty() {
                exception.setattr("diagnostics", &self.details)?;
            }
            Ok(exception)
        };
        exception().map_or_else(|error| error, PyErr::from_value)
    }
}

impl From<SceneErrors> for Fault {
    fn from(errors: SceneErrors) -> Self {
        Self::of_scene("SceneError", &errors)
    }
}

/// Raises what a function of the library failed with.
pub(crate) fn raised<T>(py: Python<'_>, result: Result<T, impl Into<Fault>>) -> PyResult<T> {
    result.map_err(|error| error.into().raise(py))
}
