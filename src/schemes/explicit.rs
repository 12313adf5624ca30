//! Forward Euler for the pressure (Eq. 62, with the same operator as the implicit schemes), alone or
//! with a solid that follows (Algorithm 3).
//!
//! With a solid the strain rate of the last step stands in for the one of this step, and the
//! fixed-stress term β V (Δp − Δp_last) makes up for the difference. β = 0 is the paper's form, which
//! diverges where τ = α²/(s(λ+2μ)) > 1.

use perifrac_solvers::norm2;
use rayon::prelude::*;

use super::quasi_static::growth;
use super::solid::SolidSolver;
use super::undrained::undrained;
use super::{
    Scheme, SchemeCounters, State, StepError, StepLimit, StepReport, diffusion_limit, flow_of,
};
use crate::model::{FlowModel, Model, exchange};
use crate::plan::SchemeOptions;

/// Forward Euler.
pub struct ForwardEuler<const D: usize> {
    name: String,
    limit: StepLimit,
    products: u64,
    /// Rate q, kept while all loads are constant.
    rate: Vec<f64>,
    constant: bool,
    rate_time: Option<f64>,
    watch: Watch,
    /// S, or S + β V, per point, m^D/Pa.
    storage: Vec<f64>,
    follower: Option<Follower<D>>,
}

/// The solid that follows the pressure, and what it did in the last step.
struct Follower<const D: usize> {
    solid: Box<dyn SolidSolver<D>>,
    /// β V per point, m^D/Pa.
    split: Vec<f64>,
    last: Option<Lag>,
    options: SchemeOptions,
}

/// Pressure change and strain content of a step of `dt` seconds.
struct Lag {
    dt: f64,
    pressure: Vec<f64>,
    content: Vec<f64>,
}

/// Watches the imbalance ‖q − L p‖ in the S⁻¹ norm. Stable steps never let it grow by more than the
/// loads change, so growth means instability, long before values overflow.
#[derive(Debug, Default)]
struct Watch {
    steps: usize,
    largest: f64,
}

/// Steps between two looks.
const INTERVAL: usize = 32;
/// Growth over the largest legitimate imbalance that counts as unstable.
const UNSTABLE: f64 = 10.0;

impl<const D: usize> ForwardEuler<D> {
    /// Scheme with the stability limit of the flow alone.
    ///
    /// # Errors
    /// [`StepError::Missing`] without flow.
    pub fn new(model: &Model<D>) -> Result<Self, StepError> {
        let flow = flow_of(model)?;
        Ok(ForwardEuler {
            name: "explicit (forward-euler)".to_owned(),
            limit: diffusion_limit(flow, &flow.capacity),
            products: 0,
            rate: vec![0.0; flow.points()],
            constant: model.breakpoints().is_empty() && flow.is_constant(),
            rate_time: None,
            watch: Watch::default(),
            storage: flow.capacity.clone(),
            follower: None,
        })
    }

    /// Scheme with a solid that follows the pressure.
    ///
    /// # Errors
    /// [`StepError::Missing`] without flow or coupling.
    pub fn coupled(
        model: &Model<D>,
        solid: Box<dyn SolidSolver<D>>,
        options: &SchemeOptions,
    ) -> Result<Self, StepError> {
        let mut scheme = Self::new(model)?;
        let coupling = super::coupling_of(model)?;
        let (split, storage) = coupling.split(options.relaxation, &scheme.storage);
        scheme.storage = storage;
        scheme.limit = diffusion_limit(flow_of(model)?, &scheme.storage);
        scheme.name = format!("explicit (forward-euler, {})", solid.name());
        scheme.follower = Some(Follower {
            solid,
            split,
            options: *options,
            last: None,
        });
        Ok(scheme)
    }

    fn update_rate(&mut self, flow: &FlowModel<D>, time: f64) {
        if self.rate_time.is_none() || !self.constant {
            flow.rate(time, &mut self.rate);
            self.rate_time = Some(time);
        }
    }

    fn check(
        &mut self,
        model: &Model<D>,
        old: &State,
        trial: &State,
        dt: f64,
    ) -> Result<(), StepError> {
        self.watch.steps += 1;
        let due = self.watch.steps == 1 || self.watch.steps.is_multiple_of(INTERVAL);
        // Beyond the limit, or with a solid, a few steps are enough to ruin everything: look at each.
        if !due && dt <= self.limit.dt && self.follower.is_none() {
            return Ok(());
        }
        trial.check()?;
        // S (p₁ − p₀)/Δt is the imbalance; its S⁻¹ norm is that of √S (p₁ − p₀)/Δt.
        let change: Vec<f64> = (trial.pressure.iter().zip(&old.pressure).zip(&self.storage))
            .map(|((new, old), storage)| (new - old) * storage.sqrt() / dt)
            .collect();
        let size = norm2(&change);
        if self.watch.steps == 1 || !self.constant {
            self.watch.largest = self.watch.largest.max(size);
        }
        // Varying loads raise the imbalance by themselves; only growth beyond reason counts there.
        let reference = if self.constant { UNSTABLE } else { 1e6 } * self.watch.largest;
        if size <= reference {
            return Ok(());
        }
        let growth = size / self.watch.largest;
        if let Some(follower) = &self.follower {
            let (flow, coupling) = (flow_of(model)?, super::coupling_of(model)?);
            return Err(StepError::CouplingUnstable {
                time: trial.time,
                growth,
                relaxation: follower.options.relaxation,
                strength: coupling.strength(&flow.capacity),
            });
        }
        if dt > self.limit.dt {
            return Err(StepError::Unstable {
                time: trial.time,
                growth,
                dt,
                limit: self.limit.dt,
            });
        }
        Ok(())
    }
}

/// p₁ = p₀ + Δt S⁻¹ (q − L p₀) in one pass over the matrix.
fn advance<const D: usize>(
    flow: &FlowModel<D>,
    storage: &[f64],
    rate: &[f64],
    (time, dt): (f64, f64),
    old: &[f64],
    new: &mut [f64],
) {
    let (pattern, conductance) = (&flow.pattern, &flow.conductance);
    new.par_iter_mut()
        .enumerate()
        .with_min_len(1024)
        .for_each(|(row, new)| {
            let imbalance = rate[row] - exchange(pattern, conductance, old, row);
            *new = old[row] + dt * imbalance / storage[row];
        });
    for wall in &flow.walls {
        wall.each_rate(time, old, |point, rate| {
            new[point] += dt * rate / storage[point]
        });
    }
}

impl<const D: usize> Follower<D> {
    /// Adds to `pressure` what the strain of the last step would do now.
    fn predict(&self, storage: &[f64], dt: f64, pressure: &mut [f64]) {
        let Some(last) = &self.last else { return };
        let share = dt / last.dt;
        for (i, p) in pressure.iter_mut().enumerate() {
            let strain = self.split[i] * last.pressure[i] - last.content[i];
            *p += share * strain / storage[i];
        }
    }

    /// Lets the solid follow; keeps what the step did for the next one.
    fn follow(
        &mut self,
        model: &Model<D>,
        old: &State,
        trial: &mut State,
        dt: f64,
    ) -> Result<usize, StepError> {
        trial.displacement.copy_from_slice(&old.displacement);
        trial.walls.copy_from_slice(&old.walls);
        let iterations = self.solid.equilibrate(model, trial)?;
        let step = trial.since(old);
        let content = model.content(&step.displacement, &step.walls);
        self.last = Some(Lag {
            dt,
            content,
            pressure: step.pressure,
        });
        Ok(iterations)
    }
}

impl<const D: usize> Scheme<D> for ForwardEuler<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn local_order(&self) -> f64 {
        2.0
    }

    fn limit(&self) -> Option<&StepLimit> {
        Some(&self.limit)
    }

    fn start(&mut self, model: &mut Model<D>, state: &mut State) -> Result<(), StepError> {
        let model = &*model;
        let wanted = model
            .coupling
            .as_ref()
            .is_some_and(|coupling| coupling.undrained_start);
        match &mut self.follower {
            Some(follower) if wanted => {
                undrained(model, &mut *follower.solid, &follower.options, state)
            }
            _ => Ok(()),
        }
    }

    fn step(
        &mut self,
        model: &mut Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let model = &*model;
        let flow = flow_of(model)?;
        self.update_rate(flow, old.time);
        let span = (old.time, dt);
        advance(
            flow,
            &self.storage,
            &self.rate,
            span,
            &old.pressure,
            &mut trial.pressure,
        );
        self.products += 1;
        trial.time = old.time + dt;
        if let Some(follower) = &self.follower {
            follower.predict(&self.storage, dt, &mut trial.pressure);
        }
        let mut flows = crate::report::Flows::default();
        flows.add(dt, &flow.flows(&old.pressure, old.time));
        for fixed in &flow.fixed {
            let free = trial.pressure[fixed.point];
            trial.pressure[fixed.point] = flow.fixed_loads[fixed.load].at(trial.time);
            let gain = (trial.pressure[fixed.point] - free) * self.storage[fixed.point];
            flows.hold(fixed.load, gain);
        }
        let mut iterations = 0;
        if let Some(follower) = &mut self.follower {
            iterations = follower.follow(model, old, trial, dt)?;
        }
        self.check(model, old, trial, dt)?;
        Ok(StepReport {
            growth: growth(model, old, trial),
            stored: None,
            iterations,
            error: None,
            flows,
        })
    }

    fn counters(&self) -> SchemeCounters {
        let mut counters = self
            .follower
            .as_ref()
            .map_or_else(SchemeCounters::default, |f| f.solid.counters());
        counters.products += self.products;
        counters
    }
}
