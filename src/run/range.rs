//! The range over which the pressure will change, found by implicit steps before the run.

use super::scale::Scale;
use super::time_loop::Run;
use crate::plan::{Integrator, SchemeChoice, StepRule, TimePlan};
use crate::schemes::{FlowStage, Implicit, Scheme, StepError};

impl<const D: usize> Run<'_, D> {
    /// What errors of the pressure are measured against. Sources do not tell how far they will drive it: implicit
    /// steps of the flow from one break of the loads to the next do, across the whole run.
    pub(super) fn scale(&mut self) -> Result<Scale, StepError> {
        let mut scale = Scale::new(self.plan, &self.model);
        scale.cover(&self.model, &self.state.pressure);
        let adaptive = self.plan.time.step == StepRule::Adaptive;
        let explicit = self.plan.scheme == SchemeChoice::Explicit;
        let Some(flow) = self.model.flow.as_ref().filter(|_| adaptive && !explicit) else {
            return Ok(scale);
        };
        // With a solid only loads that come late need it, whose first steps have nothing else to go by.
        let known = flow.is_constant() || scale.is_known();
        if self.model.solid.is_some() && known {
            return Ok(scale);
        }
        // What strain stores as well keeps the pressure down, at most by this.
        let coupling = self.model.coupling.as_ref();
        let share = coupling.map_or(1.0, |own| 1.0 / (1.0 + own.strength(&flow.capacity)));
        let start = flow.initial.clone();
        let stage = Box::new(FlowStage::new(&self.plan.stage_demand(), flow)?);
        let mut probe = Implicit::new(Integrator::BackwardEuler, stage, false);
        let mut here = self.state.clone();
        for time in legs(&self.model.breakpoints(), &self.plan.time) {
            let mut far = here.clone();
            probe.step(&self.model, &here, time - here.time, &mut far)?;
            let pairs = far.pressure.iter().zip(&start);
            let expected: Vec<f64> = pairs.map(|(p, p0)| p0 + share * (p - p0)).collect();
            scale.cover(&self.model, &expected);
            here = far;
        }
        self.aside.add(&probe.counters());
        Ok(scale)
    }
}

/// Times between which loads hardly bend, to the end of the run: those of `breaks`, or a part of them.
fn legs(breaks: &[f64], plan: &TimePlan) -> Vec<f64> {
    let (start, end) = (plan.start, plan.end);
    let inside: Vec<f64> = (breaks.iter().copied())
        .filter(|time| *time > start && *time < end)
        .collect();
    let stride = inside.len().div_ceil(MOST_LEGS).max(1);
    let kept = inside.into_iter().skip(stride - 1).step_by(stride);
    kept.chain([end]).collect()
}

/// Breaks of the loads between which the range is looked for: each takes a factor.
const MOST_LEGS: usize = 32;
