//! Implicit integrators: backward Euler and TR-BDF2, both with an error estimate from one more solve
//! with the same factor.
//!
//! What is integrated is the content of the pores, S p + Q u, whose rate is q − L p; mechanical
//! equilibrium holds at the end of every stage. Increments are solved for, never pressures: the
//! right-hand sides are imbalances, so a state of rest stays at rest to the last bit.

use perifrac_solvers::dot;

use super::memory::Timed;
use super::stage::{self, Stage, Target};
use super::{Increment, Memory, Scheme, SchemeCounters, State, StepError, StepReport, flow_of};
use crate::model::{FlowModel, Model};
use crate::plan::Integrator;
use crate::report::Flows;

/// Implicit scheme: an integrator over a stage.
pub struct Implicit<const D: usize> {
    integrator: Integrator,
    stage: Box<dyn Stage<D>>,
    name: String,
    products: u64,
    /// Whether anybody asks for the error of a step.
    estimates: bool,
}

/// γ of TR-BDF2, for which both stages have the same matrix.
const GAMMA: f64 = 2.0 - std::f64::consts::SQRT_2;

impl<const D: usize> Implicit<D> {
    /// Scheme of the given integrator and stage; without `estimates` the error of a step is not
    /// computed, which saves a solve.
    pub fn new(integrator: Integrator, stage: Box<dyn Stage<D>>, estimates: bool) -> Self {
        Implicit {
            integrator,
            name: format!("{} ({})", stage.name(), integrator.name()),
            stage,
            products: 0,
            estimates,
        }
    }

    /// q(t) − L p.
    fn imbalance(&mut self, flow: &FlowModel<D>, time: f64, p: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; p.len()];
        flow.imbalance(time, p, &mut result);
        self.products += 1;
        result
    }

    /// Imbalance at the start of the step, kept from the end of the last one.
    fn at_start(&mut self, flow: &FlowModel<D>, old: &State) -> Vec<f64> {
        let known = old.memory.imbalance.as_ref();
        match known.and_then(|known| known.at(old.time)) {
            Some(imbalance) => imbalance.to_vec(),
            None => self.imbalance(flow, old.time, &old.pressure),
        }
    }

    /// Root mean square over the volume of the filtered error.
    fn estimate(
        &mut self,
        model: &Model<D>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let error = self.stage.filter(model, rhs, report)?;
        let volume = &model.cloud.volume;
        let weighted: Vec<f64> = error.iter().zip(volume).map(|(e, v)| e * v).collect();
        Ok((dot(&weighted, &error) / volume.iter().sum::<f64>()).sqrt())
    }

    fn backward_euler(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let flow = flow_of(model)?;
        let mut report = StepReport::default();
        let start = self.at_start(flow, old);
        self.stage.prepare(model, dt)?;
        let time = old.time + dt;
        let now = self.imbalance(flow, time, &old.pressure);
        let rhs = now.iter().map(|r| dt * r).collect();
        let target = Target {
            base: old,
            time,
            dt,
            slot: 0,
        };
        let step = self.stage.solve(model, target, rhs, &mut report)?;
        trial.time = time;
        trial.set_sum(old, 1.0, &step);
        let end = self.imbalance(flow, time, &trial.pressure);
        if self.estimates {
            let half = end.iter().zip(&start).map(|(e, s)| 0.5 * dt * (e - s));
            report.error = Some(self.estimate(model, half.collect(), &mut report)?);
        }
        report.flows = weighted_flows(flow, &[(dt, &trial.pressure, time, &end)]);
        close_fixed(model, flow, &mut report.flows, &step);
        trial.memory.imbalance = Some(Timed { time, values: end });
        Ok(report)
    }

    fn tr_bdf2(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let flow = flow_of(model)?;
        let mut report = StepReport::default();
        let start = self.at_start(flow, old);
        let a = 0.5 * GAMMA * dt;
        self.stage.prepare(model, a)?;
        // First stage: trapezoidal rule to t + γΔt.
        let (middle_time, end_time) = (old.time + GAMMA * dt, old.time + dt);
        let ahead = self.imbalance(flow, middle_time, &old.pressure);
        let rhs = start.iter().zip(&ahead).map(|(s, m)| a * (s + m)).collect();
        let time = middle_time;
        let target = Target {
            base: old,
            time,
            dt,
            slot: 0,
        };
        let first = self.stage.solve(model, target, rhs, &mut report)?;
        let mut middle = old.clone();
        middle.set_sum(old, 1.0, &first);
        let halfway = self.imbalance(flow, middle_time, &middle.pressure);
        // Second stage: second backward difference, written as an increment over its predictor.
        let ratio = 1.0 / (GAMMA * (2.0 - GAMMA));
        let mut predictor = old.clone();
        predictor.set_sum(old, ratio, &first);
        let ahead = self.imbalance(flow, end_time, &predictor.pressure);
        let rhs = ahead.iter().map(|r| a * r).collect();
        let (base, time) = (&predictor, end_time);
        let target = Target {
            base,
            time,
            dt,
            slot: 1,
        };
        let second = self.stage.solve(model, target, rhs, &mut report)?;
        trial.time = end_time;
        trial.set_sum(&predictor, 1.0, &second);
        let end = self.imbalance(flow, end_time, &trial.pressure);
        if self.estimates {
            report.error = Some(self.embedded(model, dt, [&start, &halfway, &end], &mut report)?);
        }
        let outer = 0.25 * std::f64::consts::SQRT_2 * dt;
        let stages = [
            (outer, &old.pressure, old.time, &start),
            (outer, &middle.pressure, middle_time, &halfway),
            (a, &trial.pressure, end_time, &end),
        ];
        report.flows = weighted_flows(flow, &stages);
        close_fixed(model, flow, &mut report.flows, &trial.since(old));
        trial.memory.imbalance = Some(Timed {
            time: end_time,
            values: end,
        });
        Ok(report)
    }

    /// Difference to the embedded third-order formula (Hosea and Shampine 1996), filtered.
    fn embedded(
        &mut self,
        model: &Model<D>,
        dt: f64,
        [start, middle, end]: [&Vec<f64>; 3],
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let weights = [
            (std::f64::consts::SQRT_2 - 1.0) / 3.0,
            -1.0 / 3.0,
            GAMMA / 3.0,
        ];
        let rhs = (0..start.len())
            .map(|i| dt * (weights[0] * start[i] + weights[1] * middle[i] + weights[2] * end[i]))
            .collect();
        self.estimate(model, rhs, report)
    }
}

/// Flows of a step as the weighted sum over its stages (weight, pressure, time, imbalance).
pub(super) fn weighted_flows<const D: usize>(
    flow: &FlowModel<D>,
    stages: &[(f64, &Vec<f64>, f64, &Vec<f64>)],
) -> Flows {
    let mut sum = Flows::default();
    for &(weight, pressure, time, imbalance) in stages {
        let mut flows = flow.flows(pressure, time);
        flow.add_fixed_inflow(imbalance, &mut flows);
        sum.add(weight, &flows);
    }
    sum
}

/// What the pores of fixed points take up comes in there too.
pub(super) fn close_fixed<const D: usize>(
    model: &Model<D>,
    flow: &FlowModel<D>,
    flows: &mut Flows,
    change: &Increment,
) {
    if flow.fixed.is_empty() {
        return;
    }
    let content = model.content(&change.displacement, &change.walls);
    let mut rough = vec![0.0; content.len()];
    flow.subtract_stabilisation(&change.pressure, &mut rough);
    for fixed in &flow.fixed {
        let i = fixed.point;
        let gain = flow.capacity[i] * change.pressure[i] + content[i] - rough[i];
        flows.hold(fixed.load, gain);
    }
}

impl<const D: usize> Scheme<D> for Implicit<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn recall(&mut self, memory: &Memory) {
        self.stage.recall(memory);
    }

    fn local_order(&self) -> f64 {
        match self.integrator {
            Integrator::BackwardEuler => 2.0,
            Integrator::TrBdf2 => 3.0,
        }
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        stage::start(&mut *self.stage, model, state)
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        self.recall(&old.memory);
        let report = match self.integrator {
            Integrator::BackwardEuler => self.backward_euler(model, old, dt, trial),
            Integrator::TrBdf2 => self.tr_bdf2(model, old, dt, trial),
        }?;
        trial.check()?;
        self.stage.remember(&mut trial.memory);
        Ok(report)
    }

    fn counters(&self) -> SchemeCounters {
        let mut counters = self.stage.counters();
        counters.products += self.products;
        counters
    }

    fn solver(&self) -> Option<(String, String)> {
        self.stage.solver()
    }
}
