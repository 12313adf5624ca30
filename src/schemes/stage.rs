//! One implicit stage: the step to a new time that integrators combine.
//!
//! A stage finds the increment x over a base state for which
//!
//!   S x_p + Q x_u + a L x_p = r   and   the base plus x is in equilibrium at the stage's time.
//!
//! Without mechanics the second equation and Q do not exist.

use perifrac_solvers::Demand;

use super::{
    ImplicitSystem, Increment, Memory, SchemeCounters, State, StepError, StepReport, flow_of,
};
use crate::model::{FlowModel, Model};

/// Solver of implicit stages.
pub trait Stage<const D: usize>: Send {
    /// Name of the scheme as on the command line.
    fn name(&self) -> &'static str;

    /// Makes `a` (s) the coefficient of L.
    ///
    /// # Errors
    /// [`StepError`] if the matrix cannot be factored.
    fn prepare(&mut self, model: &Model<D>, a: f64) -> Result<(), StepError>;

    /// Solves the stage numbered `slot` of a step of `dt` seconds. `base` is where the increment starts
    /// and `time` where it leads; `rhs` has shape `(n,)`, m^D.
    ///
    /// # Errors
    /// [`StepError`]; the increment is then of no use.
    fn solve(
        &mut self,
        model: &Model<D>,
        target: Target<'_>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Increment, StepError>;

    /// Pressure of a homogeneous stage for `rhs`: damps the stiff part of an error estimate.
    ///
    /// # Errors
    /// [`StepError`].
    fn filter(
        &mut self,
        model: &Model<D>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError>;

    /// Brings the initial state to the undrained response to its loads.
    ///
    /// # Errors
    /// [`StepError`].
    fn start(&mut self, _model: &Model<D>, _state: &mut State) -> Result<(), StepError> {
        Ok(())
    }

    /// Brings the solid into equilibrium with the pressure and the loads of the initial state.
    ///
    /// # Errors
    /// [`StepError`].
    fn equilibrate(&mut self, _model: &Model<D>, _state: &mut State) -> Result<(), StepError> {
        Ok(())
    }

    /// Goes on from what an accepted state remembers.
    fn recall(&mut self, memory: &Memory);

    /// Enters what the next step needs.
    fn remember(&self, memory: &mut Memory);

    /// Work done so far.
    fn counters(&self) -> SchemeCounters;

    /// Linear solver in use, and why it was chosen.
    fn solver(&self) -> Option<(String, String)>;
}

/// Brings the initial state to the undrained response to its loads where the scene asks for that, else the
/// solid into equilibrium at the pressure that is given.
///
/// # Errors
/// [`StepError`].
pub(super) fn start<const D: usize>(
    stage: &mut dyn Stage<D>,
    model: &Model<D>,
    state: &mut State,
) -> Result<(), StepError> {
    let Some(coupling) = &model.coupling else {
        return Ok(());
    };
    match coupling.undrained_start {
        true => stage.start(model, state)?,
        false => stage.equilibrate(model, state)?,
    }
    stage.remember(&mut state.memory);
    Ok(())
}

/// Where a stage starts and leads.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// The state the increment is added to.
    pub base: &'a State,
    /// Time the stage leads to, s.
    pub time: f64,
    /// Length of the whole step, s.
    pub dt: f64,
    /// Number of the stage in its step, 0 or 1.
    pub slot: usize,
}

/// Stage of flow alone.
pub struct FlowStage {
    system: ImplicitSystem,
    last: Vec<f64>,
}

impl FlowStage {
    /// Stage with the given solver.
    ///
    /// # Errors
    /// [`StepError`] if the solver is refused.
    pub fn new<const D: usize>(demand: &Demand, flow: &FlowModel<D>) -> Result<Self, StepError> {
        Ok(FlowStage {
            system: ImplicitSystem::new(demand, flow)?,
            last: vec![0.0; flow.points()],
        })
    }
}

impl<const D: usize> Stage<D> for FlowStage {
    fn name(&self) -> &'static str {
        "implicit"
    }

    fn prepare(&mut self, model: &Model<D>, a: f64) -> Result<(), StepError> {
        let flow = flow_of(model)?;
        Ok(self.system.prepare(flow, &flow.capacity, a, &[])?)
    }

    fn recall(&mut self, memory: &Memory) {
        self.system.recall(memory);
        match memory.guess.is_empty() {
            true => self.last.fill(0.0),
            false => self.last.copy_from_slice(&memory.guess),
        }
    }

    fn remember(&self, memory: &mut Memory) {
        self.system.remember(memory);
        memory.guess.clone_from(&self.last);
    }

    fn solve(
        &mut self,
        model: &Model<D>,
        target: Target<'_>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Increment, StepError> {
        let flow = flow_of(model)?;
        let mut pressure = self.last.clone();
        flow.fix(target.time, &target.base.pressure, &mut pressure);
        report.iterations += self.system.solve(flow, &rhs, &mut pressure)?;
        self.last.copy_from_slice(&pressure);
        Ok(Increment {
            pressure,
            ..Increment::default()
        })
    }

    fn filter(
        &mut self,
        model: &Model<D>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        Ok(self.system.filter(flow_of(model)?, &rhs, report)?)
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            solver: self.system.counters().clone(),
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.system.chosen().clone())
    }
}
