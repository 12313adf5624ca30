//! How operators and effects combine over time.
//!
//! ```text
//! Implicit { integrator, Stage }    Stage: FlowStage | Monolithic | Staggered { flow, SolidSolver }
//! ForwardEuler { SolidSolver }      SolidSolver: Assembled (Newton) | Fracture (damage) | Relaxation (ADR)
//! Verlet { flow }                   QuasiStatic { SolidSolver }
//! ```

mod accelerator;
mod border;
mod build;
mod control;
mod descent;
mod error;
mod explicit;
mod fracture;
mod implicit;
mod layout;
mod limits;
mod memory;
mod monolithic;
mod quasi_static;
mod relaxation;
mod solid;
mod stage;
mod staggered;
mod start;
mod state;
mod steady;
mod system;
mod timed;
mod undrained;
mod verlet;

use perifrac_solvers::SolverCounters;
use serde::{Deserialize, Serialize};

pub use build::{build, check};
pub use control::StepControl;
pub use error::{Conserved, Rejection, StepError};
pub use explicit::ForwardEuler;
pub use fracture::{Fracture, FractureFlowStep, LaggedFracture};
pub use implicit::Implicit;
pub use layout::BlockMatrix;
pub use limits::{StepLimit, diffusion_limit};
pub use memory::{Lag, Memory};
pub use monolithic::Monolithic;
pub use quasi_static::{QuasiStatic, advance, growth};
pub use relaxation::Relaxation;
pub use solid::{Assembled, SolidSolver};
pub use stage::{FlowStage, Stage, Target};
pub use staggered::Staggered;
pub use state::{Increment, State, WellState};
pub use steady::solve_steady;
pub use system::ImplicitSystem;
pub use verlet::Verlet;

use crate::model::{Coupling, FlowModel, Model, SolidModel};
use crate::report::Flows;

/// What a step did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepReport {
    /// Iterations of the linear solvers, or of relaxation.
    pub iterations: usize,
    /// Passes between the fields, or between damage and displacement.
    pub passes: usize,
    /// What the last pass left, relative to its scale; `None` without passes.
    pub residual: Option<f64>,
    /// Estimated root mean square error of the step, Pa; `None` for a scheme without an estimate.
    pub error: Option<f64>,
    /// Root mean square of the pressure that strain which lags leaves unsettled, Pa; `None` where none lags.
    pub unsettled: Option<f64>,
    /// Volumes moved during the step.
    pub flows: Flows,
    /// Largest growth of damage at a point; `None` without damage.
    pub growth: Option<f64>,
    /// Volume that the pores took up, m^D, where it is no function of the state.
    pub stored: Option<f64>,
}

/// Work done by a scheme.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemeCounters {
    /// Products with an operator.
    pub products: u64,
    /// What the linear solver of flow, or of flow and mechanics together, did.
    pub solver: SolverCounters,
    /// What the linear solver of mechanics alone did, if there is one.
    pub mechanics: Option<SolverCounters>,
    /// Newton iterations of mechanics.
    pub newton_iterations: u64,
    /// Newton tangents that were given up for positive ones.
    pub fallbacks: u64,
    /// Evaluations of the force along search directions.
    pub searches: u64,
    /// Families whose stiffness was filled anew because damage changed it.
    pub refilled_families: u64,
    /// Passes between flow and mechanics.
    pub coupling_iterations: u64,
    /// Largest contraction seen between the first two passes; only without acceleration.
    pub contraction: Option<f64>,
    /// Iterations of dynamic relaxation.
    pub relaxation_iterations: u64,
    /// Single steps of the solid.
    pub single_steps: u64,
}

impl SchemeCounters {
    /// Adds the work of another scheme of the same run.
    pub fn add(&mut self, other: &SchemeCounters) {
        self.products += other.products;
        self.solver.add(&other.solver);
        if let Some(mechanics) = &other.mechanics {
            self.mechanics.get_or_insert_default().add(mechanics);
        }
        self.newton_iterations += other.newton_iterations;
        self.fallbacks += other.fallbacks;
        self.searches += other.searches;
        self.refilled_families += other.refilled_families;
        self.coupling_iterations += other.coupling_iterations;
        self.contraction = self
            .contraction
            .into_iter()
            .chain(other.contraction)
            .reduce(f64::max);
        self.relaxation_iterations += other.relaxation_iterations;
        self.single_steps += other.single_steps;
    }
}

/// A time scheme.
///
/// A step is a function of the model, the state it starts from and its length: what a scheme learns is part
/// of the state it leads to, so a rejected trial leaves no trace.
///
/// ```
/// use perifrac::prelude::*;
///
/// # let scene = r#"
/// #     title = "A square that drains to the left"
/// #     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
/// #     fluid.viscosity = "1 mPa s"
/// #     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
/// #     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
/// #     time.end = "1 s"
/// # "#;
/// let plan = Setup::text(scene).plan()?;
/// let model = Model::<2>::of(&plan)?;
/// let mut scheme = build_scheme(&plan, &model)?;
/// let mut state = State::initial(&model);
/// scheme.start(&model, &mut state)?;
/// let mut trial = state.clone();
/// while state.time < plan.time.end {
///     scheme.step(&model, &state, 0.125, &mut trial)?;
///     std::mem::swap(&mut state, &mut trial);
/// }
/// assert!(state.pressure.iter().all(|p| (0.0..1e5).contains(p)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Scheme<const D: usize>: Send {
    /// Name as on the command line, with the integrator.
    fn name(&self) -> &str;

    /// Order of the local error, for step control.
    fn local_order(&self) -> f64;

    /// Largest stable step, if there is one.
    fn limit(&self) -> Option<&StepLimit> {
        None
    }

    /// Brings the initial state into the equilibrium that the scene asks for.
    ///
    /// # Errors
    /// [`StepError`].
    fn start(&mut self, _model: &Model<D>, _state: &mut State) -> Result<(), StepError> {
        Ok(())
    }

    /// Goes on from an accepted state; every step begins with it.
    fn recall(&mut self, memory: &Memory);

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

/// The flow part of a model.
fn flow_of<const D: usize>(model: &Model<D>) -> Result<&FlowModel<D>, StepError> {
    model
        .flow
        .as_ref()
        .ok_or(StepError::MissingPart { part: "[flow]" })
}

/// The mechanical part of a model.
fn solid_of<const D: usize>(model: &Model<D>) -> Result<&SolidModel<D>, StepError> {
    model.solid.as_deref().ok_or(StepError::MissingPart {
        part: "[mechanics]",
    })
}

/// What couples the two.
fn coupling_of<const D: usize>(model: &Model<D>) -> Result<&Coupling, StepError> {
    model
        .coupling
        .as_ref()
        .ok_or(StepError::MissingPart { part: "[coupling]" })
}
