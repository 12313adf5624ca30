//! The time loop.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::stops::{Stops, clamp};
use super::{FieldError, RunError, Summary, Writer};
use crate::geometry::Side;
use crate::model::Model;
use crate::plan::{
    Integrator, Plan, ReferenceKind, SchemeChoice, StepRule, TimeMode, exact_flux, exact_pressure,
};
use crate::reference::ErrorNorms;
use crate::report::{Balance, Counters, Timers};
use crate::schemes::{
    self, Implicit, Scheme, SchemeCounters, State, StepControl, StepError, StepReport, solve_steady,
};

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Time, s.
    pub time: f64,
    /// End, s.
    pub end: f64,
    /// Last step, s.
    pub dt: f64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Iterations of the linear solver in the last step.
    pub iterations: usize,
}

/// Is told how a run goes on.
pub trait Observer {
    /// A doubt arose.
    fn warn(&mut self, _message: &str) {}
    /// A step was accepted.
    fn step(&mut self, _progress: &Progress) {}
}

impl Observer for () {}

/// Runs a plan of dimension `D`; the final state comes with the summary.
///
/// # Errors
/// [`RunError`]; what was written until then is complete.
pub fn run<const D: usize>(
    plan: &Plan,
    writer: Option<&mut Writer>,
    observer: &mut dyn Observer,
    interrupt: &AtomicBool,
) -> Result<(Summary, State), RunError> {
    let started = Instant::now();
    let mut timers = Timers::default();
    let model = Model::<D>::build(plan, &mut timers)?;
    let warnings: Vec<String> = plan
        .warnings
        .iter()
        .chain(&model.warnings)
        .cloned()
        .collect();
    warnings.iter().for_each(|warning| observer.warn(warning));
    let state = State {
        time: 0.0,
        pressure: model.flow.initial.clone(),
    };
    let mut run = Run {
        plan,
        model,
        writer,
        observer,
        interrupt,
        timers,
        warnings,
        start_volume: 0.0,
        balance: Balance::default(),
        state,
        scheme_name: String::new(),
        steps: 0,
        rejected: 0,
        last_output: None,
    };
    run.start_volume = run.model.flow.stored(&run.state.pressure);
    let (counters, solver, limit) = match plan.time.mode {
        TimeMode::Steady => run.steady()?,
        TimeMode::Transient => run.transient()?,
    };
    let wall = started.elapsed().as_secs_f64();
    run.finish(counters, solver, limit, wall)
}

type Effort = (
    SchemeCounters,
    Option<(String, String)>,
    Option<schemes::StepLimit>,
);

struct Run<'a, const D: usize> {
    plan: &'a Plan,
    model: Model<D>,
    writer: Option<&'a mut Writer>,
    observer: &'a mut dyn Observer,
    interrupt: &'a AtomicBool,
    timers: Timers,
    warnings: Vec<String>,
    start_volume: f64,
    balance: Balance,
    state: State,
    scheme_name: String,
    steps: u64,
    rejected: u64,
    last_output: Option<f64>,
}

impl<const D: usize> Run<'_, D> {
    fn failed(&self, source: StepError) -> RunError {
        RunError::Step {
            scheme: self.scheme_name.clone(),
            source,
            last_output: self.last_output,
        }
    }

    fn steady(&mut self) -> Result<Effort, RunError> {
        self.scheme_name = "steady".to_owned();
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(RunError::Interrupted { time: 0.0 });
        }
        let start = Instant::now();
        let solved = solve_steady(&self.model, &self.plan.solver, &mut self.state);
        self.timers.add("solve", start.elapsed().as_secs_f64());
        let (report, counters, solver) = solved.map_err(|error| self.failed(error))?;
        self.balance.add(&report.flows);
        self.balance.close(0.0);
        self.start_history()?;
        self.write_history(0.0, &report)?;
        self.write_fields()?;
        Ok((counters, Some(solver), None))
    }

    fn transient(&mut self) -> Result<Effort, RunError> {
        let plan = self.plan;
        let built = schemes::build(plan, &self.model);
        let mut scheme = built.map_err(|error| self.failed(error))?;
        self.scheme_name = scheme.name().to_owned();
        let scale = self.expected_range().map_err(|error| self.failed(error))?;
        let mut control = self.control(&*scheme);
        let mut stops = Stops::new(plan, &self.model.flow.breakpoints());
        self.start_history()?;
        self.write_history(0.0, &StepReport::default())?;
        self.write_fields()?;
        let mut range = scale.max(self.range());
        let mut trial = self.state.clone();
        while let Some(stop) = stops.next() {
            self.check_limits()?;
            let dt = clamp(control.dt(), stop.time - self.state.time);
            let start = Instant::now();
            let outcome = scheme.step(&self.model, &self.state, dt, &mut trial);
            self.timers.add("steps", start.elapsed().as_secs_f64());
            let report = match outcome {
                Ok(report) => report,
                Err(error) => {
                    self.rejected += 1;
                    if matches!(error, StepError::Unstable { .. })
                        || !control.cut(dt, SMALLEST * plan.time.end)
                    {
                        return Err(self.failed(error));
                    }
                    continue;
                }
            };
            let relative = report
                .error
                .map(|error| if range > 0.0 { error / range } else { 0.0 });
            if !control.judge(relative, dt) {
                self.rejected += 1;
                let smallest = TINIEST * plan.time.end + f64::EPSILON * self.state.time;
                if control.dt() < smallest {
                    let (time, dt) = (self.state.time, control.dt());
                    return Err(self.failed(StepError::TooSmall { time, dt }));
                }
                continue;
            }
            std::mem::swap(&mut self.state, &mut trial);
            self.steps += 1;
            let reached = stop.time - self.state.time < 1e-9 * dt;
            if reached {
                self.state.time = stop.time;
                stops.pass();
            }
            range = range.max(self.range());
            self.accepted(dt, &report, stop.output && reached)?;
        }
        Ok((scheme.counters(), scheme.solver(), scheme.limit().cloned()))
    }

    fn accepted(&mut self, dt: f64, report: &StepReport, output: bool) -> Result<(), RunError> {
        self.balance.add(&report.flows);
        let start = Instant::now();
        self.write_history(dt, report)?;
        if output {
            self.write_fields()?;
        }
        self.timers.add("output", start.elapsed().as_secs_f64());
        self.observer.step(&Progress {
            time: self.state.time,
            end: self.plan.time.end,
            dt,
            steps: self.steps,
            rejected: self.rejected,
            iterations: report.iterations,
        });
        Ok(())
    }

    fn check_limits(&mut self) -> Result<(), RunError> {
        let time = self.state.time;
        if self.interrupt.load(Ordering::Relaxed) {
            if self.last_output != Some(time) {
                self.write_fields()?;
            }
            return Err(RunError::Interrupted { time });
        }
        if self.steps as usize >= self.plan.time.max_steps {
            let (steps, end) = (self.plan.time.max_steps, self.plan.time.end);
            return Err(RunError::TooManySteps { steps, time, end });
        }
        Ok(())
    }

    fn control(&mut self, scheme: &dyn Scheme<D>) -> StepControl {
        let time = &self.plan.time;
        if let (Some(limit), StepRule::Adaptive) = (scheme.limit(), time.step) {
            let dt = time.safety * limit.dt;
            return StepControl::constant(dt.min(time.max_step.unwrap_or(dt)));
        }
        if let (Some(limit), StepRule::Fixed(dt)) = (scheme.limit(), time.step)
            && dt > limit.dt
        {
            let message = format!(
                "Δt = {dt:.6e} s is above the stability limit of {:.6e} s: the run will be unstable",
                limit.dt
            );
            self.observer.warn(&message);
            self.warnings.push(message);
        }
        let first = time.first_step.unwrap_or(1e-4 * time.end);
        StepControl::new(time, scheme.local_order(), first)
    }

    /// Range that the pressure will have, from one implicit step across the whole run: the scale of
    /// errors while the field itself is still flat.
    fn expected_range(&mut self) -> Result<f64, StepError> {
        let adaptive = self.plan.time.step == StepRule::Adaptive;
        if !adaptive || self.plan.scheme == SchemeChoice::Explicit {
            return Ok(0.0);
        }
        let mut probe = Implicit::new(Integrator::BackwardEuler, &self.plan.solver, &self.model)?;
        let mut far = self.state.clone();
        Scheme::<D>::step(
            &mut probe,
            &self.model,
            &self.state,
            self.plan.time.end,
            &mut far,
        )?;
        Ok(spread(&far.pressure, &self.model.flow.prescribed(far.time)))
    }

    fn range(&self) -> f64 {
        spread(
            &self.state.pressure,
            &self.model.flow.prescribed(self.state.time),
        )
    }

    fn start_history(&mut self) -> Result<(), RunError> {
        match &mut self.writer {
            Some(writer) => Ok(writer.start_history::<D>(self.plan)?),
            None => Ok(()),
        }
    }

    fn write_history(&mut self, dt: f64, report: &StepReport) -> Result<(), RunError> {
        let stored = self.model.flow.stored(&self.state.pressure) - self.start_volume;
        if self.plan.time.mode == TimeMode::Transient {
            self.balance.close(stored);
        }
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        writer.history(
            self.plan,
            &self.model,
            &self.state,
            dt,
            report.iterations,
            &self.balance,
        )?;
        Ok(())
    }

    fn write_fields(&mut self) -> Result<(), RunError> {
        self.last_output = Some(self.state.time);
        match &mut self.writer {
            Some(writer) => Ok(writer.fields(self.plan, &self.model, &self.state)?),
            None => Ok(()),
        }
    }

    fn finish(
        mut self,
        counters: SchemeCounters,
        solver: Option<(String, String)>,
        limit: Option<schemes::StepLimit>,
        wall: f64,
    ) -> Result<(Summary, State), RunError> {
        self.warn_of_imbalance();
        let flow = &self.model.flow;
        let rates = flow.outflow(&self.state.pressure, self.state.time);
        let outflow: BTreeMap<&'static str, f64> = Side::all(D)
            .map(|side| (side.name(), rates[side.index()]))
            .collect();
        let mut summary = Summary {
            case: self.plan.case.clone(),
            version: env!("CARGO_PKG_VERSION"),
            scheme: self.scheme_name.clone(),
            solver: solver.as_ref().map(|(name, _)| name.clone()),
            solver_reason: solver.map(|(_, reason)| reason),
            operator: flow.operator.name(),
            dimension: D,
            points: flow.points(),
            unknowns: flow.points() - flow.fixed.len(),
            bonds: flow.operator.neighbourhood().families.bonds(),
            nonzeros: flow.pattern.nonzeros(),
            second_hops: flow.operator.second_hops(),
            steps: self.steps,
            rejected: self.rejected,
            wall_s: wall,
            t_end: self.state.time,
            limit,
            errors: self.errors(&rates),
            outflow,
            pressure_range: extremes(&self.state.pressure),
            balance: self.balance.clone(),
            consistency: flow.consistency,
            counters: self.counters(counters),
            timers: self.timers.clone(),
            warnings: self.warnings.clone(),
        };
        if let Some(writer) = &mut self.writer {
            let start = Instant::now();
            writer.finish(self.plan, &self.model, &self.state)?;
            summary.timers.add("plots", start.elapsed().as_secs_f64());
            summary.wall_s += start.elapsed().as_secs_f64();
            writer.summary(&summary)?;
        }
        Ok((summary, self.state))
    }

    /// A balance this poor means that the linear systems are beyond what double precision resolves.
    fn warn_of_imbalance(&mut self) {
        let mass = self.balance.mass;
        if mass > POOR_BALANCE {
            let message = format!(
                "mass is balanced to {mass:.1e} of the turnover only: the permeability contrast \
                 leaves the pressure too few digits; trust the pressure, not the side rates"
            );
            self.observer.warn(&message);
            self.warnings.push(message);
        }
    }

    fn errors(&self, outflow: &[f64]) -> BTreeMap<&'static str, FieldError> {
        let mut errors = BTreeMap::new();
        let Ok(Some(exact)) = exact_pressure(self.plan) else {
            return errors;
        };
        let cloud = &self.model.cloud;
        let steady = self.plan.time.mode == TimeMode::Steady;
        if exact.steady_only() && !steady && !self.is_settled() {
            return errors;
        }
        let manufactured = self
            .plan
            .reference
            .is_some_and(|r| r.kind == ReferenceKind::Manufactured);
        let time = if steady && !manufactured {
            f64::INFINITY
        } else {
            self.state.time
        };
        let positions = cloud.position.iter().map(|x| x.as_slice());
        let norms = ErrorNorms::against(
            &*exact,
            time,
            positions,
            &cloud.volume,
            &self.state.pressure,
        );
        if let Ok(norms) = norms {
            errors.insert("pressure", norms.into());
        }
        if let Some(exact) = exact_flux(self.plan).filter(|_| steady) {
            let right = Side {
                axis: 0,
                upper: true,
            };
            let error = (outflow[right.index()] - exact).abs() / exact.abs();
            let (compared, excluded) = (1, 0);
            let flux = FieldError {
                l2: error,
                max: error,
                range: exact.abs(),
                compared,
                excluded,
            };
            errors.insert("flux", flux);
        }
        errors
    }

    /// Whether storage takes up next to nothing any more, so that a steady solution may be compared.
    fn is_settled(&self) -> bool {
        let (flow, state) = (&self.model.flow, &self.state);
        let mut imbalance = vec![0.0; state.pressure.len()];
        flow.imbalance(state.time, &state.pressure, &mut imbalance);
        let taken: f64 = imbalance.iter().map(|rate| rate.abs()).sum();
        taken <= SETTLED * flow.flows(&state.pressure, state.time).gross
    }

    fn counters(&self, scheme: SchemeCounters) -> Counters {
        let flow = &self.model.flow;
        let mut evaluations = BTreeMap::new();
        for effect in &flow.effects {
            *evaluations.entry(effect.effect().name()).or_insert(0) += effect.evaluations();
        }
        Counters {
            steps: self.steps,
            rejected: self.rejected,
            operator_products: scheme.products,
            refills: flow.refills,
            solver: scheme.solver,
            evaluations,
            field_bytes: self.state.fields().into_iter().collect(),
            bytes: flow.bytes().into_iter().collect(),
        }
    }
}

/// Mass balance, relative to the turnover, that is worth a warning.
const POOR_BALANCE: f64 = 1e-8;
/// Rate of storage, relative to all rates, below which a transient counts as settled.
const SETTLED: f64 = 1e-4;
/// Smallest step relative to the run to which a failing step is cut.
const SMALLEST: f64 = 1e-12;
/// The same for steps that are cut for accuracy: with next to no storage the first instant of a run
/// has a layer this thin.
const TINIEST: f64 = 1e-30;

fn extremes(values: &[f64]) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    values
        .iter()
        .fold(start, |[low, high], &v| [low.min(v), high.max(v)])
}

/// Largest minus smallest of the pressures and the prescribed ones.
fn spread(pressure: &[f64], walls: &[f64]) -> f64 {
    let ([low, high], [wall_low, wall_high]) = (extremes(pressure), extremes(walls));
    high.max(wall_high) - low.min(wall_low)
}
