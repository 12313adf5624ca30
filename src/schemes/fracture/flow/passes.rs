//! Passes between coefficients, pressure and displacement until forces balance.

use super::super::not_finite;
use super::stored::StepStart;
use super::{FractureFlowStep, Trial};
use crate::material::TangentKind;
use crate::model::{Model, Spreading};
use crate::operators::Response;
use crate::schemes::fracture::damage_of;
use crate::schemes::stagnation::Stagnation;
use crate::schemes::{State, StepError, StepReport, flow_of, solid_of};

/// Forces out of balance, relative to all, from which passes are taken to contract.
pub(super) const NEAR: f64 = 3e-2;
/// Share of the imbalance before a pass that may be left by it before something is amiss.
const SLOW: f64 = 0.7;
/// Growth of the imbalance in a pass from which what earlier passes taught is forgotten.
const WORSE: f64 = 2.0;
/// Growth of damage over the one that is allowed from which a step is given up at once.
const HOPELESS: f64 = 2.5;
/// Share of the largest force so far that still counts as a scale.
const REMEMBERED: f64 = 1e-2;
/// Residual of the coupled linear systems at first, and the smallest. A crack that is full answers to
/// a wrong volume with a pressure that is wrong by the ratio of its compliance to that of the fluid. At first
/// 1e-4 took gmres 37 passes and 14.8 s for the first steps of `injection-rate/smoke`, 1e-5 takes 28, as a factor does, and 8.5 s.
pub const FORCING: f64 = 1e-5;
const LEAST_FORCING: f64 = 1e-8;
/// Passes that are remembered where coefficients lag, and where the pressure has modes of its own, which
/// the compliance fits more or less.
pub const SHALLOW: usize = 4;
/// Volume that the pressure still owes the strain, relative to what the pores take up, that is none.
const OWED: f64 = 1e-7;
/// The same once passes make no progress any more: the audit allows a thousand times as much.
const STILL_OWED: f64 = 1e-5;

/// Passes without progress after which they are shortened by a half, where the pressure answers to the
/// strain, and after which the step is given up.
const STUCK: usize = 8;
const GIVEN_UP: usize = 100;
/// Damage, summed over points, that counts as progress of a crack that runs.
const ADVANCE: f64 = 0.5;
/// Times that a start is brought to where its fluid is.
pub(super) const RETURNS: usize = 4;
/// Shortest share of a pass.
const SHORTEST: f64 = 0.125;

/// Where the passes of a step stand.
pub(super) struct PassMonitor {
    /// Smallest imbalance so far.
    pub best: f64,
    /// Smallest share owed while forces balanced.
    pub splitting_residual: f64,
    /// That of the pass before.
    before: f64,
    /// Of the larger of both, what is out of balance and what is owed, over what is allowed.
    stagnation: Stagnation,
    /// Passes without progress.
    stuck: usize,
    /// Damage summed over points when the crack last made progress.
    broken: f64,
    /// Share of a pass that is taken: passes that go round in circles meet where they are shortened.
    share: f64,
}

impl PassMonitor {
    /// Before the first pass, with so much damage summed over points.
    pub fn new(broken: f64) -> Self {
        PassMonitor {
            best: f64::INFINITY,
            splitting_residual: f64::INFINITY,
            before: f64::INFINITY,
            stagnation: Stagnation::new(),
            stuck: 0,
            broken,
            share: 1.0,
        }
    }

    /// Takes note of how far off a pass starts and of how many points' worth has broken; false once there
    /// is no hope. A crack that runs is far off for long, but breaks on.
    pub fn continues(&mut self, off: f64, broken: f64, shortens: bool) -> bool {
        let mut stuck = self.stagnation.note(off);
        if broken >= self.broken + ADVANCE {
            self.stagnation.forgive();
            (self.broken, stuck) = (broken, 0);
        }
        if shortens && stuck > 0 && stuck.is_multiple_of(STUCK) {
            self.share = (0.5 * self.share).max(SHORTEST);
        }
        self.stuck = stuck;
        stuck < GIVEN_UP
    }

    /// Whether passes have made no progress for a while.
    pub fn is_stuck(&self) -> bool {
        self.stuck >= STUCK
    }

    /// Share that strain may owe.
    fn allowed(&self) -> f64 {
        match self.is_stuck() {
            true => STILL_OWED,
            false => OWED,
        }
    }

    /// Why passes were given up.
    pub fn failure(&self, time: f64, tolerance: f64, iterations: usize) -> StepError {
        match self.splitting_residual.is_finite() {
            true => StepError::Owed {
                time,
                splitting_residual: self.splitting_residual,
                allowed: STILL_OWED,
                iterations,
            },
            false => StepError::NotBroken {
                time,
                residual: self.best,
                tolerance,
                iterations,
            },
        }
    }
}

/// Where a pass starts.
struct Pass {
    /// What passes move, before the pressure was brought to the displacement.
    start: Vec<f64>,
    /// Forces out of balance, relative to all forces.
    imbalance: f64,
    /// Share of the pass to take.
    share: f64,
    /// Step, s.
    dt: f64,
}

impl<const D: usize> FractureFlowStep<D> {
    pub(super) fn evaluate(
        &mut self,
        model: &Model<D>,
        state: &State,
    ) -> Result<Trial<D>, StepError> {
        let response = model
            .response(&state.view())
            .ok_or(StepError::Missing { part: "[damage]" })?;
        self.searches += 1;
        force_residual(model, state, response)
    }

    /// Whether so much has broken since `old` that the step will be rejected: a crack that runs takes many
    /// passes, which are better spent on the step that keeps it.
    pub(super) fn runs(
        &self,
        model: &Model<D>,
        old: &State,
        at: &Trial<D>,
    ) -> Result<bool, StepError> {
        let before = damage_of(solid_of(model)?)?.of(&old.history);
        let pairs = at.response.damage.iter().zip(&before);
        let growth = pairs.map(|(now, before)| now - before).fold(0.0, f64::max);
        Ok(growth > HOPELESS * self.plan.largest_increment)
    }

    /// Goes on from a pass that led from `start` to the state; false if it stays there. The coefficients
    /// of flow lag behind, so near the end passes contract linearly, and the energy says nothing of it.
    fn accelerate(
        &mut self,
        start: Vec<f64>,
        state: &mut State,
        length: f64,
        (imbalance, share): (f64, f64),
    ) -> bool {
        // A shortened or stretched pass is no pass of the same map.
        if imbalance > NEAR || (length - 1.0).abs() > 0.0 {
            self.acceleration.forget();
            if share >= 1.0 {
                return false;
            }
            let pairs = start.iter().zip(self.unknowns(state));
            let part: Vec<f64> = pairs.map(|(s, e)| s + share * (e - s)).collect();
            self.set_unknowns(&part, state);
            return true;
        }
        let end = self.unknowns(state);
        let next = self.acceleration.next(start, &end);
        let goes_on = next.is_some();
        if let Some(next) = next {
            self.set_unknowns(&next, state);
        }
        goes_on
    }

    /// What passes move: the displacement, and the pressure where that is no function of it, in units
    /// that make both count alike.
    pub(super) fn unknowns(&self, state: &State) -> Vec<f64> {
        let pressure = state.pressure.iter().map(|p| self.unit * p);
        let pressure = pressure.take(if self.splits() { usize::MAX } else { 0 });
        state.displacement.iter().copied().chain(pressure).collect()
    }

    pub(super) fn set_unknowns(&self, unknowns: &[f64], state: &mut State) {
        let (displacement, pressure) = unknowns.split_at(state.displacement.len());
        state.displacement.copy_from_slice(displacement);
        let pairs = state.pressure.iter_mut().zip(pressure);
        pairs.for_each(|(p, own)| *p = own / self.unit);
    }

    /// Passes until forces balance; gives the model with the coefficients that belong to the state.
    pub(super) fn solve(
        &mut self,
        model: &Model<D>,
        start: &StepStart<'_>,
        state: &mut State,
        report: &mut StepReport,
    ) -> Result<Model<D>, StepError> {
        let mut now = model.clone();
        match self.together {
            true => self.converge_coupled(&mut now, start, state, report)?,
            false => self.converge(&mut now, start, state, report)?,
        }
        Ok(now)
    }

    /// Passes until forces balance at the coefficients that the model has then, from those of the step's start.
    fn converge(
        &mut self,
        model: &mut Model<D>,
        start: &StepStart<'_>,
        state: &mut State,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let (old, dt) = (start.state, start.dt);
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        let mut found = self.evaluate(model, state)?;
        let mut watch = PassMonitor::new(found.response.damage.iter().sum());
        self.acceleration.forget();
        self.forcing = (10.0 * self.forcing).min(FORCING);
        for pass in 0..=self.plan.iterations {
            let fields = (&state.displacement[..], &state.walls[..]);
            let spreading = match pass {
                0 => Spreading::Anew,
                _ => Spreading::Further,
            };
            model.follow_fractures(&found.response, fields, spreading);
            if pass == 0 {
                report.iterations += self.follow_compliance(model, old, state)?;
            }
            let from = self.unknowns(state);
            let (iterations, splitting_residual) =
                self.balance(model, start, state, &found.response)?;
            report.iterations += iterations;
            // The displacement stands still, so the response is the same unless fluid acts in cracks.
            let at = match model.has_crack_content() {
                true => self.evaluate(model, state)?,
                false => force_residual(model, state, found.response)?,
            };
            let imbalance = self.imbalance(&at, state.time)?;
            report.passes = pass;
            report.residual = Some(imbalance);
            if imbalance <= self.plan.tolerance && splitting_residual <= watch.allowed() {
                self.largest = self.largest.max(at.scale);
                return Ok(());
            }
            if dt > self.cut_above && self.runs(model, old, &at)? {
                return Err(StepError::Runs {
                    time: state.time,
                    most: self.plan.largest_increment,
                });
            }
            watch.best = watch.best.min(imbalance);
            if imbalance <= self.plan.tolerance {
                watch.splitting_residual = watch.splitting_residual.min(splitting_residual);
            }
            let off = (imbalance / self.plan.tolerance).max(splitting_residual / OWED);
            let broken = at.response.damage.iter().sum();
            if !watch.continues(off, broken, self.splits()) || pass == self.plan.iterations {
                break;
            }
            self.react(&mut watch, imbalance);
            let pass = Pass {
                start: from,
                imbalance,
                share: watch.share,
                dt,
            };
            match self.pass(model, state, at, pass, report)? {
                Some(next) => found = next,
                None => break,
            }
        }
        Err(watch.failure(state.time, self.plan.tolerance, self.passes as usize))
    }

    /// One pass of the displacement from a place whose pressure is brought to it; `None` if it leads
    /// nowhere.
    fn pass(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        at: Trial<D>,
        from: Pass,
        report: &mut StepReport,
    ) -> Result<Option<Trial<D>>, StepError> {
        let Pass {
            start,
            imbalance,
            share,
            dt,
        } = from;
        let how = (imbalance, share);
        // Forces that are balanced to the last bits give no direction: the pressure alone moves on.
        if imbalance <= BALANCED * self.plan.tolerance {
            return Ok(Some(match self.accelerate(start, state, 1.0, how) {
                true => self.evaluate(model, state)?,
                false => at,
            }));
        }
        let (way, tried) = self.direction(model, state, &at, dt, imbalance, report)?;
        self.passes += 1;
        let reached = self.search(model, state, &at, &way)?;
        let length = reached.as_ref().map(|reached| reached.length);
        self.policy.judge(tried, length);
        let Some(reached) = reached else {
            // The exact tangent may have led astray; the others always lead down.
            let goes_on = tried == TangentKind::Consistent
                || self.keep_what_broke(model, state, &at, &way)?;
            return Ok(goes_on.then_some(at));
        };
        Ok(Some(
            match self.accelerate(start, state, reached.length, how) {
                true => self.evaluate(model, state)?,
                false => reached.found,
            },
        ))
    }

    /// Forces out of balance, relative to all forces.
    pub(super) fn imbalance(&self, at: &Trial<D>, time: f64) -> Result<f64, StepError> {
        let scale = at.scale.max(REMEMBERED * self.largest);
        let left: f64 = at.force.iter().map(|f| f.abs()).sum();
        match left.is_finite() {
            true => Ok(left / scale.max(f64::MIN_POSITIVE)),
            false => Err(not_finite::<D>(&at.force, time)),
        }
    }

    /// Learns from how the last pass went.
    fn react(&mut self, watch: &mut PassMonitor, imbalance: f64) {
        if imbalance > SLOW * watch.before {
            self.forcing = (0.1 * self.forcing).max(LEAST_FORCING);
        }
        if imbalance > WORSE * watch.before {
            self.acceleration.forget();
        }
        watch.before = imbalance;
    }
}

/// Share of the tolerance at which forces are as balanced as they get.
const BALANCED: f64 = 1e-3;

/// Forces out of balance of a response under the pressure of a state.
fn force_residual<const D: usize>(
    model: &Model<D>,
    state: &State,
    response: Response<D>,
) -> Result<Trial<D>, StepError> {
    let mut force = model.external_force(state.time, &state.pressure);
    let solid = solid_of(model)?;
    let scale = force.iter().map(|f| f.abs()).sum::<f64>()
        + model.crack_push(&response)
        + solid.in_situ_force;
    solid.subtract_internal_force(&response, &mut force);
    Ok(Trial {
        response,
        force,
        scale,
    })
}
