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
//! the pressure stands still while the displacement moves, which is enough where the pressure hardly
//! depends on it, as in a crack of prescribed pressure.

use perifrac_solvers::{
    Coordinates, LinearSolver, NearNullspace, PRECONDITIONERS, PreconditionerInfo, Problem,
    SolverSpec, Symmetry, dot, multiply,
};

use super::acceleration::Acceleration;
use super::block::FractureBlock;
use super::daring::Daring;
use super::descent::{Reached, descend};
use super::tangents::TangentMatrix;
use super::upkeep::Upkeep;
use super::{damage_of, not_finite};
use crate::material::Softening;
use crate::model::Model;
use crate::operators::Answer;
use crate::plan::{DamagePlan, Plan, SchemeChoice, StepRule};
use crate::schemes::implicit::weigh;
use crate::schemes::quasi_static::{advance, growth};
use crate::schemes::solid::{Chosen, build_solver, ratio};
use crate::schemes::{
    ImplicitSystem, Scheme, SchemeCounters, State, StepError, StepReport, coupling_of, flow_of,
    solid_of,
};

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
    /// Velocity of the last trial and of the last accepted step, m/s: where the next one starts.
    rates: [Vec<f64>; 2],
    /// Residual of the linear systems: smaller where passes turn out to suffer from it.
    forcing: f64,
    upkeep: Upkeep,
    acceleration: Acceleration,
    daring: Daring,
    /// Step above which one that breaks too much may be cut, s; infinite for fixed steps.
    cut_above: f64,
    passes: u64,
    searches: u64,
    products: u64,
}

/// Residual of the coupled linear systems at first, and the smallest. A crack that is full answers to
/// a wrong volume with a pressure that is wrong by the ratio of its compliance to that of the fluid.
const FORCING: f64 = 1e-4;
const LEAST_FORCING: f64 = 1e-8;
/// The same of the displacement alone, relative to the forces out of balance.
const FORCING_ALONE: f64 = 1e-3;
const REMEMBERED: f64 = 1e-2;
/// Forces out of balance, relative to all, from which passes are taken to contract.
const NEAR: f64 = 3e-2;
/// Share of the imbalance before a pass that may be left by it before something is amiss.
const SLOW: f64 = 0.7;
/// Growth of the imbalance in a pass from which what earlier passes taught is forgotten.
const WORSE: f64 = 2.0;
/// Growth of damage over the one that is allowed from which a step is given up at once.
const HOPELESS: f64 = 2.5;
/// Change of the potential, relative to the energy, that is rounding error.
const ROUNDING: f64 = 1e-13;

/// Pressure and displacement with what they leave out of balance.
struct Trial<const D: usize> {
    answer: Answer<D>,
    /// Forces out of balance, N.
    force: Vec<f64>,
    /// Σ of the absolute forces, N.
    scale: f64,
}

/// A straight way from a balanced pressure to another.
struct Way {
    displacement: Vec<f64>,
    pressure: Vec<f64>,
    /// Slope and half the curvature of ½ pᵀMp along it.
    bend: [f64; 2],
}

impl<const D: usize> FractureFlowStep<D> {
    /// Chooses and analyses the solvers once.
    ///
    /// # Errors
    /// [`StepError`] if a solver is refused, or if the scene has what this scheme cannot do.
    pub fn new(plan: &Plan, damage: DamagePlan, model: &Model<D>) -> Result<Self, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        if !solid.walls.is_empty() {
            return Err(refused(
                "sides do not move in it; use roller, clamped or traction",
            ));
        }
        if plan.gravity.is_some() {
            return Err(refused(
                "gravity does not act in it yet; leave [gravity] out",
            ));
        }
        if !flow.stabilisation.is_empty() {
            return Err(refused(
                "it has no stabilisation; set coupling.stabilisation = 0",
            ));
        }
        let together = match plan.scheme {
            SchemeChoice::Staggered(_) => false,
            SchemeChoice::Implicit(_) | SchemeChoice::Monolithic(_) => true,
            _ => {
                return Err(refused(
                    "its steps are implicit; use --scheme monolithic or staggered",
                ));
            }
        };
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
        let problem = Problem {
            solves: 1,
            contrast: ratio(flow.mobility.iter().copied()),
            coordinates: Some(Coordinates {
                dimension: D,
                values: &coordinates,
            }),
            near_nullspace: NearNullspace::RigidModes,
            ..plain
        };
        let demand = plan.fracture_demand();
        let (solver, chosen) = build_solver(&demand.spec, &problem)?;
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
            rates: [Vec::new(), Vec::new()],
            forcing: FORCING,
            upkeep: Upkeep::default(),
            acceleration: Acceleration::default(),
            daring: Daring::new(damage.method),
            cut_above: match plan.time.step {
                StepRule::Fixed(_) => f64::INFINITY,
                StepRule::Adaptive => damage.shortest_step,
            },
            passes: 0,
            searches: 0,
            products: 0,
        })
    }

    fn evaluate(&mut self, model: &Model<D>, state: &State) -> Result<Trial<D>, StepError> {
        let answer = solid_of(model)?
            .answer(&state.displacement, &state.walls, &state.history)
            .ok_or(StepError::Missing { part: "[damage]" })?;
        self.searches += 1;
        weigh_forces(model, state, answer)
    }

    /// What the pores must still take up over the step, m^D; zero where the pressure is prescribed.
    fn shortfall(
        &mut self,
        model: &Model<D>,
        old: &State,
        state: &State,
        dt: f64,
    ) -> Result<Vec<f64>, StepError> {
        let flow = flow_of(model)?;
        let mut left = vec![0.0; flow.points()];
        flow.imbalance(state.time, &state.pressure, &mut left);
        self.products += 1;
        let taken = taken(model, old, state)?;
        for (i, left) in left.iter_mut().enumerate() {
            *left = match self.is_fixed[i] {
                true => 0.0,
                false => dt * *left - taken[i],
            };
        }
        Ok(left)
    }

    /// Brings the pressure to the displacement.
    fn balance(
        &mut self,
        model: &Model<D>,
        old: &State,
        state: &mut State,
        dt: f64,
    ) -> Result<usize, StepError> {
        let flow = flow_of(model)?;
        let left = self.shortfall(model, old, state, dt)?;
        self.flow.forget(flow);
        self.flow.prepare(flow, &flow.capacity, dt, &[])?;
        let mut change = vec![0.0; left.len()];
        let iterations = self.flow.solve(flow, &left, &mut change)?;
        state
            .pressure
            .iter_mut()
            .zip(&change)
            .for_each(|(p, c)| *p += c);
        Ok(iterations)
    }

    /// Solution of the linear system at a trial whose pressure is balanced.
    fn solution(
        &mut self,
        model: &Model<D>,
        state: &State,
        at: &Trial<D>,
        dt: f64,
        softening: Softening,
        report: &mut StepReport,
    ) -> Result<Way, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        let damage = damage_of(solid)?;
        self.tangent
            .update(solid, damage, &state.history, &at.answer, softening);
        let Some(block) = &mut self.block else {
            let matrix = self.tangent.matrix.view();
            if self.upkeep.is_due() {
                self.solver.refresh(matrix)?;
                self.upkeep.renew();
            }
            let mut displacement = vec![0.0; at.force.len()];
            let solved =
                self.solver
                    .solve_to(matrix, &at.force, &mut displacement, FORCING_ALONE)?;
            self.upkeep.took(solved.iterations);
            report.iterations += solved.iterations;
            // The pressure stands still and is brought to the displacement in the next pass.
            return Ok(Way {
                displacement,
                pressure: vec![0.0; state.pressure.len()],
                bend: [0.0; 2],
            });
        };
        let stiffness = self.tangent.matrix.data();
        block.fill(stiffness, solid, flow, coupling, dt);
        let matrix = block.matrix.view();
        if self.upkeep.is_due() {
            self.solver.refresh(matrix)?;
            self.upkeep.renew();
        }
        let (width, scale) = (D + 1, block.layout.scale);
        let mut rhs = vec![0.0; block.matrix.rows()];
        for (point, force) in at.force.chunks(D).enumerate() {
            rhs[point * width..][..D].copy_from_slice(force);
        }
        let mut x = vec![0.0; rhs.len()];
        let solved = self.solver.solve_to(matrix, &rhs, &mut x, self.forcing)?;
        self.upkeep.took(solved.iterations);
        report.iterations += solved.iterations;
        let points = state.pressure.len();
        let displacement = (0..points)
            .flat_map(|i| x[i * width..][..D].to_vec())
            .collect();
        let pressure: Vec<f64> = (0..points).map(|i| scale * x[i * width + D]).collect();
        let product = |p: &[f64]| {
            let free = |i: usize| if self.is_fixed[i] { 0.0 } else { p[i] };
            let free: Vec<f64> = (0..p.len()).map(free).collect();
            let mut result = vec![0.0; p.len()];
            multiply(flow.matrix(), &free, &mut result);
            let terms = result.iter().zip(&flow.capacity).zip(&free);
            terms
                .map(|((l, s), p)| dt * l + s * p)
                .collect::<Vec<f64>>()
        };
        let along = product(&pressure);
        let bend = [dot(&along, &state.pressure), 0.5 * dot(&along, &pressure)];
        Ok(Way {
            displacement,
            pressure,
            bend,
        })
    }

    /// Direction in which the potential falls, with its tangent.
    fn direction(
        &mut self,
        model: &Model<D>,
        state: &State,
        at: &Trial<D>,
        dt: f64,
        imbalance: f64,
        report: &mut StepReport,
    ) -> Result<(Way, Softening), StepError> {
        let softening = self.daring.next(imbalance);
        let solved = self.solution(model, state, at, dt, softening, report);
        if softening != Softening::Exact {
            return Ok((solved?, softening));
        }
        if let Ok(way) = solved
            && dot(&at.force, &way.displacement) > 0.0
        {
            return Ok((way, softening));
        }
        self.daring.failed();
        self.upkeep.renew();
        let way = self.solution(model, state, at, dt, Softening::Bounded, report)?;
        Ok((way, Softening::Bounded))
    }

    /// Walks along a way until the potential has fallen enough; `None` if it does not.
    fn search(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        at: &Trial<D>,
        way: &Way,
    ) -> Result<Option<Reached<Trial<D>>>, StepError> {
        let external = self.external(model, state);
        let (start, balanced) = (state.displacement.clone(), state.pressure.clone());
        let place = |state: &mut State, length: f64| {
            let step = |to: &mut Vec<f64>, from: &[f64], by: &[f64]| {
                to.clear();
                to.extend(from.iter().zip(by).map(|(from, by)| from + length * by));
            };
            step(&mut state.displacement, &start, &way.displacement);
            step(&mut state.pressure, &balanced, &way.pressure);
        };
        let work = dot(&external, &way.displacement);
        let shares = &at.answer.hourglass;
        let high = at.answer.energy(shares);
        let slope = dot(&at.force, &way.displacement);
        let reached = descend(slope, ROUNDING * high.abs(), |length| {
            place(state, length);
            let found = self.evaluate(model, state)?;
            let flow = length * (way.bend[0] + length * way.bend[1]);
            Ok(Reached {
                length,
                fallen: high - found.answer.energy(shares) + length * work - flow,
                left: dot(&found.force, &way.displacement),
                found,
            })
        })?;
        place(
            state,
            reached.as_ref().map_or(0.0, |reached| reached.length),
        );
        Ok(reached)
    }

    /// Loads, and the push of pressures that do not change along a way.
    fn external(&self, model: &Model<D>, state: &State) -> Vec<f64> {
        let still = |i: usize| self.block.is_none() || self.is_fixed[i];
        let prescribed = |i: usize| if still(i) { state.pressure[i] } else { 0.0 };
        let pressure: Vec<f64> = (0..state.pressure.len()).map(prescribed).collect();
        model.push(state.time, &pressure)
    }

    /// Whether so much has broken since `old` that the step will be rejected: a crack that runs takes many
    /// passes, which are better spent on the step that keeps it.
    fn runs(&self, model: &Model<D>, old: &State, at: &Trial<D>) -> Result<bool, StepError> {
        let before = damage_of(solid_of(model)?)?.of(&old.history);
        let pairs = at.answer.damage.iter().zip(&before);
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
        imbalance: f64,
    ) -> bool {
        // A shortened or stretched pass is no pass of the same map.
        if imbalance > NEAR || (length - 1.0).abs() > 0.0 {
            self.acceleration.forget();
            return false;
        }
        let next = self.acceleration.next(start, &state.displacement);
        let goes_on = next.is_some();
        if let Some(next) = next {
            state.displacement = next;
        }
        goes_on
    }

    /// Passes until forces balance.
    fn solve(
        &mut self,
        model: &mut Model<D>,
        old: &State,
        dt: f64,
        state: &mut State,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        let mut found = self.evaluate(model, state)?;
        let (mut best, mut before) = (f64::INFINITY, f64::INFINITY);
        self.acceleration.forget();
        self.forcing = (10.0 * self.forcing).min(FORCING);
        for pass in 0..=self.plan.iterations {
            model.follow_fractures(&found.answer, &state.displacement, &state.walls);
            report.iterations += self.balance(model, old, state, dt)?;
            // The displacement stands still, so the solid's own answer is the same.
            let at = weigh_forces(model, state, found.answer)?;
            self.largest = self.largest.max(at.scale);
            let scale = at
                .scale
                .max(REMEMBERED * self.largest)
                .max(f64::MIN_POSITIVE);
            let left: f64 = at.force.iter().map(|f| f.abs()).sum();
            if !left.is_finite() {
                return Err(not_finite::<D>(&at.force, state.time));
            }
            if left <= self.plan.tolerance * scale {
                return Ok(());
            }
            if dt > self.cut_above && self.runs(model, old, &at)? {
                return Err(StepError::Runs {
                    time: state.time,
                    most: self.plan.largest_increment,
                });
            }
            let imbalance = left / scale;
            best = best.min(imbalance);
            if pass == self.plan.iterations {
                break;
            }
            if imbalance > SLOW * before {
                self.forcing = (0.1 * self.forcing).max(LEAST_FORCING);
            }
            if imbalance > WORSE * before {
                self.acceleration.forget();
            }
            before = imbalance;
            let start = state.displacement.clone();
            let (way, tried) = self.direction(model, state, &at, dt, imbalance, report)?;
            self.passes += 1;
            let Some(reached) = self.search(model, state, &at, &way)? else {
                if tried != Softening::Exact {
                    break;
                }
                // The exact tangent may have led astray; the others always lead down.
                self.daring.failed();
                found = at;
                continue;
            };
            found = match self.accelerate(start, state, reached.length, imbalance) {
                true => self.evaluate(model, state)?,
                false => reached.found,
            };
        }
        Err(StepError::NotBroken {
            time: state.time,
            residual: best,
            tolerance: self.plan.tolerance,
            iterations: self.passes as usize,
        })
    }
}

/// Forces out of balance of an answer under the pressure of a state.
fn weigh_forces<const D: usize>(
    model: &Model<D>,
    state: &State,
    answer: Answer<D>,
) -> Result<Trial<D>, StepError> {
    let mut force = model.push(state.time, &state.pressure);
    let scale = force.iter().map(|f| f.abs()).sum();
    solid_of(model)?.subtract_answer(&answer, &mut force);
    Ok(Trial {
        answer,
        force,
        scale,
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

fn refused(reason: &'static str) -> StepError {
    StepError::Refused {
        scheme: "flow in fractures",
        reason,
    }
}

/// What the pores took up since `old`, at the coefficients of now, m^D.
fn taken<const D: usize>(
    model: &Model<D>,
    old: &State,
    state: &State,
) -> Result<Vec<f64>, StepError> {
    let flow = flow_of(model)?;
    let step = state.since(old);
    let mut taken = model.content(&step.displacement, &step.walls);
    for (i, taken) in taken.iter_mut().enumerate() {
        *taken += flow.capacity[i] * step.pressure[i];
    }
    Ok(taken)
}

impl<const D: usize> Scheme<D> for FractureFlowStep<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn local_order(&self) -> f64 {
        2.0
    }

    fn start(&mut self, model: &mut Model<D>, state: &mut State) -> Result<(), StepError> {
        if !coupling_of(model)?.undrained_start {
            return Ok(());
        }
        let old = state.clone();
        self.solve(model, &old, 0.0, state, &mut StepReport::default())?;
        advance(model, state);
        Ok(())
    }

    fn step(
        &mut self,
        model: &mut Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        trial.clone_from(old);
        trial.time = old.time + dt;
        for (u, rate) in trial.displacement.iter_mut().zip(&self.rates[1]) {
            *u += dt * rate;
        }
        self.solve(model, old, dt, trial, &mut report)?;
        trial.check()?;
        self.rates[0].clear();
        let moved = trial.displacement.iter().zip(&old.displacement);
        self.rates[0].extend(moved.map(|(new, old)| (new - old) / dt));
        let flow = flow_of(model)?;
        let mut imbalance = vec![0.0; flow.points()];
        flow.imbalance(trial.time, &trial.pressure, &mut imbalance);
        let taken = taken(model, old, trial)?;
        report.flows = weigh(flow, &[(dt, &trial.pressure, trial.time, &imbalance)]);
        report.flows.fixed += flow
            .fixed
            .iter()
            .map(|fixed| taken[fixed.point])
            .sum::<f64>();
        report.stored = Some(taken.iter().sum());
        advance(model, trial);
        report.growth = growth(model, old, trial);
        Ok(report)
    }

    fn accept(&mut self) {
        let [trial, accepted] = &mut self.rates;
        std::mem::swap(trial, accepted);
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            products: self.products,
            solver: self.solver.counters().clone(),
            coupling_iterations: self.passes,
            searches: self.searches,
            fallbacks: self.daring.failures,
            refilled_families: self.tangent.refilled,
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.chosen.clone())
    }
}
