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
mod direction;
mod passes;
mod stored;

use perifrac_solvers::{
    Coordinates, Demand, LinearSolver, NearNullspace, PRECONDITIONERS, PreconditionerInfo, Problem,
    SolverSpec, Symmetry,
};

use super::Fracture;
use super::acceleration::AndersonAcceleration;
use super::block::FractureBlock;
use super::compliance::Compliance;
use super::reuse::PreconditionerReuse;
use super::tangent_policy::TangentPolicy;
use super::tangents::TangentMatrix;
use crate::model::{Model, Spreading};
use crate::operators::Response;
use crate::plan::{DamagePlan, Plan, SchemeChoice, StepRule};
use crate::schemes::memory::Rates;
use crate::schemes::quasi_static::{advance, growth};
use crate::schemes::solid::{Chosen, build_solver, ratio, volume_stiffness};
use crate::schemes::{
    ImplicitSystem, Memory, Scheme, SchemeCounters, SolidSolver, State, StepError, StepReport,
    coupling_of, flow_of, solid_of,
};
pub use stored::{StepStart, close, fill_broken};

use passes::{FORCING, RETURNS, SHALLOW};

/// Flow and fracture together.
pub struct FractureFlowStep<const D: usize> {
    solver: Box<dyn LinearSolver>,
    chosen: Chosen,
    /// The matrix of both fields; `None` where they take turns.
    block: Option<FractureBlock>,
    is_fixed: Vec<bool>,
    flow: ImplicitSystem,
    tangent: TangentMatrix<D>,
    plan: DamagePlan,
    name: String,
    /// Largest forces so far, N.
    largest: f64,
    /// Residual of the linear systems: smaller where passes turn out to suffer from it.
    forcing: f64,
    reuse: PreconditionerReuse,
    acceleration: AndersonAcceleration,
    policy: TangentPolicy,
    /// Step above which one that breaks too much may be cut, s; infinite for fixed steps.
    cut_above: f64,
    /// Whether passes move pressure and displacement together, and do not bring the one to the other.
    together: bool,
    /// How far the pressure of cracks may reach in the next pass.
    spreading: Spreading,
    /// What fractures yield, where fields take turns.
    compliance: Compliance,
    /// Factor of that.
    relaxation: f64,
    /// Solver of the solid that measures it.
    demand: Demand,
    /// Unit of the pressure beside the displacement, m/Pa.
    unit: f64,
    passes: u64,
    searches: u64,
    products: u64,
}

/// Pressure and displacement with what they leave out of balance.
struct Trial<const D: usize> {
    response: Response<D>,
    /// Forces out of balance, N.
    force: Vec<f64>,
    /// Σ of the absolute forces, N.
    scale: f64,
}

impl<const D: usize> FractureFlowStep<D> {
    /// Chooses and analyses the solvers once.
    ///
    /// # Errors
    /// [`StepError`] if a solver is refused.
    pub fn new(plan: &Plan, damage: DamagePlan, model: &Model<D>) -> Result<Self, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        let together = !matches!(plan.scheme, SchemeChoice::Staggered(_));
        let block = together
            .then(|| FractureBlock::new(flow, solid, coupling))
            .transpose()?;
        let coordinates = model.cloud.flat_positions();
        let scale = block.as_ref().map_or(1.0, |block| block.layout.scale);
        let schur: Vec<f64> = coupling
            .fixed_stress
            .iter()
            .map(|b| scale * scale * b)
            .collect();
        let plain = match &block {
            Some(block) => Problem {
                schur_diagonal: Some(&schur),
                ..Problem::new(block.matrix.view(), Symmetry::QuasiDefinite, D + 1)
            },
            None => Problem::new(solid.matrix(), Symmetry::PositiveDefinite, D),
        };
        let demand = plan.fracture_demand();
        let problem = Problem {
            solves: demand.solves,
            lags: block.is_some(),
            contrast: ratio(flow.mobility.iter().copied()).max(plan.expected_contrast()),
            volume_stiffness: volume_stiffness(solid),
            coordinates: Some(Coordinates {
                dimension: D,
                values: &coordinates,
            }),
            near_nullspace: NearNullspace::RigidModes,
            ..plain
        };
        let (solver, chosen) = build_solver(&demand.spec, &problem, &model.timers)?;
        let part = perifrac_solvers::Demand {
            spec: part_of(&demand.spec)?,
            ..demand
        };
        Ok(FractureFlowStep {
            solver,
            chosen,
            is_fixed: flow.fixed_mask(),
            name: match together {
                true => "monolithic (backward-euler, damage)".to_owned(),
                false => "staggered (backward-euler, damage)".to_owned(),
            },
            block,
            flow: ImplicitSystem::new(&part, flow)?,
            tangent: TangentMatrix::new(solid),
            plan: damage,
            largest: 0.0,
            forcing: FORCING,
            reuse: PreconditionerReuse::default(),
            acceleration: AndersonAcceleration::new(SHALLOW),
            policy: TangentPolicy::new(damage.method),
            cut_above: match plan.time.step {
                StepRule::Fixed(_) => f64::INFINITY,
                StepRule::Adaptive => damage.shortest_step,
            },
            together: together && model.has_crack_content(),
            spreading: Spreading::Anew,
            compliance: Compliance::default(),
            relaxation: plan.scheme_options.relaxation,
            demand: part,
            unit: 1.0,
            passes: 0,
            searches: 0,
            products: 0,
        })
    }
}

impl<const D: usize> FractureFlowStep<D> {
    /// Brings the solid into equilibrium with the pressure of the start, and the coefficients of flow to it, until
    /// fluid acts in cracks where it did when forces balanced.
    fn start_drained(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        let mut now = model.clone();
        for _ in 0..=RETURNS {
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
        let response = now
            .response(&state.view())
            .ok_or(StepError::Missing { part: "[damage]" })?;
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
        memory.forcing = Some(self.forcing);
        memory.tangent_rest = self.policy.rest;
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
    Err(StepError::Emptied {
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
        self.forcing = memory.forcing.unwrap_or(FORCING);
        self.policy.rest = memory.tangent_rest;
        self.unit = memory.unit.unwrap_or(1.0);
        self.compliance.measured = memory.compliance;
        // Tangents and preconditioners lag behind within a step only.
        self.tangent.forget();
        self.reuse.forget();
        self.solver.begin_anew();
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
            solver: self.solver.counters().clone(),
            coupling_iterations: self.passes,
            searches: self.searches,
            fallbacks: self.policy.failures,
            refilled_families: self.tangent.refilled,
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.chosen.clone())
    }
}
