//! Going on from a checkpoint, and writing them.

use std::collections::BTreeMap;
use std::time::Instant;

use super::checkpoint::{Checkpoint, Course, Record, RunIdentity, Saver, Snapshot};
use super::stops::OutputSchedule;
use super::time_loop::{March, Run};
use super::{RunError, TimedErrors};
use crate::geometry::Cloud;
use crate::output::OutputError;
use crate::report::Balance;
use crate::schemes::{Scheme, SchemeCounters};

/// Work of a run before it was stopped.
#[derive(Debug, Clone, Default)]
pub(super) struct Before {
    pub effort: SchemeCounters,
    pub evaluations: BTreeMap<String, u64>,
    pub refills: u64,
    pub wall_s: f64,
}

impl<const D: usize> Run<'_, D> {
    /// What writes checkpoints, where they are wanted and this process writes files.
    pub(super) fn new_saver(&self, snapshot: &Snapshot) -> Option<Saver> {
        let writer = self.writer.as_ref().filter(|writer| writer.leads())?;
        Saver::new(writer.folder(), &self.settings, snapshot)
    }

    /// Wall time of the run so far, s.
    pub(super) fn wall(&self) -> f64 {
        self.before.wall_s + self.started.elapsed().as_secs_f64()
    }

    /// All work so far.
    pub(super) fn effort(&self, scheme: &dyn Scheme<D>) -> SchemeCounters {
        let mut effort = scheme.counters();
        effort.add(&self.aside);
        effort.add(&self.before.effort);
        effort
    }

    fn processes(&self) -> usize {
        let partition = self.model.subdomain().partition();
        partition.map_or(1, |own| own.team().size())
    }

    /// Brings a run to where it stood at a checkpoint.
    pub(super) fn go_on(
        &mut self,
        scheme: &mut dyn Scheme<D>,
        checkpoint: &Checkpoint,
    ) -> Result<March, RunError> {
        checkpoint.check_processes(self.processes())?;
        checkpoint.check_cloud(&self.model.cloud)?;
        checkpoint.check_effects(&self.evaluations())?;
        let Record { state, course, .. } = &checkpoint.record;
        self.state.clone_from(state);
        self.follow_state();
        scheme.recall(&self.state.memory);
        let (model, state) = (&self.model, &self.state);
        self.balance = Balance::restore(&course.balance, |balance| {
            self.measure_mechanics(model, state, balance);
        });
        self.start_volume = course.start_volume;
        self.steps = course.steps;
        self.rejections = course.rejections;
        self.last_output = course.last_output;
        let errors = course.errors.iter().cloned();
        let errors = errors.map(|(time, errors)| TimedErrors { time, errors });
        self.timed_errors = errors.collect();
        self.tracker.results = course.results();
        self.tracker.broken_at.clone_from(&course.broken_at);
        self.tracker.last = super::fracture::Fractures::of(self.plan, &self.model, &self.state);
        (self.drawn, self.pressed) = (course.drawn, course.pressed);
        self.unsettled = course.unsettled;
        self.warnings.clone_from(&course.warnings);
        self.timers.add(&course.timers);
        self.before = Before {
            effort: course.effort.clone(),
            evaluations: course.evaluations.clone(),
            refills: course.refills,
            wall_s: course.wall_s,
        };
        let mut stops = OutputSchedule::new(self.plan, &self.model.breakpoints());
        (0..course.passed).for_each(|_| stops.pass());
        if let Some(writer) = &mut self.writer {
            let stood = (self.state.time, course.last_output);
            let files = &checkpoint.record.files;
            let resumed = writer.resume(self.plan, &self.model, files, stood);
            self.agree(resumed)?;
        }
        Ok(March {
            scale: course.scale,
            control: course.control.clone(),
            stops,
        })
    }

    /// Pressure that the run began with, where another one left it.
    fn taken_over(&self) -> Vec<f64> {
        let flow = self
            .model
            .flow
            .as_ref()
            .filter(|_| self.plan.start.is_some());
        flow.map_or_else(Vec::new, |flow| flow.initial.clone())
    }

    /// Everything from which the run could go on.
    fn record(&self, scheme: &dyn Scheme<D>, march: &March) -> Option<Record> {
        let writer = self.writer.as_ref()?;
        Some(Record {
            scene: writer.resolved().to_owned(),
            base: self.base.clone(),
            state: self.state.clone(),
            files: writer.record(),
            course: Course {
                start: self.plan.time.start,
                reference: self.taken_over(),
                scale: march.scale,
                control: march.control.clone(),
                passed: march.stops.passed(),
                balance: self.balance.record(),
                start_volume: self.start_volume,
                steps: self.steps,
                rejections: self.rejections,
                last_output: self.last_output,
                errors: (self.timed_errors.iter())
                    .map(|at| (at.time, at.errors.clone()))
                    .collect(),
                results: serde_json::to_string(&self.tracker.results).unwrap_or_default(),
                broken_at: self.tracker.broken_at.clone(),
                drawn: self.drawn,
                pressed: self.pressed,
                unsettled: self.unsettled,
                effort: self.effort(scheme),
                evaluations: self.all_evaluations(),
                refills: self.all_refills(),
                warnings: self.warnings.clone(),
                wall_s: self.wall(),
                timers: self.timers.phases(),
            },
        })
    }

    /// Evaluations of all effects so far, by name.
    pub(super) fn all_evaluations(&self) -> BTreeMap<String, u64> {
        let mut all = self.before.evaluations.clone();
        for (name, count) in self.evaluations() {
            *all.entry(name.to_owned()).or_insert(0) += count;
        }
        all
    }

    /// Times that L was filled so far.
    pub(super) fn all_refills(&self) -> u64 {
        let own = self.model.flow.as_ref().map_or(0, |flow| flow.refills());
        self.before.refills + own
    }

    /// After a step: writes a checkpoint where one is due, or else tells of the state now and then.
    pub(super) fn keep(&mut self, scheme: &dyn Scheme<D>, march: &March, output: bool) {
        let Some(saver) = &self.saver else { return };
        if saver.is_due(output) {
            self.save(scheme, march);
        } else if saver.is_to_tell() {
            let begun = Instant::now();
            let (record, processes) = (self.record(scheme, march), self.processes());
            let (Some(record), Some(saver)) = (record, &mut self.saver) else {
                return;
            };
            saver.tell(
                &identity(self.plan, &self.model.cloud, processes),
                &record,
                begun,
            );
        }
    }

    /// Writes a checkpoint; one that cannot be written is told of, and the run goes on with the ones before.
    fn save(&mut self, scheme: &dyn Scheme<D>, march: &March) {
        if let Err(error) = self.try_save(scheme, march) {
            let message = format!("no checkpoint could be written, those before stay: {error}");
            self.observer.warn(&message);
            self.warnings.push(message);
        }
    }

    fn try_save(&mut self, scheme: &dyn Scheme<D>, march: &March) -> Result<(), OutputError> {
        if self.saver.is_none() {
            return Ok(());
        }
        let (record, processes) = (self.record(scheme, march), self.processes());
        let (Some(record), Some(saver)) = (record, &mut self.saver) else {
            return Ok(());
        };
        let at = identity(self.plan, &self.model.cloud, processes);
        self.timers
            .time("checkpoint", || saver.save(&at, &record).map(drop))
    }

    /// The last checkpoint, of a run that has reached its end: others may begin with it.
    pub(super) fn save_end(&mut self, scheme: &dyn Scheme<D>, march: &March) {
        self.save(scheme, march);
    }

    /// Writes the fields of a run that ends between two outputs; what goes on from its checkpoint drops them again.
    pub(super) fn last_fields(&mut self) -> Result<(), RunError> {
        match self.last_output == Some(self.state.time) {
            true => Ok(()),
            false => self.write_fields(),
        }
    }

    /// Keeps the state of a run that ends before its time, first of all in a checkpoint.
    pub(super) fn end_early(
        &mut self,
        scheme: &dyn Scheme<D>,
        march: &March,
        error: RunError,
    ) -> RunError {
        // Where outputs cannot be written a checkpoint often cannot either, which need not be told as well.
        match error {
            RunError::Output(_) => drop(self.try_save(scheme, march)),
            _ => self.save(scheme, march),
        }
        self.show_end();
        let stopped = matches!(error, RunError::Interrupted { .. });
        let error = match stopped {
            true => self.last_fields().err().unwrap_or(error),
            false => error,
        };
        match (&error, &mut self.writer) {
            (RunError::Output(_), _) | (_, None) => error,
            (_, Some(writer)) => {
                let drawn = writer.draw_pending(self.plan, &self.model);
                drawn.err().map_or(error, RunError::Output)
            }
        }
    }
}

fn identity<'a, const D: usize>(
    plan: &'a crate::plan::Plan,
    cloud: &'a Cloud<D>,
    processes: usize,
) -> RunIdentity<'a, D> {
    RunIdentity {
        plan,
        cloud,
        processes,
    }
}
