//! Backward Euler steps in which rock breaks, fluid flows in what is broken, and both are solved
//! together or in turns.
//!
//! For the coefficients of flow as they are the pressure is eliminated exactly: with
//! M = S + Δt L and M p = b − Q(u − u₀) the displacement minimises
//!
//!   E(u) − f·u + ½ pᵀ M p,
//!
//! whose derivative is the force out of balance at that pressure. Every pass brings coefficients and
//! pressure to the displacement, and walks down this potential along the solution of the coupled
//! linear system. It ends when forces balance at coefficients and pressure that belong to the
//! displacement itself, so the residual covers damage, opening, permeability and mass alike. In turns
//! the pressure stands still while the displacement moves. That is enough where it hardly depends on the
//! displacement, as in a crack of prescribed pressure; elsewhere its step carries the compliance of the
//! fractures, and the residual covers what it owes to the strain.

mod balance;
mod coupled;
mod eliminated;
mod stored;
mod system;

use perifrac_solvers::{Demand, PRECONDITIONERS, PreconditionerInfo, SolverSpec, Symmetry};

use super::Fracture;
use super::compliance::Compliance;
use crate::model::{Model, Spreading};
use crate::plan::{DamagePlan, Plan, SchemeChoice, StepRule};
use crate::schemes::descent::{
    AndersonAcceleration, Descent, Trial, converge, damage_of, response_to,
};
use crate::schemes::memory::Rates;
use crate::schemes::quasi_static::{advance, growth};
use crate::schemes::{
    ImplicitSystem, Memory, Scheme, SchemeCounters, SolidSolver, State, StepError, StepReport,
    coupling_of, flow_of, solid_of,
};
pub(crate) use stored::{StepStart, close, fill_broken};

use coupled::CoupledPasses;
use eliminated::EliminatedPasses;
use system::FractureSystem;

/// Flow and fracture together.
pub struct FractureFlowStep<const D: usize> {
    system: FractureSystem<D>,
    flow: ImplicitSystem,
    plan: DamagePlan,
    name: String,
    descent: Descent,
    acceleration: AndersonAcceleration,
    /// Largest forces of accepted states, N.
    largest: f64,
    /// Step above which one that breaks too much may be cut, s; infinite for fixed steps.
    cut_above: f64,
    /// Whether passes move pressure and displacement together, and do not bring the one to the other.
    together: bool,
    /// What fractures yield, where fields take turns.
    compliance: Compliance,
    /// Factor of that.
    relaxation: f64,
    /// Solver of the solid that measures it.
    demand: Demand,
    /// Unit of the pressure beside the displacement, m/Pa.
    unit: f64,
    passes: u64,
    products: u64,
}

impl<const D: usize> FractureFlowStep<D> {
    /// Chooses and analyses the solvers once.
    ///
    /// # Errors
    /// [`StepError`] if a solver is refused.
    pub fn new(plan: &Plan, damage: DamagePlan, model: &Model<D>) -> Result<Self, StepError> {
        let together = !matches!(plan.scheme, SchemeChoice::Staggered(_));
        let demand = plan.fracture_demand();
        let system = FractureSystem::new(plan, &damage, model, (&demand, together))?;
        let part = Demand {
            spec: part_of(&demand.spec)?,
            ..demand
        };
        Ok(FractureFlowStep {
            system,
            name: match together {
                true => "monolithic (backward-euler, damage)".to_owned(),
                false => "staggered (backward-euler, damage)".to_owned(),
            },
            flow: ImplicitSystem::new(&part, flow_of(model)?)?,
            plan: damage,
            descent: Descent::new(&damage),
            acceleration: AndersonAcceleration::new(damage.descent),
            largest: 0.0,
            cut_above: match plan.time.step {
                StepRule::Fixed(_) => f64::INFINITY,
                StepRule::Adaptive => damage.shortest_step,
            },
            together: together && model.has_crack_content(),
            compliance: Compliance::default(),
            relaxation: plan.scheme_options.relaxation,
            demand: part,
            unit: 1.0,
            passes: 0,
            products: 0,
        })
    }
}

impl<const D: usize> FractureFlowStep<D> {
    /// Passes until forces balance; gives the model with the coefficients that belong to the state.
    fn solve(
        &mut self,
        model: &Model<D>,
        start: &StepStart<'_>,
        state: &mut State,
        report: &mut StepReport,
    ) -> Result<Model<D>, StepError> {
        let (mut now, plan) = (model.clone(), self.plan);
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        let before = self.system.linear.iterations;
        let scale = match self.together {
            true => {
                let mut passes = CoupledPasses::new(self, &mut now, start);
                converge(&mut passes, &plan, state, report)
            }
            false => {
                self.acceleration.forget();
                self.system.relax();
                let mut passes = EliminatedPasses::new(self, &mut now, start);
                let scale = converge(&mut passes, &plan, state, report);
                report.iterations += passes.iterations;
                scale
            }
        }?;
        report.iterations += self.system.linear.iterations - before;
        self.largest = self.largest.max(scale);
        Ok(now)
    }

    /// Forces that count as a scale, however small those of a state are, N.
    fn scale(&self) -> f64 {
        self.plan.descent.remembered_scale * self.largest
    }

    /// Refuses a step in which so much has broken that it will be rejected: a crack that runs takes many passes, which
    /// are better spent on the step that keeps it.
    fn check_run(
        &self,
        model: &Model<D>,
        start: &StepStart<'_>,
        state: &State,
        at: &Trial<D>,
    ) -> Result<(), StepError> {
        if start.dt <= self.cut_above {
            return Ok(());
        }
        let before = damage_of(solid_of(model)?)?.of(&start.state.history);
        let pairs = at.response.damage.iter().zip(&before);
        let growth = pairs.map(|(now, before)| now - before).fold(0.0, f64::max);
        let most = self.plan.largest_increment;
        match growth > self.plan.descent.growth_cutoff * most {
            true => Err(StepError::DamageGrowth {
                time: state.time,
                most,
            }),
            false => Ok(()),
        }
    }

    /// What passes move: the displacement, and the pressure where that is no function of it, in units
    /// that make both count alike.
    fn unknowns(&self, state: &State) -> Vec<f64> {
        let pressure = state.pressure.iter().map(|p| self.unit * p);
        let pressure = pressure.take(if self.splits() { usize::MAX } else { 0 });
        state.displacement.iter().copied().chain(pressure).collect()
    }

    fn set_unknowns(&self, unknowns: &[f64], state: &mut State) {
        let (displacement, pressure) = unknowns.split_at(state.displacement.len());
        state.displacement.copy_from_slice(displacement);
        let pairs = state.pressure.iter_mut().zip(pressure);
        pairs.for_each(|(p, own)| *p = own / self.unit);
    }
}

impl<const D: usize> FractureFlowStep<D> {
    /// Brings the solid into equilibrium with the pressure of the start, and the coefficients of flow to it, until
    /// fluid acts in cracks where it did when forces balanced.
    fn start_drained(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        let mut now = model.clone();
        for _ in 0..=self.plan.descent.start_rounds {
            Fracture::new(&self.demand, &now, self.plan)?.equilibrate(&now, state)?;
            advance(&now, state);
            if !Self::fill_start(&mut now, state)? {
                break;
            }
        }
        self.remember(&now, state);
        Ok(())
    }

    /// Gives what is broken at a start fluid of its own at the pressure of the pores; true if there was anything, or the pressure
    /// of a crack acts elsewhere.
    fn fill_start(now: &mut Model<D>, state: &mut State) -> Result<bool, StepError> {
        let response = response_to(now, state)?;
        let before = now.wet_points();
        let fields = (&state.displacement[..], &state.walls[..]);
        now.follow_fractures(&response, fields, Spreading::Anew);
        fill_broken(now, Some(&response), state, false);
        Ok(now.wet_points() != before)
    }

    /// Enters into a state the coefficients of the model that belongs to it, and what the next step needs.
    fn remember(&self, now: &Model<D>, state: &mut State) {
        state.coefficients = now.coefficients();
        let memory = &mut state.memory;
        memory.largest_force = self.largest;
        memory.forcing = Some(self.system.forcing);
        memory.tangent_rest = self.descent.policy.rest;
        memory.unit = Some(self.unit);
        memory.compliance = self.compliance.measured;
    }
}

/// Refuses fluid that is drawn out of empty points: a crack gives no more than it has.
fn check_drawn<const D: usize>(model: &Model<D>, state: &State, dt: f64) -> Result<(), StepError> {
    let Some((drawn, point)) = model.overdrawn(&state.pressure, state.time) else {
        return Ok(());
    };
    let moved = dt * flow_of(model)?.flows(&state.pressure, state.time).gross;
    Err(StepError::FluidExhausted {
        time: state.time,
        at: model.cloud.position[point].iter().copied().collect(),
        owed: dt * drawn / moved.max(f64::MIN_POSITIVE),
    })
}

/// Solver of flow alone: the one of the whole, unless its preconditioner is for both fields only.
fn part_of(spec: &SolverSpec) -> Result<SolverSpec, StepError> {
    let chosen = spec
        .options()
        .iter()
        .find(|(key, _)| key == "preconditioner");
    let info = PRECONDITIONERS
        .iter()
        .find(|info| chosen.is_some_and(|(_, name)| name == info.name));
    let suits = |info: &PreconditionerInfo| info.symmetries.contains(&Symmetry::PositiveDefinite);
    Ok(match info.is_none_or(suits) {
        true => spec.clone(),
        false => "auto".parse::<SolverSpec>()?,
    })
}

impl<const D: usize> Scheme<D> for FractureFlowStep<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn local_order(&self) -> f64 {
        2.0
    }

    fn recall(&mut self, memory: &Memory) {
        self.largest = memory.largest_force;
        let forcing = memory.forcing;
        self.system.forcing = forcing.unwrap_or(self.plan.descent.coupled_forcing);
        self.descent.policy.rest = memory.tangent_rest;
        self.unit = memory.unit.unwrap_or(1.0);
        self.compliance.measured = memory.compliance;
        self.system.linear.begin_anew();
        self.flow.begin_anew();
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        // At its pressure a crack that is taken over may run for ever; its fluid is what it has.
        if !coupling_of(model)?.undrained_start && !model.has_fluid_in_cracks() {
            return self.start_drained(model, state);
        }
        let mut model = model.clone();
        Self::fill_start(&mut model, state)?;
        let old = state.clone();
        let report = &mut StepReport::default();
        let start = StepStart::new(&model, &old, 0.0);
        let mut now = self.solve(&model, &start, state, report)?;
        let response = now.crack_response(&state.view());
        advance(&now, state);
        fill_broken(&mut now, response.as_ref(), state, true);
        self.remember(&now, state);
        Ok(())
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        self.recall(&old.memory);
        let mut report = StepReport::default();
        trial.clone_from(old);
        trial.time = old.time + dt;
        let rates = &old.memory.rates.displacement;
        for (u, rate) in trial.displacement.iter_mut().zip(rates) {
            *u += dt * rate;
        }
        let start = StepStart::new(model, old, dt);
        let mut now = self.solve(model, &start, trial, &mut report)?;
        trial.check()?;
        let response = now.crack_response(&trial.view());
        let response = response.as_ref();
        report.error = Rates::judge(&now, response, (old, trial), dt)?;
        close(&now, &start, (trial, response), (dt, trial), &mut report)?;
        check_drawn(&now, trial, dt)?;
        advance(&now, trial);
        report.growth = growth(&now, old, trial);
        fill_broken(&mut now, response, trial, true);
        self.remember(&now, trial);
        Ok(report)
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            products: self.products,
            solver: self.system.linear.counters(),
            coupling_iterations: self.passes,
            searches: self.descent.searches,
            fallbacks: self.descent.policy.failures,
            refilled_families: self.system.linear.tangent.refilled,
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.system.linear.chosen.clone())
    }
}
