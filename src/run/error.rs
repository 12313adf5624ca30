//! How a run can fail.

use perifrac_solvers::SolveError;

use crate::model::ModelError;
use crate::output::{CheckpointError, OutputError};
use crate::plan::Plan;
use crate::schemes::StepError;

/// A run that did not reach its end.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The plan does not fit its points.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Output could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The run cannot go on from a checkpoint.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The run cannot begin with the state that `[start]` names.
    #[error(transparent)]
    Start(CheckpointError),
    /// A step failed and could not be cut further.
    #[error("{scheme}: {source}{}", kept(.last_output))]
    Step {
        /// The scheme.
        scheme: String,
        /// What failed.
        #[source]
        source: StepError,
        /// Time of the last good output, s.
        last_output: Option<f64>,
    },
    /// Too many steps.
    #[error(
        "stopped after {steps} steps at t = {time:.6e} s of {end:.6e} s; raise time.max_steps or \
         choose larger steps"
    )]
    TooManySteps {
        /// Steps taken.
        steps: usize,
        /// Time reached, s.
        time: f64,
        /// End, s.
        end: f64,
    },
    /// Another process of the run failed.
    #[error("another process of the run failed; its message says why")]
    Elsewhere,
    /// The user stopped it.
    #[error("interrupted at t = {time:.6e} s; what was written is complete")]
    Interrupted {
        /// Time reached, s.
        time: f64,
    },
}

impl RunError {
    /// A plan that is refused before its first step.
    pub fn refused(plan: &Plan, source: StepError) -> Self {
        RunError::Step {
            scheme: plan.scheme.name().to_owned(),
            source,
            last_output: None,
        }
    }

    /// Exit code of a program that ends with it: 1 for files, 2 for what is not there, 3 for a scene that cannot be
    /// run, 4 for what does not converge, 130 for an interruption.
    pub fn exit_code(&self) -> u8 {
        match self {
            RunError::Model(_) => 3,
            RunError::Step { source, .. } => match source {
                // A library that is not there is no fault of the scene, and no failure to converge.
                StepError::Solve(SolveError::Unavailable { .. }) => 2,
                StepError::Solve(SolveError::Refused { .. })
                | StepError::Spec(_)
                | StepError::Pattern(_)
                | StepError::NoSteadyState { .. }
                | StepError::MissingPart { .. }
                | StepError::Refused(_)
                | StepError::UnsupportedPlate => 3,
                _ => 4,
            },
            RunError::Interrupted { .. } => 130,
            RunError::Checkpoint(error) | RunError::Start(error) => match error {
                // One that is not there is a slip of the pen; one that does not fit is no basis for a run.
                CheckpointError::Absent { .. } => 2,
                _ => 1,
            },
            _ => 1,
        }
    }
}

fn kept(last_output: &Option<f64>) -> String {
    last_output.map_or(String::new(), |time| {
        format!("; the output at t = {time:.6e} s is kept")
    })
}
