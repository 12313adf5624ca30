//! The walk down an energy to where forces balance.
//!
//! Damage is local, so it is eliminated: the energy is a function of the displacement alone, or of displacement and
//! pressure, whose derivative is the force. Every pass solves with a tangent of that force and walks down the energy.
//! With the tangent at fixed damage this is alternate minimisation: the energy is concave in the driving energy, so
//! the step never goes uphill. With as much softening as leaves every point positive it is faster, with all of it it is
//! Newton's method, which the solver may refuse where the tangent is indefinite; then the next ones are tried.
//!
//! What there is to walk down is an [`Energy`]: the solid alone, or with the pressure eliminated. Passes and their
//! end are the same for all, and for the saddle of displacement and pressure, where each pass takes its whole step:
//! see [`Passes`]. Every constant is in [`DescentSettings`].

mod acceleration;
mod closing;
mod line_search;
mod passes;
mod reuse;
mod stagnation;
mod tangent_matrix;
mod tangent_policy;
mod tangent_solver;

use perifrac_solvers::dot;

use super::{State, StepError, solid_of};
use crate::material::TangentKind;
use crate::model::{Model, SolidModel};
use crate::operators::{Damage, Response};
use crate::plan::{DamagePlan, DescentSettings};
use closing::keep_broken;
use line_search::{Reached, line_search};

pub(super) use acceleration::AndersonAcceleration;
pub(super) use passes::{Advance, PassMonitor, Passes, Residuals, converge};
pub(super) use stagnation::Stagnation;
pub(super) use tangent_matrix::TangentMatrix;
pub(super) use tangent_policy::TangentPolicy;
pub(super) use tangent_solver::TangentSolver;

/// A state with what the solid answers to it.
pub(super) struct Trial<const D: usize> {
    pub response: Response<D>,
    /// Forces out of balance, N.
    pub force: Vec<f64>,
    /// Σ of all absolute forces, N.
    pub scale: f64,
}

impl<const D: usize> Trial<D> {
    /// What a model answers to a state under its loads and pressure.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without a solid that breaks.
    pub(super) fn of(model: &Model<D>, state: &State) -> Result<Self, StepError> {
        Self::with(model, state, response_to(model, state)?)
    }

    /// The same where the response is known.
    ///
    /// # Errors
    /// As [`Trial::of`].
    pub(super) fn with(
        model: &Model<D>,
        state: &State,
        response: Response<D>,
    ) -> Result<Self, StepError> {
        let mut force = model.external_force(state.time, &state.pressure);
        let solid = solid_of(model)?;
        let loads: f64 = force.iter().map(|f| f.abs()).sum();
        let scale = loads + model.crack_push(&response) + solid.in_situ_force;
        solid.subtract_internal_force(&response, &mut force);
        Ok(Trial {
            response,
            force,
            scale,
        })
    }

    /// Forces out of balance, relative to all forces, or to a scale (N) where that is larger.
    ///
    /// # Errors
    /// [`StepError::NotFinite`] with the place of the first force that is no number.
    pub(crate) fn imbalance(&self, scale: f64, state: &State) -> Result<f64, StepError> {
        let left: f64 = self.force.iter().map(|f| f.abs()).sum();
        if left.is_finite() {
            return Ok(left / self.scale.max(scale).max(f64::MIN_POSITIVE));
        }
        let first = self.force.iter().position(|force| !force.is_finite());
        Err(StepError::NotFinite {
            field: "force",
            point: first.unwrap_or(0) / D,
            time: state.time,
        })
    }
}

/// Where a pass leads: a straight way of the displacement, m, and of the pressure, Pa, which is empty where it stands
/// still.
#[derive(Default)]
pub(super) struct Direction {
    pub displacement: Vec<f64>,
    pub pressure: Vec<f64>,
    /// Slope and half the curvature along it of what the potential owes the pressure, J.
    pub bend: [f64; 2],
}

/// Something whose forces are the derivative of a potential.
pub(super) trait Energy<const D: usize> {
    /// What the solid answers to a state, and what that leaves out of balance.
    ///
    /// # Errors
    /// [`StepError`] if a part of the model is missing.
    fn evaluate(&mut self, state: &State) -> Result<Trial<D>, StepError>;

    /// Loads that stay as they are along a direction, N.
    fn loads(&self, state: &State) -> Vec<f64>;

    /// The way that balances the forces of a trial as far as a tangent tells.
    ///
    /// # Errors
    /// [`StepError`] if the solver refuses.
    fn solve(
        &mut self,
        state: &State,
        at: &Trial<D>,
        tangent: TangentKind,
    ) -> Result<Direction, StepError>;
}

/// Where a pass led.
pub(super) enum Descended<const D: usize> {
    /// Down, by so much of its direction.
    Down { to: Trial<D>, length: f64 },
    /// Nowhere, but the next one may: it has another tangent, or damage was kept.
    Stayed(Trial<D>),
    /// Nowhere.
    Stuck,
}

/// Passes down an energy, with what they learn.
pub(super) struct Descent {
    pub settings: DescentSettings,
    pub policy: TangentPolicy,
    /// Evaluations of the force.
    pub searches: u64,
}

impl Descent {
    /// As damage is to be found.
    pub(crate) fn new(damage: &DamagePlan) -> Self {
        Descent {
            settings: damage.descent,
            policy: TangentPolicy::new(damage.method, damage.descent),
            searches: 0,
        }
    }

    /// One pass from a trial with so much out of balance, relative to all forces.
    ///
    /// # Errors
    /// Those of the energy.
    pub(crate) fn pass<const D: usize>(
        &mut self,
        energy: &mut impl Energy<D>,
        state: &mut State,
        at: Trial<D>,
        imbalance: f64,
    ) -> Result<Descended<D>, StepError> {
        let (way, tried) = self.direction(energy, state, &at, imbalance)?;
        let reached = self.search(energy, state, &at, &way)?;
        let length = reached.as_ref().map(|reached| reached.length);
        self.policy.judge(tried, length);
        Ok(match reached {
            Some(Reached { found, length, .. }) => Descended::Down { to: found, length },
            // The exact tangent may have led astray; the others always lead down.
            None if tried == TangentKind::Consistent => Descended::Stayed(at),
            None if self.keep_what_broke(energy, state, &at, &way)? => Descended::Stayed(at),
            None => Descended::Stuck,
        })
    }

    /// Direction in which the potential falls, with its tangent.
    fn direction<const D: usize>(
        &mut self,
        energy: &mut impl Energy<D>,
        state: &State,
        at: &Trial<D>,
        imbalance: f64,
    ) -> Result<(Direction, TangentKind), StepError> {
        let tangent = self.policy.next(imbalance);
        let solved = energy.solve(state, at, tangent);
        if tangent != TangentKind::Consistent {
            return Ok((solved?, tangent));
        }
        if let Ok(way) = solved
            && dot(&at.force, &way.displacement) > 0.0
        {
            return Ok((way, tangent));
        }
        self.policy.failed();
        let way = energy.solve(state, at, TangentKind::Bounded)?;
        Ok((way, TangentKind::Bounded))
    }

    /// Walks along a way until the potential has fallen enough; `None` if it does not.
    fn search<const D: usize>(
        &mut self,
        energy: &mut impl Energy<D>,
        state: &mut State,
        at: &Trial<D>,
        way: &Direction,
    ) -> Result<Option<Reached<Trial<D>>>, StepError> {
        let loads = energy.loads(state);
        let start = (state.displacement.clone(), state.pressure.clone());
        let (work, along) = (
            dot(&loads, &state.displacement),
            dot(&loads, &way.displacement),
        );
        let shares = &at.response.hourglass;
        let high = at.response.energy(shares);
        let rounding = self.settings.rounding * (at.response.bulk.abs() + work.abs());
        let slope = dot(&at.force, &way.displacement);
        let mut searches = 0;
        let reached = line_search(&self.settings, slope, rounding, |length| {
            way.place(state, &start, length);
            let found = energy.evaluate(state)?;
            searches += 1;
            let flow = length * (way.bend[0] + length * way.bend[1]);
            Ok(Reached {
                length,
                fallen: high - found.response.energy(shares) + length * along - flow,
                left: dot(&found.force, &way.displacement),
                found,
            })
        })?;
        self.searches += searches;
        let length = reached.as_ref().map_or(0.0, |reached| reached.length);
        way.place(state, &start, length);
        Ok(reached)
    }

    /// Keeps the damage that opening brought to points that close next to where a way begins; whether there are any.
    fn keep_what_broke<const D: usize>(
        &mut self,
        energy: &mut impl Energy<D>,
        state: &mut State,
        at: &Trial<D>,
        way: &Direction,
    ) -> Result<bool, StepError> {
        let start = (state.displacement.clone(), state.pressure.clone());
        way.place(state, &start, self.settings.closing_probe);
        let there = energy.evaluate(state)?;
        way.place(state, &start, 0.0);
        Ok(keep_broken(
            &at.response,
            &there.response,
            &mut state.history,
        ))
    }
}

impl Direction {
    /// Puts a state so far along the way from where it began, in units of the way.
    fn place(&self, state: &mut State, start: &(Vec<f64>, Vec<f64>), length: f64) {
        let step = |to: &mut [f64], from: &[f64], by: &[f64]| {
            for ((to, from), by) in to.iter_mut().zip(from).zip(by) {
                *to = from + length * by;
            }
        };
        step(&mut state.displacement, &start.0, &self.displacement);
        step(&mut state.pressure, &start.1, &self.pressure);
    }
}

/// How a solid responds to a state.
pub(super) fn response_to<const D: usize>(
    model: &Model<D>,
    state: &State,
) -> Result<Response<D>, StepError> {
    model
        .response(&state.view())
        .ok_or(StepError::MissingPart { part: "[damage]" })
}

/// The damage of a solid that breaks.
pub(super) fn damage_of<const D: usize>(solid: &SolidModel<D>) -> Result<&Damage<D>, StepError> {
    solid
        .damage
        .as_ref()
        .ok_or(StepError::MissingPart { part: "[damage]" })
}
