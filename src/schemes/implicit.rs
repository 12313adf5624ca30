//! Implicit flow: backward Euler and TR-BDF2, both with an error estimate from one more solve with
//! the same factor.
//!
//! Increments are solved for, never pressures: the right-hand sides are imbalances, so a state of
//! rest stays at rest to the last bit.

use perifrac_solvers::{SolverSpec, dot};

use super::{ImplicitSystem, Scheme, SchemeCounters, State, StepError, StepReport};
use crate::model::{FlowModel, Model};
use crate::plan::Integrator;
use crate::report::Flows;

/// Implicit scheme of one integrator.
pub struct Implicit {
    integrator: Integrator,
    system: ImplicitSystem,
    products: u64,
    /// Imbalance q − L p at the end of the last trial and at the start of its step.
    known: [Option<(f64, Vec<f64>)>; 2],
    increment: Vec<f64>,
}

/// γ of TR-BDF2, for which both stages have the same matrix.
const GAMMA: f64 = 2.0 - std::f64::consts::SQRT_2;

impl Implicit {
    /// Scheme with the given solver.
    ///
    /// # Errors
    /// [`StepError`] if the solver cannot be built or refuses the matrix.
    pub fn new<const D: usize>(
        integrator: Integrator,
        solver: &SolverSpec,
        model: &Model<D>,
    ) -> Result<Self, StepError> {
        Ok(Implicit {
            integrator,
            system: ImplicitSystem::new(solver, &model.flow)?,
            products: 0,
            known: [None, None],
            increment: vec![0.0; model.flow.points()],
        })
    }

    /// q(t) − L p.
    fn imbalance<const D: usize>(&mut self, flow: &FlowModel<D>, time: f64, p: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; p.len()];
        flow.imbalance(time, p, &mut result);
        self.products += 1;
        result
    }

    /// Imbalance at the start of the step, kept from the end of the last one.
    fn start<const D: usize>(&mut self, flow: &FlowModel<D>, old: &State) -> Vec<f64> {
        let at = |known: &Option<(f64, Vec<f64>)>| {
            known
                .as_ref()
                .is_some_and(|(time, _)| time.to_bits() == old.time.to_bits())
        };
        let found = self.known.iter().position(at);
        let start = match found.and_then(|k| self.known[k].take()) {
            Some((_, imbalance)) => imbalance,
            None => self.imbalance(flow, old.time, &old.pressure),
        };
        self.known = [None, Some((old.time, start.clone()))];
        start
    }

    /// Solves (C + a L) x = rhs, with x at fixed points leading from `base` to their pressure.
    fn solve<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        time: f64,
        base: &[f64],
        mut rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        let mut x = self.increment.clone();
        for fixed in &flow.fixed {
            x[fixed.point] = flow.fixed_loads[fixed.load].at(time) - base[fixed.point];
        }
        report.iterations += self.system.solve(flow, &mut rhs, &mut x)?;
        self.increment.copy_from_slice(&x);
        Ok(x)
    }

    /// Root mean square over the volume of (C + a L)⁻¹ rhs, the filtered error estimate; fixed points
    /// have none.
    fn estimate<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        mut rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let mut error = vec![0.0; rhs.len()];
        report.iterations += self.system.solve(flow, &mut rhs, &mut error)?;
        let volume = &flow.operator.neighbourhood().cloud.volume;
        let weighted: Vec<f64> = error.iter().zip(volume).map(|(e, v)| e * v).collect();
        Ok((dot(&weighted, &error) / volume.iter().sum::<f64>()).sqrt())
    }

    fn backward_euler<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        let start = self.start(flow, old);
        self.system.prepare(flow, 1.0, dt, &[])?;
        trial.time = old.time + dt;
        let now = self.imbalance(flow, trial.time, &old.pressure);
        let rhs = now.iter().map(|r| dt * r).collect();
        let step = self.solve(flow, trial.time, &old.pressure, rhs, &mut report)?;
        set_sum(&mut trial.pressure, &old.pressure, &step);
        let end = self.imbalance(flow, trial.time, &trial.pressure);
        let half = end
            .iter()
            .zip(&start)
            .map(|(e, s)| 0.5 * dt * (e - s))
            .collect();
        report.error = Some(self.estimate(flow, half, &mut report)?);
        report.flows = weigh(flow, &[(dt, &trial.pressure, trial.time, &end)]);
        close_fixed(flow, &mut report.flows, &step);
        self.known[0] = Some((trial.time, end));
        Ok(report)
    }

    fn tr_bdf2<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        let start = self.start(flow, old);
        let a = 0.5 * GAMMA * dt;
        self.system.prepare(flow, 1.0, a, &[])?;
        // First stage: trapezoidal rule to t + γΔt.
        let (middle_time, end_time) = (old.time + GAMMA * dt, old.time + dt);
        let ahead = self.imbalance(flow, middle_time, &old.pressure);
        let rhs = start.iter().zip(&ahead).map(|(s, m)| a * (s + m)).collect();
        let first = self.solve(flow, middle_time, &old.pressure, rhs, &mut report)?;
        let mut middle = vec![0.0; first.len()];
        set_sum(&mut middle, &old.pressure, &first);
        let halfway = self.imbalance(flow, middle_time, &middle);
        // Second stage: second backward difference, written as an increment over its predictor.
        let ratio = 1.0 / (GAMMA * (2.0 - GAMMA));
        let predictor: Vec<f64> = old
            .pressure
            .iter()
            .zip(&first)
            .map(|(p, x)| p + ratio * x)
            .collect();
        let rhs = self
            .imbalance(flow, end_time, &predictor)
            .iter()
            .map(|r| a * r)
            .collect();
        let second = self.solve(flow, end_time, &predictor, rhs, &mut report)?;
        set_sum(&mut trial.pressure, &predictor, &second);
        trial.time = end_time;
        let end = self.imbalance(flow, end_time, &trial.pressure);
        report.error = Some(self.embedded(flow, dt, [&start, &halfway, &end], &mut report)?);
        let outer = 0.25 * std::f64::consts::SQRT_2 * dt;
        report.flows = weigh(
            flow,
            &[
                (outer, &old.pressure, old.time, &start),
                (outer, &middle, middle_time, &halfway),
                (a, &trial.pressure, end_time, &end),
            ],
        );
        let whole: Vec<f64> = trial
            .pressure
            .iter()
            .zip(&old.pressure)
            .map(|(new, old)| new - old)
            .collect();
        close_fixed(flow, &mut report.flows, &whole);
        self.known[0] = Some((end_time, end));
        Ok(report)
    }

    /// Difference to the embedded third-order formula (Hosea and Shampine 1996), filtered.
    fn embedded<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
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
        self.estimate(flow, rhs, report)
    }
}

fn set_sum(target: &mut [f64], a: &[f64], b: &[f64]) {
    target
        .iter_mut()
        .zip(a.iter().zip(b))
        .for_each(|(t, (a, b))| *t = a + b);
}

/// Flows of a step as the weighted sum over its stages (weight, pressure, time, imbalance).
fn weigh<const D: usize>(
    flow: &FlowModel<D>,
    stages: &[(f64, &Vec<f64>, f64, &Vec<f64>)],
) -> Flows {
    let mut sum = Flows::default();
    for &(weight, pressure, time, imbalance) in stages {
        let mut flows = flow.flows(pressure, time);
        flows.fixed = flow.fixed_inflow(imbalance);
        sum.add(weight, &flows);
    }
    sum
}

/// Storage at fixed points comes in there too.
fn close_fixed<const D: usize>(flow: &FlowModel<D>, flows: &mut Flows, change: &[f64]) {
    let gain = flow
        .fixed
        .iter()
        .map(|f| flow.capacity[f.point] * change[f.point]);
    flows.fixed += gain.sum::<f64>();
}

impl<const D: usize> Scheme<D> for Implicit {
    fn name(&self) -> &'static str {
        match self.integrator {
            Integrator::BackwardEuler => "implicit (backward-euler)",
            Integrator::TrBdf2 => "implicit (tr-bdf2)",
        }
    }

    fn local_order(&self) -> f64 {
        match self.integrator {
            Integrator::BackwardEuler => 2.0,
            Integrator::TrBdf2 => 3.0,
        }
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let report = match self.integrator {
            Integrator::BackwardEuler => self.backward_euler(&model.flow, old, dt, trial),
            Integrator::TrBdf2 => self.tr_bdf2(&model.flow, old, dt, trial),
        }?;
        match trial.pressure.iter().position(|p| !p.is_finite()) {
            Some(point) => Err(StepError::NotFinite {
                point,
                time: trial.time,
            }),
            None => Ok(report),
        }
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            products: self.products,
            solver: self.system.counters().clone(),
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.system.chosen().clone())
    }
}
