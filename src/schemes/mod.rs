//! How operators and effects combine over time.

mod control;
mod error;
mod explicit;
mod implicit;
mod limits;
mod steady;
mod system;

use perifrac_solvers::SolverCounters;

pub use control::StepControl;
pub use error::StepError;
pub use explicit::ForwardEuler;
pub use implicit::Implicit;
pub use limits::{StepLimit, diffusion_limit};
pub use steady::solve_steady;
pub use system::ImplicitSystem;

use crate::model::Model;
use crate::plan::{Plan, SchemeChoice};
use crate::report::Flows;

/// Fields of a run at one time. A scene that names no mechanics or damage has none here.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Pore pressure per point, Pa, shape `(n,)`.
    pub pressure: Vec<f64>,
}

impl State {
    /// Name and bytes of every field held.
    pub fn fields(&self) -> Vec<(&'static str, usize)> {
        vec![("pressure", 8 * self.pressure.len())]
    }
}

/// What a step did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepReport {
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Estimated root mean square error of the step, Pa; `None` for a scheme without an estimate.
    pub error: Option<f64>,
    /// Volumes moved during the step.
    pub flows: Flows,
}

/// Work done by a scheme.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SchemeCounters {
    /// Products with the operator.
    pub products: u64,
    /// What the linear solver did.
    pub solver: SolverCounters,
}

/// A time scheme. `old` is never changed and `trial` is dropped on rejection, so a failed step
/// cannot corrupt a run.
pub trait Scheme<const D: usize>: Send {
    /// Name as on the command line, with the integrator.
    fn name(&self) -> &'static str;

    /// Order of the local error, for step control.
    fn local_order(&self) -> f64;

    /// Largest stable step, if there is one.
    fn limit(&self) -> Option<&StepLimit> {
        None
    }

    /// One step of `dt` seconds from `old` into `trial`.
    ///
    /// # Errors
    /// [`StepError`]; `trial` is then of no use.
    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError>;

    /// Work done so far.
    fn counters(&self) -> SchemeCounters;

    /// Linear solver in use, and why it was chosen.
    fn solver(&self) -> Option<(String, String)> {
        None
    }
}

/// Builds the scheme of the plan.
///
/// # Errors
/// [`StepError`] if the solver cannot be built.
pub fn build<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
) -> Result<Box<dyn Scheme<D>>, StepError> {
    Ok(match plan.scheme {
        SchemeChoice::Explicit => Box::new(ForwardEuler::new(model)),
        SchemeChoice::Implicit(integrator) => {
            Box::new(Implicit::new(integrator, &plan.solver, model)?)
        }
    })
}
