//! Equilibrium of a solid that breaks, alone or with fluid in what is broken.

mod block;
mod compliance;
mod flow;
mod lagged;
mod rates;

use perifrac_solvers::{Demand, Problem};

use super::descent::{
    Advance, Descended, Descent, Direction, Energy, PassMonitor, Passes, Residuals, TangentSolver,
    Trial, converge,
};
use super::solid::mechanics_problem;
use super::{Memory, SchemeCounters, SolidSolver, State, StepError, StepReport, solid_of};
use crate::material::TangentKind;
use crate::model::{Model, SolidModel};
use crate::plan::{DamageMethod, DamagePlan};

pub use flow::FractureFlowStep;
pub use lagged::LaggedFracture;

/// Iterations with damage eliminated.
pub struct Fracture<const D: usize> {
    linear: TangentSolver<D>,
    plan: DamagePlan,
    descent: Descent,
    /// Largest forces of equilibria so far, N: a scale once the solid is in two.
    largest: f64,
    newton: u64,
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
        Ok(Fracture {
            linear: TangentSolver::new(demand, &problem, solid, &plan.descent)?,
            plan,
            descent: Descent::new(&plan),
            largest: 0.0,
            newton: 0,
        })
    }

    /// Moves the prescribed walls to their place at the state's time and the points with them, as far as
    /// the last tangent tells.
    fn predict(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        let solid = solid_of(model)?;
        let before = state.walls.clone();
        let mut moved = before.clone();
        solid.place_walls(state.time, &mut moved);
        let moves: Vec<f64> = moved.iter().zip(&before).map(|(n, o)| n - o).collect();
        if moves.iter().all(|by| by.abs() <= 0.0) {
            return Ok(());
        }
        // The forces are those at the walls' old place.
        let here = Trial::of(model, state)?;
        state.walls = moved;
        self.linear
            .follow(solid, state, &here, TangentKind::Bounded)?;
        let push = self.linear.tangent.wall_push(solid, &moves);
        let force: Vec<f64> = here.force.iter().zip(&push).map(|(f, p)| f - p).collect();
        let change = self.linear.solve(&force, self.plan.descent.solid_forcing)?;
        let pairs = state.displacement.iter_mut().zip(&change);
        pairs.for_each(|(u, change)| *u += change);
        Ok(())
    }
}

/// The energy of the solid at a given pressure.
struct SolidEnergy<'a, const D: usize> {
    linear: &'a mut TangentSolver<D>,
    model: &'a Model<D>,
    solid: &'a SolidModel<D>,
    loads: &'a [f64],
    /// Residual of the linear systems.
    forcing: f64,
}

impl<const D: usize> Energy<D> for SolidEnergy<'_, D> {
    fn evaluate(&mut self, state: &State) -> Result<Trial<D>, StepError> {
        let mut trial = Trial::of(self.model, state)?;
        let held = self.solid.wall_forces(&trial.response);
        trial.scale += held.iter().map(|f| f.abs()).sum::<f64>();
        Ok(trial)
    }

    fn loads(&self, _state: &State) -> Vec<f64> {
        self.loads.to_vec()
    }

    fn solve(
        &mut self,
        state: &State,
        at: &Trial<D>,
        tangent: TangentKind,
    ) -> Result<Direction, StepError> {
        self.linear.follow(self.solid, state, at, tangent)?;
        Ok(Direction {
            displacement: self.linear.solve(&at.force, self.forcing)?,
            ..Direction::default()
        })
    }
}

/// Passes of the displacement alone.
struct SolidPasses<'a, const D: usize> {
    energy: SolidEnergy<'a, D>,
    descent: &'a mut Descent,
    largest: f64,
    passes: u64,
}

impl<const D: usize> Passes<D> for SolidPasses<'_, D> {
    type Iterate = Trial<D>;

    fn place(
        &mut self,
        state: &mut State,
        found: Option<Trial<D>>,
        _monitor: &PassMonitor,
    ) -> Result<(Trial<D>, Residuals), StepError> {
        let here = match found {
            Some(found) => found,
            None => self.energy.evaluate(state)?,
        };
        let forces =
            here.imbalance(self.descent.settings.remembered_scale * self.largest, state)?;
        let left = Residuals {
            forces,
            ..Residuals::default()
        };
        Ok((here, left))
    }

    fn trial<'a>(&self, place: &'a Trial<D>) -> &'a Trial<D> {
        place
    }

    fn advance(
        &mut self,
        state: &mut State,
        place: Trial<D>,
        monitor: &PassMonitor,
    ) -> Result<Advance<D>, StepError> {
        self.passes += 1;
        let (energy, descent) = (&mut self.energy, &mut *self.descent);
        Ok(
            match descent.pass(energy, state, place, monitor.imbalance())? {
                Descended::Down { to, .. } => Advance::Evaluated(Box::new(to)),
                Descended::Stayed(at) => Advance::Evaluated(Box::new(at)),
                Descended::Stuck => Advance::Stuck,
            },
        )
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
        let before = self.linear.iterations;
        self.predict(model, state)?;
        let loads = model.external_force(state.time, &state.pressure);
        let mut passes = SolidPasses {
            energy: SolidEnergy {
                linear: &mut self.linear,
                model,
                solid: solid_of(model)?,
                loads: &loads,
                forcing: self.plan.descent.solid_forcing,
            },
            descent: &mut self.descent,
            largest: self.largest,
            passes: 0,
        };
        let ended = converge(&mut passes, &self.plan, state, &mut StepReport::default());
        self.newton += passes.passes;
        self.largest = self.largest.max(ended?);
        Ok(self.linear.iterations - before)
    }

    fn accuracy(&self) -> f64 {
        self.plan.tolerance
    }

    fn recall(&mut self, memory: &Memory) {
        self.largest = memory.largest_force;
        self.descent.policy.rest = memory.tangent_rest;
        self.linear.begin_anew();
    }

    fn remember(&self, memory: &mut Memory) {
        memory.largest_force = self.largest;
        memory.tangent_rest = self.descent.policy.rest;
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            mechanics: Some(self.linear.counters()),
            newton_iterations: self.newton,
            fallbacks: self.descent.policy.failures,
            searches: self.descent.searches,
            refilled_families: self.linear.tangent.refilled,
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.linear.chosen.clone())
    }
}

#[cfg(test)]
mod tests;
