//! The steady state: one solve of each field.

use super::RunError;
use super::time_loop::{Effort, Run};
use crate::model::Model;
use crate::schemes::{
    self, Assembled, Fracture, SchemeCounters, SolidSolver, State, StepError, StepReport,
    solve_steady,
};

type Steady = (StepReport, SchemeCounters, Option<(String, String)>);

impl<const D: usize> Run<'_, D> {
    pub(super) fn steady(&mut self) -> Result<Effort, RunError> {
        self.scheme_name = "steady".to_owned();
        if self.is_interrupted() {
            return Err(RunError::Interrupted { time: 0.0 });
        }
        let timers = self.timers.clone();
        let solved = timers.time("solve", || self.steady_state());
        let (report, counters, solver) = solved.map_err(|error| self.failed(error))?;
        let rates = StepReport {
            stored: Some(0.0),
            ..report.clone()
        };
        let balanced = self.audit(&self.model, &rates, &self.state);
        self.balance = balanced.map_err(|error| self.failed(error))?;
        timers.time("output", || self.first_output(&report))?;
        Ok((counters, solver, None))
    }

    /// The drained state: flow first, then the solid under its pressure.
    fn steady_state(&mut self) -> Result<Steady, StepError> {
        let mut steady: Steady = (StepReport::default(), SchemeCounters::default(), None);
        if self.model.flow.is_some() {
            let demand = self.plan.stage_demand();
            let solve = |model: &Model<D>, state: &mut State| match &model.flow {
                Some(flow) => solve_steady(flow, &demand, state),
                None => Err(StepError::MissingPart { part: "[flow]" }),
            };
            let (report, counters, chosen) = self.settled(solve)?;
            steady = (report, counters, Some(chosen));
        }
        if let Some(solid) = &self.model.solid {
            let mut mechanics: Box<dyn SolidSolver<D>> = match self.plan.damage {
                Some(damage) => {
                    let demand = self.plan.fracture_demand();
                    Box::new(Fracture::new(&demand, &self.model, damage)?)
                }
                None => Box::new(Assembled::new(&self.plan.solid_demand(), solid)?),
            };
            steady.0.iterations += mechanics.equilibrate(&self.model, &mut self.state)?;
            schemes::advance(&self.model, &mut self.state);
            let own = mechanics.counters();
            steady.1 = SchemeCounters {
                solver: std::mem::take(&mut steady.1.solver),
                products: steady.1.products,
                ..own
            };
            steady.2 = steady.2.or_else(|| mechanics.solver());
        }
        Ok(steady)
    }
}
