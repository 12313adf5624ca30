//! Forward Euler for the pressure (Eq. 62, with the same operator as the implicit schemes), alone or
//! with a solid that follows (Algorithm 3).
//!
//! With a solid the strain rate of the last step stands in for the one of this step, and the
//! fixed-stress term β V (Δp − Δp_last) makes up for the difference. Loads that vary meet an undrained body
//! first. β = 0 is the paper's form, which diverges where τ = α²/(s(λ+2μ)) > 1.
//!
//! More passes a step would lose less fluid, but rough pressures have no strain, and every pass takes a part
//! of the split's storage off them, on which explicit steps live: with up to twelve, Terzaghi's column at 0.25 m
//! was 4.5 % off after 20 s, with one 0.3 %.

use perifrac_solvers::norm2;

use super::implicit::{close_fixed, weighted_flows};
use super::memory::GrowthMonitor;
use super::quasi_static::growth;
use super::stage::{self, Stage, Target};
use super::start::ExplicitStart;
use super::{
    Memory, Scheme, SchemeCounters, Staggered, State, StepError, StepLimit, StepReport,
    diffusion_limit, flow_of,
};
use crate::model::{FlowModel, Model, exchange};
use crate::parallel;
use crate::plan::Plan;

/// Forward Euler.
pub struct ForwardEuler<const D: usize> {
    name: String,
    limit: StepLimit,
    products: u64,
    /// Rate q, kept while all loads are constant.
    rate: Vec<f64>,
    constant: bool,
    rate_time: Option<f64>,
    watch: GrowthMonitor,
    /// S per point, m^D/Pa; S + β V with a solid.
    storage: Vec<f64>,
    /// Passes between flow and the solid, if there is one.
    passes: Option<Staggered<D>>,
    start: Option<ExplicitStart>,
    /// Whether loads on the solid vary over time.
    loads_vary: bool,
}

/// Steps between two looks.
const INTERVAL: usize = 32;
/// Growth over the largest legitimate imbalance that counts as unstable: without a solid none is legitimate.
const UNSTABLE: f64 = 1.5;
/// The same with a solid, whose strain drives the pressure as well.
const UNSTABLE_COUPLED: f64 = 10.0;

impl<const D: usize> ForwardEuler<D> {
    /// Scheme with the stability limit of the flow alone.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without flow.
    pub fn new(model: &Model<D>) -> Result<Self, StepError> {
        let flow = flow_of(model)?;
        Ok(ForwardEuler {
            name: "explicit (forward-euler)".to_owned(),
            limit: diffusion_limit(flow, &flow.capacity),
            products: 0,
            rate: vec![0.0; flow.points()],
            constant: model.breakpoints().is_empty() && flow.is_constant(),
            rate_time: None,
            watch: GrowthMonitor::default(),
            storage: flow.capacity.clone(),
            passes: None,
            start: None,
            loads_vary: model
                .solid
                .as_ref()
                .is_some_and(|solid| !solid.breakpoints().is_empty()),
        })
    }

    /// Scheme with a solid that follows the pressure, named `solid`.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without flow.
    pub fn coupled(
        plan: &Plan,
        model: &Model<D>,
        passes: Staggered<D>,
        solid: &str,
    ) -> Result<Self, StepError> {
        let mut scheme = Self::new(model)?;
        scheme.storage = passes.storage().to_vec();
        scheme.limit = diffusion_limit(flow_of(model)?, &scheme.storage);
        scheme.name = format!("explicit (forward-euler, {solid})");
        scheme.passes = Some(passes);
        scheme.start = Some(ExplicitStart::new(plan, model));
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
        let beyond = dt > self.limit.dt * (1.0 + ROUNDING);
        // Beyond the limit, or with a solid, a few steps are enough to ruin everything: look at each.
        if !due && !beyond && self.passes.is_none() {
            return Ok(());
        }
        trial.check()?;
        // S (p₁ − p₀)/Δt is the imbalance; its S⁻¹ norm is that of √S (p₁ − p₀)/Δt.
        let change: Vec<f64> = (trial.pressure.iter().zip(&old.pressure).zip(&self.storage))
            .map(|((new, old), storage)| (new - old) * storage.sqrt() / dt)
            .collect();
        let size = norm2(&change);
        if self.watch.steps == 1 {
            self.watch.bound = size;
        }
        if !self.constant {
            self.watch.bound += self.driven(model, old, trial, dt)?;
        }
        // A body at rest has imbalances of rounding only, which may grow from one to the next.
        let rounding = NOISE * model.level * self.storage.iter().sum::<f64>().sqrt() / dt;
        let growth = size / self.watch.bound.max(rounding).max(f64::MIN_POSITIVE);
        match &self.passes {
            None if beyond && growth > UNSTABLE => Err(StepError::Unstable {
                time: trial.time,
                growth,
                dt,
                limit: self.limit.dt,
            }),
            Some(passes) if growth > UNSTABLE_COUPLED => {
                Err(passes.unstable(model, trial.time, growth)?)
            }
            _ => Ok(()),
        }
    }

    /// Imbalance that the change of the loads in a step may add, in the S⁻¹ norm.
    fn driven(
        &self,
        model: &Model<D>,
        old: &State,
        trial: &State,
        dt: f64,
    ) -> Result<f64, StepError> {
        let flow = flow_of(model)?;
        let [mut before, mut after] = [(); 2].map(|()| vec![0.0; flow.points()]);
        for (rate, time) in [(&mut before, old.time), (&mut after, trial.time)] {
            flow.rate(time, rate);
            let walls = flow.walls.iter();
            walls.for_each(|wall| wall.add_rate(time, &old.pressure, rate));
            flow.add_well_inflow(time, &old.pressure, rate);
        }
        let mut change: Vec<f64> = (after.iter().zip(&before).zip(&self.storage))
            .map(|((after, before), storage)| (after - before) / storage.sqrt())
            .collect();
        let loads = norm2(&change);
        // A prescribed point moves by itself, and L carries that on by 2/Δt_limit at most.
        change.fill(0.0);
        for fixed in &flow.fixed {
            let own = trial.pressure[fixed.point] - old.pressure[fixed.point];
            change[fixed.point] = own * self.storage[fixed.point].sqrt();
        }
        let fixed = norm2(&change) * (1.0 / dt + 2.0 / self.limit.dt);
        // Loads on the solid raise the pressure by less than themselves.
        let solid = match self.passes {
            Some(_) => model.level * self.storage.iter().sum::<f64>().sqrt() / dt,
            None => 0.0,
        };
        Ok((loads + fixed).max(solid - self.watch.bound))
    }
}

/// Whether loads on the solid, or walls that are moved, differ between two times.
fn loads_change<const D: usize>(model: &Model<D>, from: f64, to: f64) -> bool {
    let Some(solid) = &model.solid else {
        return false;
    };
    let at = |time: f64| {
        let mut loads = vec![0.0; solid.unknowns()];
        solid.loads(time, &mut loads);
        let mut walls = vec![0.0; solid.walls.len()];
        solid.place_walls(time, &mut walls);
        loads.extend(walls);
        loads.push(solid.drive(time));
        loads
    };
    let [before, after] = [from, to].map(at);
    let mut pairs = before.iter().zip(&after);
    pairs.any(|(before, after)| (after - before).abs() > ROUNDING * before.abs().max(after.abs()))
}

/// Change of the pressure that is rounding, relative to the pressures and stresses that balance each other.
const NOISE: f64 = 1e-12;

/// Step over the limit that counts as equal to it.
const ROUNDING: f64 = 1e-9;

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
    parallel::each(new, 1024, |row, new| {
        let imbalance = rate[row] - exchange(pattern, conductance, old, row);
        *new = old[row] + dt * imbalance / storage[row];
    });
    for wall in &flow.walls {
        wall.each_rate(time, old, |point, rate| {
            new[point] += dt * rate / storage[point]
        });
    }
    flow.wells
        .each_inflow((&flow.controls, time), old, |point, rate| {
            new[point] += dt * rate / storage[point];
        });
}

impl<const D: usize> ForwardEuler<D> {
    fn alone(
        &mut self,
        flow: &FlowModel<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> StepReport {
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
        let mut report = StepReport::default();
        report.flows.add(dt, &flow.flows(&old.pressure, old.time));
        for fixed in &flow.fixed {
            let free = trial.pressure[fixed.point];
            trial.pressure[fixed.point] = flow.fixed_loads[fixed.load].at(trial.time);
            let gain = (trial.pressure[fixed.point] - free) * self.storage[fixed.point];
            report.flows.hold(fixed.load, gain);
        }
        report
    }

    /// One step with passes between flow and the solid.
    fn together(
        &self,
        passes: &mut Staggered<D>,
        model: &Model<D>,
        old: &State,
        trial: &mut State,
        dt: f64,
    ) -> Result<StepReport, StepError> {
        let flow = flow_of(model)?;
        let mut report = StepReport::default();
        let mut imbalance = vec![0.0; flow.points()];
        flow.imbalance(old.time, &old.pressure, &mut imbalance);
        let mut loaded = old.clone();
        loaded.time = old.time + dt;
        if self.loads_vary && loads_change(model, old.time, loaded.time) {
            // Loads meet an undrained body, whose strain is no matter of the step before.
            passes.undrain(model, &mut loaded)?;
        }
        let target = Target {
            base: &loaded,
            time: loaded.time,
            dt,
            slot: 0,
        };
        let moved = imbalance.iter().map(|rate| dt * rate).collect();
        let step = passes.solve(model, target, moved, &mut report)?;
        trial.set_sum(&loaded, 1.0, &step);
        report.flows = weighted_flows(flow, &[(dt, &old.pressure, old.time, &imbalance)]);
        close_fixed(model, flow, &mut report.flows, &trial.since(old));
        Ok(report)
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

    fn recall(&mut self, memory: &Memory) {
        self.watch = memory.watch;
        if let Some(passes) = &mut self.passes {
            Stage::recall(passes, memory);
        }
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        match (&mut self.passes, &mut self.start) {
            (Some(passes), Some(start)) if start.applies(model)? => {
                start.start(model, passes.solid(), state)?;
                Stage::remember(passes, &mut state.memory);
                Ok(())
            }
            (Some(passes), _) => stage::start(passes, model, state),
            (None, _) => Ok(()),
        }
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        self.recall(&old.memory);
        trial.time = old.time + dt;
        let report = match self.passes.take() {
            None => self.alone(flow_of(model)?, old, dt, trial),
            Some(mut passes) => {
                let outcome = self.together(&mut passes, model, old, trial, dt);
                self.passes = Some(passes);
                outcome?
            }
        };
        self.products += 1;
        self.check(model, old, trial, dt)?;
        trial.memory.watch = self.watch;
        if let Some(passes) = &self.passes {
            Stage::remember(passes, &mut trial.memory);
        }
        Ok(StepReport {
            growth: growth(model, old, trial),
            ..report
        })
    }

    fn counters(&self) -> SchemeCounters {
        let mut counters = self
            .passes
            .as_ref()
            .map_or_else(SchemeCounters::default, Stage::counters);
        counters.products += self.products;
        if let Some(start) = &self.start {
            counters.add(start.counters());
        }
        counters
    }
}
