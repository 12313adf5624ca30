//! Equilibrium of a solid that breaks.
//!
//! Damage is local, so it is eliminated: the energy is a function of the displacement alone, whose
//! derivative is the force. Every iteration solves with a tangent of that force and walks down the
//! energy. With the tangent at fixed damage this is alternate minimisation: the energy is concave in
//! the driving energy, so the step never goes uphill. With as much softening as leaves every point
//! positive it is faster, with all of it it is Newton's method, which the solver may refuse where the
//! tangent is indefinite; then the next ones are tried.

mod acceleration;
mod block;
mod closing;
mod compliance;
mod flow;
mod lagged;
mod line_search;
mod rates;
mod reuse;
mod tangent_policy;
mod tangents;

use perifrac_solvers::{Demand, LinearSolver, Problem, dot};

use super::solid::{Chosen, build_solver, mechanics_problem};
use super::{Memory, SchemeCounters, SolidSolver, State, StepError, solid_of};
use crate::material::TangentKind;
use crate::model::{Model, SolidModel};
use crate::operators::{Damage, Response};
use crate::plan::{DamageMethod, DamagePlan};
use closing::{NEXT_TO_HERE, keep_broken};
use line_search::{LineSearch, line_search};
use tangent_policy::TangentPolicy;
use tangents::TangentMatrix;

pub use flow::FractureFlowStep;
pub use lagged::LaggedFracture;

/// Iterations with damage eliminated.
pub struct Fracture<const D: usize> {
    solver: Box<dyn LinearSolver>,
    chosen: Chosen,
    plan: DamagePlan,
    tangent: TangentMatrix<D>,
    /// Whether the solver knows the matrix as it is.
    fresh: bool,
    policy: TangentPolicy,
    /// Largest force on the solid so far, N: a scale once it is in two.
    largest: f64,
    newton: u64,
    searches: u64,
}

/// Residual of the linear systems relative to the forces out of balance.
const FORCING: f64 = 1e-3;
/// Share of the largest force so far that still counts as a scale.
const REMEMBERED: f64 = 1e-2;
/// Change of the potential, relative to it, that is rounding error.
const ROUNDING: f64 = 1e-14;

/// A displacement with what the solid answers to it.
struct Trial<const D: usize> {
    response: Response<D>,
    /// Forces out of balance, N.
    force: Vec<f64>,
    /// Work of the loads, J.
    work: f64,
}

impl<const D: usize> Trial<D> {
    /// Energy less the work of the loads, with the given shares of the hourglass term left, J.
    fn potential(&self, hourglass: &[f64]) -> f64 {
        self.response.energy(hourglass) - self.work
    }
}

impl<const D: usize> Fracture<D> {
    /// Chooses and analyses the solver once.
    ///
    /// # Errors
    /// [`StepError`] if the solver is refused.
    pub fn new(demand: &Demand, model: &Model<D>, plan: DamagePlan) -> Result<Self, StepError> {
        let solid = solid_of(model)?;
        let coordinates = model.cloud.flat_positions();
        let problem = Problem {
            // Cracks leave next to nothing of the stiffness.
            contrast: 1.0 / plan.residual_stiffness,
            solves: demand.solves,
            ..mechanics_problem(solid, solid.matrix(), &coordinates)
        };
        let (solver, chosen) = build_solver(&demand.spec, &problem, &model.timers)?;
        Ok(Fracture {
            solver,
            chosen,
            plan,
            tangent: TangentMatrix::new(solid),
            fresh: false,
            policy: TangentPolicy::new(plan.method),
            largest: 0.0,
            newton: 0,
            searches: 0,
        })
    }

    fn evaluate(
        &self,
        model: &Model<D>,
        state: &State,
        external: &[f64],
    ) -> Result<Trial<D>, StepError> {
        residual_at(model, state, external)
    }

    /// Scale of the forces, N.
    fn scale(&mut self, solid: &SolidModel<D>, external: &[f64], response: &Response<D>) -> f64 {
        let held: f64 = solid.wall_forces(response).iter().map(|f| f.abs()).sum();
        let external: f64 = external.iter().map(|f| f.abs()).sum();
        let released = solid.crack_force(response);
        let released: f64 = released.iter().map(|f| f.abs()).sum();
        let now = held + external + released + solid.in_situ_force;
        self.largest = self.largest.max(now);
        now.max(REMEMBERED * self.largest)
    }

    fn solve(&mut self, force: &[f64]) -> Result<(Vec<f64>, usize), StepError> {
        if !self.fresh {
            self.solver.refresh(self.tangent.matrix.view())?;
            self.fresh = true;
        }
        let mut change = vec![0.0; force.len()];
        let matrix = self.tangent.matrix.view();
        let report = self.solver.solve_to(matrix, force, &mut change, FORCING)?;
        Ok((change, report.iterations))
    }

    /// Moves the prescribed walls to their place at the state's time and the points with them, as far as
    /// the last tangent tells.
    fn predict(
        &mut self,
        solid: &SolidModel<D>,
        state: &mut State,
        here: &Trial<D>,
    ) -> Result<Option<usize>, StepError> {
        let before = state.walls.clone();
        solid.place_walls(state.time, &mut state.walls);
        let moves: Vec<f64> = state
            .walls
            .iter()
            .zip(&before)
            .map(|(n, o)| n - o)
            .collect();
        if moves.iter().all(|by| by.abs() <= 0.0) {
            return Ok(None);
        }
        self.bring(solid, state, here, TangentKind::Bounded)?;
        let push = self.tangent.wall_push(solid, &moves);
        let force: Vec<f64> = here.force.iter().zip(&push).map(|(f, p)| f - p).collect();
        let (change, iterations) = self.solve(&force)?;
        state
            .displacement
            .iter_mut()
            .zip(&change)
            .for_each(|(u, c)| *u += c);
        Ok(Some(iterations))
    }

    fn bring(
        &mut self,
        solid: &SolidModel<D>,
        state: &State,
        at: &Trial<D>,
        softening: TangentKind,
    ) -> Result<(), StepError> {
        let damage = damage_of(solid)?;
        let moved = self.tangent.update(
            solid,
            damage,
            state.view().damage(&at.response.fluid),
            &at.response,
            softening,
        );
        self.fresh &= !moved;
        Ok(())
    }

    /// Direction in which the potential falls, with the iterations it took and its tangent.
    fn direction(
        &mut self,
        solid: &SolidModel<D>,
        state: &State,
        at: &Trial<D>,
        imbalance: f64,
    ) -> Result<(Vec<f64>, usize, TangentKind), StepError> {
        let softening = self.policy.next(imbalance);
        self.bring(solid, state, at, softening)?;
        if softening != TangentKind::Consistent {
            let (change, iterations) = self.solve(&at.force)?;
            return Ok((change, iterations, softening));
        }
        if let Ok((change, iterations)) = self.solve(&at.force)
            && dot(&change, &at.force) > 0.0
        {
            return Ok((change, iterations, softening));
        }
        self.policy.failed();
        self.fresh = false;
        self.bring(solid, state, at, TangentKind::Bounded)?;
        let (change, iterations) = self.solve(&at.force)?;
        Ok((change, iterations, TangentKind::Bounded))
    }

    /// Keeps the damage that opening brought to points that close next to where `change` begins; whether there are any.
    fn keep_what_broke(
        &self,
        model: &Model<D>,
        state: &mut State,
        external: &[f64],
        at: &Trial<D>,
        change: &[f64],
    ) -> Result<bool, StepError> {
        let start = state.displacement.clone();
        let pairs = state.displacement.iter_mut().zip(change);
        pairs.for_each(|(u, c)| *u += NEXT_TO_HERE * c);
        let there = self.evaluate(model, state, external)?;
        state.displacement = start;
        Ok(keep_broken(
            &at.response,
            &there.response,
            &mut state.history,
        ))
    }

    /// Walks along `change` until the potential has fallen enough; `None` if it does not.
    fn search(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        external: &[f64],
        at: &Trial<D>,
        change: &[f64],
    ) -> Result<Option<LineSearch<Trial<D>>>, StepError> {
        let start = state.displacement.clone();
        let place = |state: &mut State, length: f64| {
            let moved = start.iter().zip(change).map(|(u, c)| u + length * c);
            state.displacement.clear();
            state.displacement.extend(moved);
        };
        let shares = &at.response.hourglass;
        let high = at.potential(shares);
        let rounding = ROUNDING * (at.response.bulk.abs() + at.work.abs());
        let mut searches = 0;
        let reached = line_search(dot(&at.force, change), rounding, |length| {
            place(state, length);
            let found = self.evaluate(model, state, external)?;
            searches += 1;
            Ok(LineSearch {
                length,
                fallen: high - found.potential(shares),
                left: dot(&found.force, change),
                found,
            })
        })?;
        self.searches += searches;
        place(
            state,
            reached.as_ref().map_or(0.0, |reached| reached.length),
        );
        Ok(reached)
    }
}

/// How a solid responds to the displacement of a state, and what forces that leaves.
fn residual_at<const D: usize>(
    model: &Model<D>,
    state: &State,
    external: &[f64],
) -> Result<Trial<D>, StepError> {
    let response = model
        .response(&state.view())
        .ok_or(StepError::Missing { part: "[damage]" })?;
    let mut force = external.to_vec();
    solid_of(model)?.subtract_internal_force(&response, &mut force);
    Ok(Trial {
        work: dot(external, &state.displacement),
        response,
        force,
    })
}

/// The damage of a solid that breaks.
fn damage_of<const D: usize>(solid: &SolidModel<D>) -> Result<&Damage<D>, StepError> {
    solid
        .damage
        .as_ref()
        .ok_or(StepError::Missing { part: "[damage]" })
}

/// Place of the first force that is no number, as an error.
fn not_finite<const D: usize>(force: &[f64], time: f64) -> StepError {
    let first = force.iter().position(|force| !force.is_finite());
    StepError::NotFinite {
        field: "force",
        point: first.unwrap_or(0) / D,
        time,
    }
}

impl<const D: usize> SolidSolver<D> for Fracture<D> {
    fn name(&self) -> &'static str {
        match self.plan.method {
            DamageMethod::Auto => "damage, newton and alternate",
            DamageMethod::Newton => "damage, newton",
            DamageMethod::Alternate => "damage, alternate",
        }
    }

    fn equilibrate(&mut self, model: &Model<D>, state: &mut State) -> Result<usize, StepError> {
        let solid = solid_of(model)?;
        let external = model.external_force(state.time, &state.pressure);
        let mut at = self.evaluate(model, state, &external)?;
        let mut iterations = 0;
        if let Some(inner) = self.predict(solid, state, &at)? {
            iterations += inner;
            at = self.evaluate(model, state, &external)?;
        }
        let mut best = f64::INFINITY;
        for pass in 0..=self.plan.iterations {
            let scale = self.scale(solid, &external, &at.response);
            let sum: f64 = at.force.iter().map(|f| f.abs()).sum();
            let imbalance = if scale > 0.0 { sum / scale } else { sum };
            if !imbalance.is_finite() {
                return Err(not_finite::<D>(&at.force, state.time));
            }
            if sum <= self.plan.tolerance * scale {
                return Ok(iterations);
            }
            best = best.min(imbalance);
            if pass == self.plan.iterations {
                break;
            }
            let (change, inner, tried) = self.direction(solid, state, &at, imbalance)?;
            iterations += inner;
            self.newton += 1;
            let reached = self.search(model, state, &external, &at, &change)?;
            let length = reached.as_ref().map(|reached| reached.length);
            self.policy.judge(tried, length);
            match reached {
                Some(reached) => at = reached.found,
                // The exact tangent may have led astray; the others always lead down.
                None if tried == TangentKind::Consistent => {}
                None if self.keep_what_broke(model, state, &external, &at, &change)? => {}
                None => break,
            }
        }
        Err(StepError::NotBroken {
            time: state.time,
            residual: best,
            tolerance: self.plan.tolerance,
            iterations: self.newton as usize,
        })
    }

    fn accuracy(&self) -> f64 {
        self.plan.tolerance
    }

    fn recall(&mut self, memory: &Memory) {
        self.largest = memory.largest_force;
        self.policy.rest = memory.tangent_rest;
        // Tangents and preconditioners lag behind within a step only.
        self.tangent.forget();
        self.solver.begin_anew();
        self.fresh = false;
    }

    fn remember(&self, memory: &mut Memory) {
        memory.largest_force = self.largest;
        memory.tangent_rest = self.policy.rest;
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            mechanics: Some(self.solver.counters().clone()),
            newton_iterations: self.newton,
            fallbacks: self.policy.failures,
            searches: self.searches,
            refilled_families: self.tangent.refilled,
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.chosen.clone())
    }
}

#[cfg(test)]
mod tests;
