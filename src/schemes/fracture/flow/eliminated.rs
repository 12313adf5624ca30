//! Passes in which the pressure is brought to the displacement, and the displacement walks down what is left: the
//! energy with the pressure eliminated, or at a pressure that stands still where fields take turns.

use perifrac_solvers::{dot, multiply};

use super::system::FractureSystem;
use super::{FractureFlowStep, StepStart};
use crate::material::TangentKind;
use crate::model::{Model, Spreading};
use crate::schemes::descent::{
    Advance, Descended, Direction, Energy, PassMonitor, Passes, Residuals, Trial, response_to,
};
use crate::schemes::{State, StepError, flow_of};

/// The energy of a model whose pressure follows from the displacement, or stands still.
struct EliminatedEnergy<'a, const D: usize> {
    system: &'a mut FractureSystem<D>,
    model: &'a Model<D>,
    /// Step, s.
    dt: f64,
}

impl<const D: usize> EliminatedEnergy<'_, D> {
    /// Slope and half the curvature along a change of the pressure of ½ pᵀMp over the free pressures; the push of the
    /// prescribed ones is a load.
    fn bend(&self, state: &State, pressure: &[f64]) -> Result<[f64; 2], StepError> {
        let flow = flow_of(self.model)?;
        let is_fixed = &self.system.is_fixed;
        let free = |i: usize, value: f64| if is_fixed[i] { 0.0 } else { value };
        let own: Vec<f64> = (0..pressure.len()).map(|i| free(i, pressure[i])).collect();
        let mut along = vec![0.0; pressure.len()];
        multiply(flow.matrix(), &own, &mut along);
        for (i, along) in along.iter_mut().enumerate() {
            *along = free(i, self.dt * *along + flow.capacity[i] * own[i]);
        }
        Ok([dot(&along, &state.pressure), 0.5 * dot(&along, pressure)])
    }
}

impl<const D: usize> Energy<D> for EliminatedEnergy<'_, D> {
    fn evaluate(&mut self, state: &State) -> Result<Trial<D>, StepError> {
        Trial::of(self.model, state)
    }

    fn loads(&self, state: &State) -> Vec<f64> {
        let still = |i: usize| !self.system.is_coupled() || self.system.is_fixed[i];
        let prescribed = |i: usize| if still(i) { state.pressure[i] } else { 0.0 };
        let pressure: Vec<f64> = (0..state.pressure.len()).map(prescribed).collect();
        self.model.external_force(state.time, &pressure)
    }

    fn solve(
        &mut self,
        state: &State,
        at: &Trial<D>,
        tangent: TangentKind,
    ) -> Result<Direction, StepError> {
        if !self.system.is_coupled() {
            // The pressure stands still and is brought to the displacement in the next pass.
            return self.system.solve_alone(self.model, state, at, tangent);
        }
        let with = (self.dt, tangent);
        let way = self
            .system
            .solve_together(self.model, state, (at, &[]), with)?;
        Ok(Direction {
            bend: self.bend(state, &way.pressure)?,
            ..way
        })
    }
}

/// Passes between coefficients, pressure and displacement.
pub(super) struct EliminatedPasses<'a, const D: usize> {
    step: &'a mut FractureFlowStep<D>,
    /// The model with the coefficients of the last place.
    model: &'a mut Model<D>,
    start: &'a StepStart<'a>,
    /// How far the pressure of cracks may reach in the next pass; no further once it was taken back.
    spreading: Option<Spreading>,
    /// Iterations of flow alone.
    pub iterations: usize,
}

/// Where a pass starts.
pub(super) struct Iterate<const D: usize> {
    at: Trial<D>,
    /// What passes move, before the pressure was brought to the displacement.
    start: Vec<f64>,
}

impl<'a, const D: usize> EliminatedPasses<'a, D> {
    /// Before the first pass, with the model at the coefficients of the step's start.
    pub(crate) fn new(
        step: &'a mut FractureFlowStep<D>,
        model: &'a mut Model<D>,
        start: &'a StepStart<'a>,
    ) -> Self {
        EliminatedPasses {
            step,
            model,
            start,
            spreading: Some(Spreading::Anew),
            iterations: 0,
        }
    }

    /// Brings coefficients and compliance to a response.
    fn follow(&mut self, state: &State, at: &Trial<D>) -> Result<(), StepError> {
        let Some(spreading) = self.spreading else {
            self.model.follow_openings(&at.response);
            return Ok(());
        };
        self.spreading = Some(Spreading::Further);
        let fields = (&state.displacement[..], &state.walls[..]);
        self.model.follow_fractures(&at.response, fields, spreading);
        if spreading == Spreading::Anew {
            self.iterations +=
                (self.step).follow_compliance(self.model, self.start.state, state)?;
        }
        Ok(())
    }

    /// Learns from how the last pass went.
    fn react(&mut self, monitor: &PassMonitor) {
        let settings = &self.step.descent.settings;
        if monitor.contraction() > settings.slow_contraction {
            self.step.system.sharpen(settings.least_forcing);
        }
        if monitor.contraction() > settings.divergence {
            self.step.acceleration.forget();
        }
    }

    /// Goes on from a pass that led from `start` to the state; false if it stays there. The coefficients of flow lag
    /// behind, so near the end passes contract linearly, and the energy says nothing of it.
    fn accelerate(
        &mut self,
        start: Vec<f64>,
        state: &mut State,
        length: f64,
        monitor: &PassMonitor,
    ) -> bool {
        let step = &mut *self.step;
        // A shortened or stretched pass is no pass of the same map.
        if monitor.imbalance() > step.descent.settings.near_balance || (length - 1.0).abs() > 0.0 {
            step.acceleration.forget();
            if monitor.share() >= 1.0 {
                return false;
            }
            let pairs = start.iter().zip(step.unknowns(state));
            let part: Vec<f64> = pairs.map(|(s, e)| s + monitor.share() * (e - s)).collect();
            step.set_unknowns(&part, state);
            return true;
        }
        let end = step.unknowns(state);
        let next = step.acceleration.next(start, &end);
        let goes_on = next.is_some();
        if let Some(next) = next {
            step.set_unknowns(&next, state);
        }
        goes_on
    }
}

impl<const D: usize> Passes<D> for EliminatedPasses<'_, D> {
    type Iterate = Iterate<D>;

    fn place(
        &mut self,
        state: &mut State,
        found: Option<Trial<D>>,
        _monitor: &PassMonitor,
    ) -> Result<(Iterate<D>, Residuals), StepError> {
        let found = match found {
            Some(found) => found,
            None => Trial::of(self.model, state)?,
        };
        self.follow(state, &found)?;
        let start = self.step.unknowns(state);
        let (iterations, owed) =
            (self.step).balance(self.model, self.start, state, &found.response)?;
        self.iterations += iterations;
        // The displacement stands still, so the response is the same unless fluid acts in cracks.
        let response = match self.model.has_crack_content() {
            true => response_to(self.model, state)?,
            false => found.response,
        };
        let at = Trial::with(self.model, state, response)?;
        let settings = &self.step.descent.settings;
        let left = Residuals {
            forces: at.imbalance(self.step.scale(), state)?,
            mass: owed,
            allowed: [
                settings.splitting_tolerance,
                settings.stagnant_splitting_tolerance,
            ],
        };
        Ok((Iterate { at, start }, left))
    }

    fn trial<'a>(&self, place: &'a Iterate<D>) -> &'a Trial<D> {
        &place.at
    }

    fn check(&self, state: &State, place: &Iterate<D>) -> Result<(), StepError> {
        self.step
            .check_run(self.model, self.start, state, &place.at)
    }

    fn takes_back(&mut self, place: &Iterate<D>) -> bool {
        let withdrawn = self.model.withdraw_fluid(&place.at.response);
        if withdrawn {
            self.spreading = None;
            self.step.acceleration.forget();
        }
        withdrawn
    }

    fn shortens(&self) -> bool {
        self.step.splits()
    }

    fn advance(
        &mut self,
        state: &mut State,
        place: Iterate<D>,
        monitor: &PassMonitor,
    ) -> Result<Advance<D>, StepError> {
        self.react(monitor);
        let Iterate { at, start } = place;
        let step = &mut *self.step;
        // Forces that are balanced to the last bits give no direction: the pressure alone moves on.
        if monitor.imbalance() <= step.descent.settings.force_floor * step.plan.tolerance {
            let moved = self.accelerate(start, state, 1.0, monitor);
            return Ok(match moved {
                true => Advance::Moved,
                false => Advance::Evaluated(Box::new(at)),
            });
        }
        step.passes += 1;
        let energy = &mut EliminatedEnergy {
            system: &mut step.system,
            model: self.model,
            dt: self.start.dt,
        };
        Ok(
            match step.descent.pass(energy, state, at, monitor.imbalance())? {
                Descended::Down { to, length } => {
                    match self.accelerate(start, state, length, monitor) {
                        true => Advance::Moved,
                        false => Advance::Evaluated(Box::new(to)),
                    }
                }
                Descended::Stayed(at) => Advance::Evaluated(Box::new(at)),
                Descended::Stuck => Advance::Stuck,
            },
        )
    }
}
