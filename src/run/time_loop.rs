//! The time loop.

use std::path::PathBuf;
use std::time::Instant;

use perifrac_solvers::Interrupt;

use super::audit::Stored;
use super::checkpoint::{Checkpoint, Saver};
use super::fracture::{CrackTracker, Fractures};
use super::job::{Job, Observer, Progress};
use super::rejections::Rejections;
use super::restart::Before;
use super::scale::Scale;
use super::settings::Settings;
use super::stops::{OutputSchedule, clamp};
use super::{RunError, Summary, TimedErrors, Writer, takeover};
use crate::model::Model;
use crate::output::OutputError;
use crate::plan::{Plan, StepRule, TimeMode};
use crate::report::{Balance, Timers};
use crate::schemes::{self, Scheme, SchemeCounters, State, StepControl, StepError, StepReport};

/// Runs a plan; the final state comes with the summary.
///
/// # Errors
/// [`RunError`]; what was written until then is complete.
pub fn run(
    plan: &Plan,
    writer: Option<&mut Writer>,
    observer: &mut dyn Observer,
    interrupt: &Interrupt,
) -> Result<(Summary, State), RunError> {
    let job = Job {
        writer,
        ..Job::new(observer, interrupt)
    };
    run_job(plan, job)
}

/// As [`run`].
///
/// # Errors
/// As [`run`]; [`RunError::Elsewhere`] if another process failed.
pub fn run_job(plan: &Plan, job: Job<'_>) -> Result<(Summary, State), RunError> {
    // Here, so that programs need not compile the schemes once more for their own calls.
    match plan.dimension {
        2 => run_in::<2>(plan, job),
        _ => run_in::<3>(plan, job),
    }
}

fn run_in<const D: usize>(plan: &Plan, job: Job<'_>) -> Result<(Summary, State), RunError> {
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
    let state = takeover::initial_state(plan, from.as_ref(), &mut model, processes)?;
    let warnings: Vec<String> = plan
        .warnings
        .iter()
        .chain(&model.warnings)
        .cloned()
        .chain(super::writer::undrawn(plan, writer.as_deref()))
        .collect();
    warnings.iter().for_each(|warning| observer.warn(warning));
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
        last_step: (0.0, StepReport::default()),
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
    /// Length of the last step, s, and what it did.
    pub(super) last_step: (f64, StepReport),
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

    pub(super) fn first_output(&mut self, report: &StepReport) -> Result<(), RunError> {
        self.start_history()?;
        self.write_history(0.0, report)?;
        self.drawn = self.tracker.results.crack_length;
        self.write_fields()?;
        self.show();
        Ok(())
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
        self.last_fields()?;
        Ok((
            self.effort(&*scheme),
            scheme.solver(),
            scheme.limit().cloned(),
        ))
    }

    /// Brings the initial state to what the scene asks for, and finds what steps are measured by.
    fn begin(&mut self, scheme: &mut dyn Scheme<D>) -> Result<March, RunError> {
        let timers = self.timers.clone();
        // Cracks that are taken over are full of their fluid.
        self.follow_state();
        let started = timers.time("start", || scheme.start(&self.model, &mut self.state));
        started.map_err(|error| self.failed(error))?;
        self.follow_state();
        self.settle_wells().map_err(|error| self.failed(error))?;
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
            let step = || self.step(scheme, dt, &mut trial);
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
            if self.is_enough() {
                break;
            }
        }
        Ok(())
    }

    /// Brings the model to the coefficients of the accepted state.
    pub(super) fn follow_state(&mut self) {
        if let Some(coefficients) = &self.state.coefficients {
            self.model = self.model.with(coefficients);
        }
        self.follow_wells();
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
        self.show();
        Ok(written)
    }

    /// Whether the user stopped any of the processes.
    pub(super) fn is_interrupted(&self) -> bool {
        let mut stopped = [f64::from(u8::from(self.interrupt.is_raised()))];
        self.model.subdomain().sum(&mut stopped);
        stopped[0] > 0.5
    }

    /// Whether an observer of any of the processes has seen enough.
    fn is_enough(&mut self) -> bool {
        let mut enough = [f64::from(u8::from(self.observer.is_enough()))];
        self.model.subdomain().sum(&mut enough);
        enough[0] > 0.5
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

    fn start_history(&mut self) -> Result<(), RunError> {
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let started = writer.start_history::<D>(self.plan);
        self.agree(started)
    }

    fn write_history(&mut self, dt: f64, report: &StepReport) -> Result<(), RunError> {
        self.watch_suction();
        self.last_step = (dt, report.clone());
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

/// Smallest step relative to the run to which a failing step is cut.
const SMALLEST: f64 = 1e-12;
/// The same for steps that are cut for accuracy: with next to no storage the first instant of a run
/// has a layer this thin.
const TINIEST: f64 = 1e-30;
