//! Flow and mechanics in turn, with the fixed-stress split (Eq. 72 and docs/theory.md).
//!
//! The flow step adds β V (p − p_old) to both sides, which stands in for the strain that the new
//! pressure will cause. Without it (β = 0, the paper's form) the iteration diverges where
//! τ = α²/(s(λ+2μ)) > 1.

mod disagreement;

use super::accelerator::Accelerator;
use super::descent::Stagnation;
use super::memory::{Lag, Predictor};
use super::solid::SolidSolver;
use super::stage::{Stage, Target};
use super::start::ExplicitStart;
use super::undrained::undrained;
use super::{
    ImplicitSystem, Increment, Memory, SchemeCounters, State, StepError, StepReport, coupling_of,
    flow_of, solid_of,
};
use crate::model::{Coupling, FlowModel, Model};
use crate::plan::{Acceleration, SchemeOptions};

/// Stage that passes between flow and mechanics until they agree, starting from the strain rate of the
/// last step.
pub struct Staggered<const D: usize> {
    name: &'static str,
    flow: FlowPart,
    solid: Box<dyn SolidSolver<D>>,
    /// What finds the start, where the solid has no linear system.
    start: Option<ExplicitStart>,
    /// β V per point, m^D/Pa.
    split: Vec<f64>,
    /// S + β V per point, m^D/Pa.
    storage: Vec<f64>,
    options: SchemeOptions,
    /// Disagreement, relative to the terms of the mass balance, at which passes end.
    tolerance: f64,
    is_fixed: Vec<bool>,
    lags: Lags,
    coupling_iterations: u64,
    contraction: f64,
}

/// How a pass finds the pressure.
enum FlowPart {
    /// From one linear system.
    System(Box<ImplicitSystem>),
    /// Point by point: what flows is known from the base.
    Pointwise {
        /// Whether all steps pass once.
        once: bool,
    },
}

/// What the stages of a step found: the guess for the next one.
#[derive(Debug, Clone, Default)]
struct Lags {
    /// In the last step.
    before: [Option<Lag>; 2],
    /// In this one.
    now: [Option<Lag>; 2],
}

impl<const D: usize> Staggered<D> {
    /// Passes until flow and mechanics agree to `scheme.coupling_tolerance`.
    pub fn iterated(
        flow: ImplicitSystem,
        solid: Box<dyn SolidSolver<D>>,
        parts: (&FlowModel<D>, &Coupling),
        options: SchemeOptions,
    ) -> Self {
        Self::new(
            "staggered",
            FlowPart::System(Box::new(flow)),
            solid,
            parts,
            options,
            options.coupling_tolerance,
        )
    }

    /// Passes once a stage wherever the strain rate of the last step is a fair guess, as the
    /// semi-implicit scheme does.
    pub fn lagged(
        flow: ImplicitSystem,
        solid: Box<dyn SolidSolver<D>>,
        parts: (&FlowModel<D>, &Coupling),
        options: SchemeOptions,
    ) -> Self {
        let tolerance = match options.single_pass {
            true => f64::INFINITY,
            false => FAIR.max(options.coupling_tolerance),
        };
        let flow = FlowPart::System(Box::new(flow));
        Self::new("semi-implicit", flow, solid, parts, options, tolerance)
    }

    /// The same from a start that is found as the plan asks.
    #[must_use]
    pub(super) fn with_start(mut self, start: ExplicitStart) -> Self {
        self.start = Some(start);
        self
    }

    /// Without a linear system: what flows is that of the base. With `once` all steps pass once.
    pub fn pointwise(
        solid: Box<dyn SolidSolver<D>>,
        parts: (&FlowModel<D>, &Coupling),
        options: SchemeOptions,
        once: bool,
    ) -> Self {
        let tolerance = FAIR.max(options.coupling_tolerance);
        let flow = FlowPart::Pointwise { once };
        Self::new("explicit", flow, solid, parts, options, tolerance)
    }

    /// Brings `state` to the undrained response to the loads at its time.
    ///
    /// # Errors
    /// As `undrained`.
    pub fn undrain(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        undrained(model, &mut *self.solid, &self.options, state)
    }

    /// Replaces β V per point (m^D/Pa), which stands in for the strain of a pass to come, where the
    /// coefficients of flow follow the state.
    pub fn set_split(&mut self, flow: &FlowModel<D>, split: &[f64]) {
        self.split.clear();
        self.split.extend_from_slice(split);
        let pairs = flow.capacity.iter().zip(split);
        self.storage = pairs.map(|(s, b)| s + b).collect();
        if let FlowPart::System(system) = &mut self.flow {
            system.forget(flow);
        }
    }

    /// S + β V per point, m^D/Pa.
    pub fn storage(&self) -> &[f64] {
        &self.storage
    }

    /// What moves the solid.
    pub fn solid(&mut self) -> &mut dyn SolidSolver<D> {
        &mut *self.solid
    }

    fn new(
        name: &'static str,
        flow: FlowPart,
        solid: Box<dyn SolidSolver<D>>,
        (model, coupling): (&FlowModel<D>, &Coupling),
        options: SchemeOptions,
        tolerance: f64,
    ) -> Self {
        let (split, storage) = coupling.split(options.relaxation, &model.capacity);
        Staggered {
            name,
            flow,
            solid,
            start: None,
            storage,
            split,
            options,
            tolerance,
            is_fixed: model.fixed_mask(),
            lags: Lags::default(),
            coupling_iterations: 0,
            contraction: 0.0,
        }
    }

    /// One flow solve with the strain content and pressure change of the last pass.
    fn flow_pass(
        &mut self,
        model: &Model<D>,
        target: &Target<'_>,
        rhs: &[f64],
        guess: &Predictor,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        let flow = flow_of(model)?;
        let right: Vec<f64> = (0..rhs.len())
            .map(|i| rhs[i] - guess.content[i] + self.split[i] * guess.pressure[i])
            .collect();
        let mut pressure = match self.flow {
            FlowPart::System(_) => guess.pressure.clone(),
            FlowPart::Pointwise { .. } => right
                .iter()
                .zip(&self.storage)
                .map(|(r, s)| r / s)
                .collect(),
        };
        flow.fix(target.time, &target.base.pressure, &mut pressure);
        if let FlowPart::System(system) = &mut self.flow {
            report.iterations += system.solve(flow, &right, &mut pressure)?;
        }
        Ok(pressure)
    }

    /// Mechanical equilibrium at the base's pressure plus `change`; gives the strain content gained.
    fn solid_pass(
        &mut self,
        model: &Model<D>,
        target: &Target<'_>,
        change: &[f64],
        state: &mut State,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        state.time = target.time;
        let base = &target.base.pressure;
        state
            .pressure
            .iter_mut()
            .zip(base.iter().zip(change))
            .for_each(|(p, (b, c))| *p = b + c);
        // Steps that pass once pass on to the next what the solid has not followed yet.
        report.iterations += match self.passes_once(target.slot) {
            true => self.solid.follow(model, state, target.dt)?,
            false => self.solid.equilibrate(model, state)?,
        };
        let step = state.since(target.base);
        Ok(model.content(&step.displacement, &step.walls))
    }

    fn iterate(
        &mut self,
        model: &Model<D>,
        target: &Target<'_>,
        rhs: &[f64],
        report: &mut StepReport,
    ) -> Result<Increment, StepError> {
        let mut state = target.base.clone();
        let mut guess = match &self.lags.before[target.slot] {
            Some(lag) => lag.scaled(target.dt),
            None => {
                let pressure = vec![0.0; rhs.len()];
                let content = self.solid_pass(model, target, &pressure, &mut state, report)?;
                Predictor { pressure, content }
            }
        };
        let base = model.content(&target.base.displacement, &target.base.walls);
        let held: f64 = base.iter().map(|c| c.abs()).sum();
        let rounding = ROUNDING * (held + model.level * self.storage.iter().sum::<f64>());
        let once = self.passes_once(target.slot);
        let mut accelerator = Accelerator::new(self.options.acceleration);
        let mut stagnation = Stagnation::new();
        let (mut first, mut last, mut relative) = (0.0, f64::INFINITY, f64::INFINITY);
        for pass in 1..=self.options.coupling_iterations {
            let pressure = self.flow_pass(model, target, rhs, &guess, report)?;
            let content = self.solid_pass(model, target, &pressure, &mut state, report)?;
            self.coupling_iterations += 1;
            let found = Predictor { pressure, content };
            let (left, scale) = self.disagreement(target, rhs, (&guess, &found));
            let scale = scale + rounding;
            if pass == 1 {
                first = left;
            } else if pass == 2 && last > 0.0 && self.options.acceleration == Acceleration::None {
                self.contraction = self.contraction.max(left / last);
            }
            report.passes += 1;
            report.residual = Some(left / scale.max(f64::MIN_POSITIVE));
            let stuck = stagnation.note(left);
            if once {
                report.unsettled = Some(self.unsettled(model, target.dt, (&guess, &found))?);
            }
            if left <= self.allowed(stuck) * scale || once && left.is_finite() {
                self.lags.now[target.slot] = Some(Lag {
                    dt: target.dt,
                    found,
                });
                return Ok(state.since(target.base));
            }
            if left.is_nan() || left > GROWTH * first.max(scale) || stuck >= GIVEN_UP {
                return self.diverged(model, target.time, pass, [left / scale; 2]);
            }
            (last, relative) = (left, left / scale);
            guess = accelerator.next(guess, found, &self.storage);
        }
        let passes = self.options.coupling_iterations;
        self.diverged(model, target.time, passes, [relative; 2])
    }

    /// Disagreement over its scale that is allowed after so many passes without progress: relaxation may leave
    /// more than what passes are to agree to, and then more of them change nothing.
    fn allowed(&self, stuck: usize) -> f64 {
        match self.tolerance >= FAIR && stuck >= PATIENCE {
            true => self.tolerance.max(STALLED),
            false => self.tolerance,
        }
    }

    /// Whether the form of the paper is asked for, in which strain lags behind by a step.
    fn is_paper(&self) -> bool {
        matches!(self.flow, FlowPart::Pointwise { .. }) && self.options.relaxation <= 0.0
    }

    /// Whether one pass must do. The first step in the form of the paper has nothing that lags and passes until
    /// fields agree or are seen to diverge.
    fn passes_once(&self, slot: usize) -> bool {
        match self.flow {
            _ if self.is_paper() => self.lags.before[slot].is_some(),
            FlowPart::Pointwise { once } => once,
            FlowPart::System(_) => false,
        }
    }

    fn diverged(
        &self,
        model: &Model<D>,
        time: f64,
        passes: usize,
        [residual, growth]: [f64; 2],
    ) -> Result<Increment, StepError> {
        if self.is_paper() {
            return Err(self.unstable(model, time, growth)?);
        }
        let (flow, coupling) = (flow_of(model)?, coupling_of(model)?);
        Err(StepError::CouplingDiverged {
            time,
            passes,
            residual,
            relaxation: self.options.relaxation,
            strength: coupling.strength(&flow.capacity),
        })
    }

    /// The error for pressures that lagging strain amplifies.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without flow or coupling.
    pub fn unstable(
        &self,
        model: &Model<D>,
        time: f64,
        growth: f64,
    ) -> Result<StepError, StepError> {
        Ok(StepError::CouplingUnstable {
            time,
            growth,
            relaxation: self.options.relaxation,
            strength: coupling_of(model)?.strength(&flow_of(model)?.capacity),
        })
    }
}

/// Disagreement, relative to the terms of the mass balance, that makes a lagged strain a fair guess.
const FAIR: f64 = 1e-3;
/// The same once passes make no progress any more: the audit of the step has the last word.
const STALLED: f64 = 1e-2;
/// Passes without progress after which that holds, and after which passes are given up.
const PATIENCE: usize = 4;
const GIVEN_UP: usize = 30;
/// Share of the strain there is already that counts in the scale of disagreements: steps may be so small that their own
/// changes drown in rounding errors.
const ROUNDING: f64 = 1e-5;
/// Growth of the disagreement over all passes that counts as divergence.
const GROWTH: f64 = 1e6;

impl<const D: usize> Stage<D> for Staggered<D> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn prepare(&mut self, model: &Model<D>, a: f64) -> Result<(), StepError> {
        solid_of(model)?;
        match &mut self.flow {
            FlowPart::System(system) => {
                Ok(system.prepare(flow_of(model)?, &self.storage, a, &[])?)
            }
            FlowPart::Pointwise { .. } => Ok(()),
        }
    }

    fn solve(
        &mut self,
        model: &Model<D>,
        target: Target<'_>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Increment, StepError> {
        self.iterate(model, &target, &rhs, report)
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        if flow_of(model)?.stabilisation.is_empty() {
            return match &mut self.start {
                Some(start) => start.start(model, &mut *self.solid, state),
                None => undrained(model, &mut *self.solid, &self.options, state),
            };
        }
        // The stabilising storage couples the points: one stage in which nothing flows.
        Stage::<D>::prepare(self, model, 0.0)?;
        let base = state.clone();
        let (time, dt, slot) = (state.time, 0.0, 0);
        let target = Target {
            base: &base,
            time,
            dt,
            slot,
        };
        let still = vec![0.0; state.pressure.len()];
        let step = self.iterate(model, &target, &still, &mut StepReport::default())?;
        state.set_sum(&base, 1.0, &step);
        // A stage without a length is no guess for one that has a length.
        self.lags.now = [None, None];
        Ok(())
    }

    fn equilibrate(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        self.solid.equilibrate(model, state).map(drop)
    }

    fn recall(&mut self, memory: &Memory) {
        self.lags.before.clone_from(&memory.lags);
        self.lags.now = [None, None];
        self.solid.recall(memory);
        if let FlowPart::System(system) = &mut self.flow {
            system.recall(memory);
        }
    }

    fn remember(&self, memory: &mut Memory) {
        memory.lags.clone_from(&self.lags.now);
        self.solid.remember(memory);
        if let FlowPart::System(system) = &self.flow {
            system.remember(memory);
        }
    }

    /// The flow matrix of the split alone: its storage is close to the undrained one.
    fn filter(
        &mut self,
        model: &Model<D>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        match &mut self.flow {
            FlowPart::System(system) => Ok(system.filter(flow_of(model)?, &rhs, report)?),
            FlowPart::Pointwise { .. } => {
                let pairs = rhs.iter().zip(&self.storage);
                Ok(pairs.map(|(r, s)| r / s).collect())
            }
        }
    }

    fn counters(&self) -> SchemeCounters {
        let mut counters = self.solid.counters();
        if let Some(start) = &self.start {
            counters.add(start.counters());
        }
        if let FlowPart::System(system) = &self.flow {
            counters.solver = system.counters().clone();
        }
        counters.coupling_iterations = self.coupling_iterations;
        counters.contraction = (self.contraction > 0.0).then_some(self.contraction);
        counters
    }

    fn solver(&self) -> Option<(String, String)> {
        let FlowPart::System(system) = &self.flow else {
            return self.solid.solver();
        };
        let (flow, reason) = system.chosen().clone();
        Some(match self.solid.solver() {
            Some((solid, _)) if solid != flow => (format!("{flow} + {solid}"), reason),
            _ => (flow, reason),
        })
    }
}
