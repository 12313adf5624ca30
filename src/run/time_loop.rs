//! The time loop.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use perifrac_solvers::{Communicator, Interrupt};

use super::audit::Stored;
use super::checkpoint::{Checkpoint, Saver, Snapshot};
use super::fracture::{CrackTracker, Fractures};
use super::rejections::Rejections;
use super::restart::Before;
use super::scale::Scale;
use super::settings::Settings;
use super::stops::{OutputSchedule, clamp};
use super::{RunError, Summary, TimedErrors, Writer, takeover};
use crate::model::Model;
use crate::output::OutputError;
use crate::plan::{Integrator, Plan, SchemeChoice, StepRule, TimeMode, TimePlan};
use crate::report::{Balance, Timers};
use crate::schemes::{
    self, Assembled, FlowStage, Fracture, Implicit, Scheme, SchemeCounters, SolidSolver, State,
    StepControl, StepError, StepReport, solve_steady,
};

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
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
    /// Passes between the fields in the last step, and what the last of them left, relative to its scale.
    pub passes: Option<(usize, f64)>,
    /// Energy of Eq. 73 less the work of the loads, J; with mechanics.
    pub potential: Option<f64>,
    /// Length of all cracks, m (area in space, m²); with damage.
    pub crack_length: Option<f64>,
}

/// Is told how a run goes on; `()` does not listen.
///
/// To stop a run from here, raise its [`Interrupt`].
///
/// ```
/// use perifrac::prelude::*;
///
/// struct Impatient(Interrupt);
///
/// impl Observer for Impatient {
///     fn step(&mut self, progress: &Progress) {
///         if progress.steps == 3 {
///             self.0.raise();
///         }
///     }
/// }
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
/// let interrupt = Interrupt::default();
/// let ended = run::<2>(&plan, None, &mut Impatient(interrupt.clone()), &interrupt);
/// assert!(matches!(ended, Err(RunError::Interrupted { .. })));
/// # Ok::<(), SceneErrors>(())
/// ```
pub trait Observer {
    /// A doubt arose.
    fn warn(&mut self, _message: &str) {}
    /// A step was accepted.
    fn step(&mut self, _progress: &Progress) {}
    /// The fields after that step.
    fn state(&mut self, _state: &State) {}
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
    interrupt: &Interrupt,
) -> Result<(Summary, State), RunError> {
    let job = Job {
        writer,
        ..Job::new(observer, interrupt)
    };
    run_job::<D>(plan, job)
}

/// What a run works with, beside its plan.
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
/// let (interrupt, mut listener) = (Interrupt::default(), ());
/// let job = Job {
///     settings: Settings { reject_every: Some(2), ..Settings::default() },
///     ..Job::new(&mut listener, &interrupt)
/// };
/// // Every second step is done twice, which must change nothing.
/// let (_, state) = run_job::<2>(&plan, job)?;
/// let (_, usual) = run::<2>(&plan, None, &mut (), &interrupt)?;
/// assert_eq!(state.pressure, usual.pressure);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Job<'a> {
    /// Other processes, if there are any: all must run the same plan together, each with its own writer.
    /// The summary and the state are the same everywhere.
    pub team: Option<&'a Arc<dyn Communicator>>,
    /// Writes the files of the run.
    pub writer: Option<&'a mut Writer>,
    /// Is told how the run goes on.
    pub observer: &'a mut dyn Observer,
    /// Stops the run.
    pub interrupt: &'a Interrupt,
    /// How the run is done.
    pub settings: Settings,
    /// Folder that paths of the scene are relative to, for checkpoints.
    pub base: PathBuf,
    /// Where the run goes on from; its beginning without one.
    pub from: Option<Checkpoint>,
    /// Takes in the state every now and then, for whoever ends the program while a step cannot be left.
    pub snapshot: Snapshot,
}

impl<'a> Job<'a> {
    /// A run in this process alone, without files.
    pub fn new(observer: &'a mut dyn Observer, interrupt: &'a Interrupt) -> Self {
        Job {
            team: None,
            writer: None,
            observer,
            interrupt,
            settings: Settings::default(),
            base: PathBuf::new(),
            from: None,
            snapshot: Snapshot::default(),
        }
    }
}

/// As [`run`].
///
/// # Errors
/// As [`run`]; [`RunError::Elsewhere`] if another process failed.
pub fn run_job<const D: usize>(plan: &Plan, job: Job<'_>) -> Result<(Summary, State), RunError> {
    let Job {
        team,
        writer,
        observer,
        interrupt,
        settings,
        base,
        from,
        snapshot,
    } = job;
    let started = Instant::now();
    let processes = team.map_or(1, |team| team.size());
    schemes::check(plan, processes).map_err(|error| RunError::refused(plan, error))?;
    let mut timers = Timers::default();
    timers.begin("other");
    let mut model = Model::<D>::build_with(plan, team, &mut timers)?;
    let warnings: Vec<String> = plan
        .warnings
        .iter()
        .chain(&model.warnings)
        .cloned()
        .chain(super::writer::undrawn(plan, writer.as_deref()))
        .collect();
    warnings.iter().for_each(|warning| observer.warn(warning));
    let state = takeover::initial_state(plan, from.as_ref(), &mut model, processes)?;
    let plan = &takeover::at_its_time(plan, from.as_ref(), &state)?;
    let mut run = Run {
        plan,
        model,
        writer,
        observer,
        interrupt,
        timers,
        warnings,
        start_volume: [0.0; 2],
        balance: Balance::default(),
        state,
        scheme_name: String::new(),
        steps: 0,
        rejections: Rejections::default(),
        last_output: None,
        timed_errors: Vec::new(),
        tracker: CrackTracker::default(),
        drawn: 0.0,
        pressed: Some(0.0),
        unsettled: 0.0,
        aside: SchemeCounters::default(),
        settings,
        base,
        from,
        saver: None,
        before: Before::default(),
        started,
    };
    run.saver = run.new_saver(&snapshot);
    run.start_volume = Stored::of(&run.model, &run.state).parts;
    let effort = interrupt.during(|| match plan.time.mode {
        TimeMode::Steady => run.steady(),
        TimeMode::Transient => run.transient(),
    })?;
    let wall = run.wall();
    run.finish(effort, wall)
}

type Steady = (StepReport, SchemeCounters, Option<(String, String)>);

pub(super) type Effort = (
    SchemeCounters,
    Option<(String, String)>,
    Option<schemes::StepLimit>,
);

pub(super) struct Run<'a, const D: usize> {
    pub(super) plan: &'a Plan,
    pub(super) model: Model<D>,
    pub(super) writer: Option<&'a mut Writer>,
    pub(super) observer: &'a mut dyn Observer,
    pub(super) interrupt: &'a Interrupt,
    pub(super) timers: Timers,
    pub(super) warnings: Vec<String>,
    pub(super) start_volume: [f64; 2],
    pub(super) balance: Balance,
    pub(super) state: State,
    pub(super) scheme_name: String,
    pub(super) steps: u64,
    pub(super) rejections: Rejections,
    pub(super) last_output: Option<f64>,
    pub(super) timed_errors: Vec<TimedErrors>,
    pub(super) tracker: CrackTracker,
    /// Length of the cracks at the last output that their growth asked for, m.
    pub(super) drawn: f64,
    /// Largest pressure so far, in absolute amount, Pa; `None` once one below zero was reported.
    pub(super) pressed: Option<f64>,
    /// Pressure that strain has left unsettled in the last steps, Pa: swings pass through zero.
    pub(super) unsettled: f64,
    /// Work beside that of the scheme: the step that finds the range.
    pub(super) aside: SchemeCounters,
    pub(super) settings: Settings,
    pub(super) base: PathBuf,
    pub(super) from: Option<Checkpoint>,
    /// Writes checkpoints, in the process that leads.
    pub(super) saver: Option<Saver>,
    pub(super) before: Before,
    pub(super) started: Instant,
}

/// What the time loop goes by.
pub(super) struct March {
    pub scale: Scale,
    pub control: StepControl,
    pub stops: OutputSchedule,
}

impl<const D: usize> Run<'_, D> {
    pub(super) fn failed(&self, source: StepError) -> RunError {
        if source.is_interruption() {
            let time = self.state.time;
            return RunError::Interrupted { time };
        }
        RunError::Step {
            scheme: self.scheme_name.clone(),
            source,
            last_output: self.last_output,
        }
    }

    fn steady(&mut self) -> Result<Effort, RunError> {
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

    fn first_output(&mut self, report: &StepReport) -> Result<(), RunError> {
        self.start_history()?;
        self.write_history(0.0, report)?;
        self.drawn = self.tracker.results.crack_length;
        self.write_fields()
    }

    /// The drained state: flow first, then the solid under its pressure.
    fn steady_state(&mut self) -> Result<Steady, StepError> {
        let mut steady: Steady = (StepReport::default(), SchemeCounters::default(), None);
        if let Some(flow) = &self.model.flow {
            let (report, counters, chosen) =
                solve_steady(flow, &self.plan.stage_demand(), &mut self.state)?;
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

    fn transient(&mut self) -> Result<Effort, RunError> {
        let plan = self.plan;
        self.scheme_name = plan.scheme.name().to_owned();
        let timers = self.timers.clone();
        let built = timers.time("scheme", || schemes::build(plan, &self.model));
        let mut scheme = built.map_err(|error| self.failed(error))?;
        self.scheme_name = scheme.name().to_owned();
        let mut march = match self.from.take() {
            None => self.begin(&mut *scheme)?,
            Some(checkpoint) => self.go_on(&mut *scheme, &checkpoint)?,
        };
        if let Err(error) = self.march(&mut *scheme, &mut march) {
            return Err(self.end_early(&*scheme, &march, error));
        }
        self.save_end(&*scheme, &march);
        Ok((
            self.effort(&*scheme),
            scheme.solver(),
            scheme.limit().cloned(),
        ))
    }

    /// Brings the initial state to what the scene asks for, and finds what steps are measured by.
    fn begin(&mut self, scheme: &mut dyn Scheme<D>) -> Result<March, RunError> {
        let timers = self.timers.clone();
        let started = timers.time("start", || scheme.start(&self.model, &mut self.state));
        started.map_err(|error| self.failed(error))?;
        self.follow_state();
        // The start moves no fluid, but for what points of prescribed pressure take in.
        self.start_volume = Stored::of(&self.model, &self.state).parts;
        let scale = timers.time("range", || self.scale());
        let scale = scale.map_err(|error| self.failed(error))?;
        let control = self.control(scheme);
        let stops = OutputSchedule::new(self.plan, &self.model.breakpoints());
        let balanced = self.audit(&self.model, &StepReport::default(), &self.state);
        self.balance = balanced.map_err(|error| self.failed(error))?;
        timers.time("output", || self.first_output(&StepReport::default()))?;
        Ok(March {
            scale,
            control,
            stops,
        })
    }

    /// Steps to the end.
    fn march(&mut self, scheme: &mut dyn Scheme<D>, march: &mut March) -> Result<(), RunError> {
        let timers = self.timers.clone();
        let mut trial = self.state.clone();
        self.keep(scheme, march, false);
        let mut thrown = false;
        while let Some(stop) = march.stops.next() {
            self.check_limits()?;
            let allowed = self.allowed(scheme).min(march.control.dt());
            let dt = clamp(allowed, stop.time - self.state.time);
            let step = || scheme.step(&self.model, &self.state, dt, &mut trial);
            let outcome = timers.time("steps", step);
            let reached = stop.time - trial.time < 1e-9 * dt;
            if outcome.is_ok() && reached {
                trial.time = stop.time;
            }
            let ahead = self.model.at(trial.coefficients.as_ref());
            let audit = |report| Ok((self.audit(&ahead, &report, &trial)?, report));
            let audited = outcome.and_then(|report| timers.time("audit", || audit(report)));
            let (balance, report) = match audited {
                Ok(sound) => sound,
                Err(error) => {
                    if error.is_interruption() {
                        // The state before the step stands, and is written.
                        self.check_limits()?;
                    }
                    self.rejections.count(error.reason());
                    if error.is_final() || !march.control.cut(dt, SMALLEST * self.plan.time.end) {
                        return Err(self.failed(error));
                    }
                    continue;
                }
            };
            if self.is_thrown_away(&mut thrown) {
                continue;
            }
            let verdict = self.judged(&march.scale, &report, &trial, dt);
            if !march.control.judge(verdict.largest(), dt) {
                self.rejections.count(verdict.reason());
                self.check_smallest(march.control.dt())?;
                continue;
            }
            drop(ahead);
            self.remember_lag(&report);
            if stop.output && reached {
                let settled = self.audit_output(&march.scale, &trial, &balance);
                settled.map_err(|error| self.failed(error))?;
            }
            std::mem::swap(&mut self.state, &mut trial);
            self.follow_state();
            self.steps += 1;
            self.balance = balance;
            if reached {
                march.stops.pass();
            }
            march.scale.cover(&self.model, &self.state.pressure);
            let output = self.accepted(dt, &report, stop.output && reached)?;
            self.keep(scheme, march, output);
        }
        Ok(())
    }

    /// Brings the model to the coefficients of the accepted state.
    pub(super) fn follow_state(&mut self) {
        if let Some(coefficients) = &self.state.coefficients {
            self.model = self.model.with(coefficients);
        }
    }

    /// Whether a sound step is to be done once more, which must change nothing.
    fn is_thrown_away(&self, thrown: &mut bool) -> bool {
        let due = |every: u64| (self.steps + 1).is_multiple_of(every);
        *thrown = !*thrown && self.settings.reject_every.is_some_and(due);
        *thrown
    }

    /// Steps that fall below all measure will not end the run.
    fn check_smallest(&self, dt: f64) -> Result<(), RunError> {
        let time = self.state.time;
        let smallest = TINIEST * self.plan.time.end + f64::EPSILON * time;
        match dt < smallest {
            true => Err(self.failed(StepError::TooSmall { time, dt })),
            false => Ok(()),
        }
    }

    /// Writes what follows an accepted step; gives whether fields were among it.
    fn accepted(&mut self, dt: f64, report: &StepReport, output: bool) -> Result<bool, RunError> {
        let timers = self.timers.clone();
        let mut written = false;
        timers.time("output", || {
            self.write_history(dt, report)?;
            written = output | self.has_grown();
            match written {
                true => self.write_fields(),
                false => Ok(()),
            }
        })?;
        self.observer.step(&Progress {
            time: self.state.time,
            end: self.plan.time.end,
            dt,
            steps: self.steps,
            rejected: self.rejections.total(),
            iterations: report.iterations,
            passes: report.residual.map(|left| (report.passes, left)),
            potential: self.balance.potential,
            crack_length: self.tracker.last.as_ref().map(|last| last.crack_length),
        });
        self.observer.state(&self.state);
        Ok(written)
    }

    /// Whether the user stopped any of the processes.
    fn is_interrupted(&self) -> bool {
        let mut stopped = [f64::from(u8::from(self.interrupt.is_raised()))];
        self.model.subdomain().sum(&mut stopped);
        stopped[0] > 0.5
    }

    /// A failure of one process is a failure of all, so that none waits for another.
    pub(super) fn agree(&self, result: Result<(), OutputError>) -> Result<(), RunError> {
        let mut failed = [f64::from(u8::from(result.is_err()))];
        self.model.subdomain().sum(&mut failed);
        match result {
            Ok(()) if failed[0] > 0.5 => Err(RunError::Elsewhere),
            result => Ok(result?),
        }
    }

    fn check_limits(&self) -> Result<(), RunError> {
        let time = self.state.time;
        if self.is_interrupted() {
            return Err(RunError::Interrupted { time });
        }
        if self.steps as usize >= self.plan.time.max_steps {
            let (steps, end) = (self.plan.time.max_steps, self.plan.time.end);
            return Err(RunError::TooManySteps { steps, time, end });
        }
        Ok(())
    }

    /// Longest step that a scheme may take now, s, where steps are not prescribed.
    fn allowed(&self, scheme: &dyn Scheme<D>) -> f64 {
        match (scheme.limit(), self.plan.time.step) {
            (Some(limit), StepRule::Adaptive) => self.plan.time.safety * limit.dt,
            _ => f64::INFINITY,
        }
    }

    fn control(&mut self, scheme: &dyn Scheme<D>) -> StepControl {
        let time = &self.plan.time;
        let dt = self.allowed(scheme);
        // In fractures explicit steps have an error as well, and their limit is far off in tight rock.
        if dt.is_finite() && self.plan.fracture_flow.is_none() {
            return StepControl::bounded(dt, time.max_step.unwrap_or(f64::INFINITY));
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
        let first = time.first_step.unwrap_or(1e-4 * (time.end - time.start));
        let control = StepControl::new(time, scheme.local_order(), first);
        match self.plan.damage {
            Some(_) => control.restless(),
            None => control,
        }
    }

    /// What errors of the pressure are measured against. Sources do not tell how far they will drive it: implicit
    /// steps of the flow from one break of the loads to the next do, across the whole run.
    fn scale(&mut self) -> Result<Scale, StepError> {
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

    fn start_history(&mut self) -> Result<(), RunError> {
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let started = writer.start_history::<D>(self.plan);
        self.agree(started)
    }

    fn write_history(&mut self, dt: f64, report: &StepReport) -> Result<(), RunError> {
        self.watch_suction();
        if self.plan.damage.is_some() {
            let now = Fractures::of(self.plan, &self.model, &self.state);
            let time = self.state.time;
            self.tracker.follow(self.plan, &self.model, time, now);
        }
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let written = writer.history(
            self.plan,
            &self.model,
            &self.state,
            (dt, report, self.rejections),
            &self.balance,
            self.tracker.last.as_ref(),
        );
        self.agree(written)
    }

    pub(super) fn write_fields(&mut self) -> Result<(), RunError> {
        self.last_output = Some(self.state.time);
        if self.state.time > self.plan.time.start || self.plan.time.mode == TimeMode::Steady {
            self.record_errors();
        }
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let written = writer.piece(self.plan, &self.model, &self.state);
        self.agree(written)?;
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let completed = writer.fields(self.plan, &self.model, &self.state);
        self.agree(completed)
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

/// Smallest step relative to the run to which a failing step is cut.
const SMALLEST: f64 = 1e-12;
/// The same for steps that are cut for accuracy: with next to no storage the first instant of a run
/// has a layer this thin.
const TINIEST: f64 = 1e-30;
