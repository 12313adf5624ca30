//! The audit of a step: what it does to the balances, against the limits of the plan.

use perifrac_solvers::dot;

use super::scale::Scale;
use super::time_loop::Run;
use crate::model::{Audit, Model, SolidModel};
use crate::plan::{SchemeChoice, TimeMode};
use crate::report::{Balance, Moment, Supply};
use crate::schemes::{Conserved, State, StepError, StepReport};

/// Fluid that rounding may lose, relative to all that the pores hold. A body at rest drifts by 4e-16 of it in six
/// steps.
const ROUNDING: f64 = 1e-13;

/// The same for strain that dynamic relaxation leaves, in tolerances of its forces: in the first instants of a column
/// it is more than what has moved, and shorter steps move less.
const RELAXED: f64 = 10.0;

/// Times the limit of the mass that explicit steps may owe between outputs. Terzaghi's column owes 24 % of what has
/// moved in the first step, 6 % in the fifth and 0.3 % in the 74th.
const DEBT: f64 = 10.0;

/// Share of what was unsettled in the step before that counts in the next: swings of the fastest kind take a few
/// steps, of those that matter tens.
const FADING: f64 = 0.9;

impl<const D: usize> Run<'_, D> {
    /// The balances as they would be if the trial were accepted, with the model at its coefficients.
    ///
    /// # Errors
    /// [`StepError::Unbalanced`] where one misses the plan's limit.
    pub(super) fn audit(
        &self,
        model: &Model<D>,
        report: &StepReport,
        trial: &State,
    ) -> Result<Balance, StepError> {
        let mut balance = self.balance.clone();
        let before = balance.moved();
        balance.add(&report.flows);
        let now = Stored::of(model, trial);
        balance.held = balance.held.max(now.held);
        balance.exchanged += exchanged(model, &self.state, trial);
        let stored = match report.stored {
            Some(own) => [balance.stored + own, 0.0],
            None => std::array::from_fn(|k| now.parts[k] - self.start_volume[k]),
        };
        let rounding = match self.plan.time.mode {
            TimeMode::Transient => self.rounding() * balance.held,
            // Rates, not volumes.
            TimeMode::Steady => 0.0,
        };
        balance.close(stored, rounding);
        let conjured = self.measure_mechanics(model, trial, &mut balance);
        let limits = &self.plan.audit;
        let step = match self.lags() {
            true => 0.0,
            false => {
                let moved = balance.moved().since(&before);
                let found = moved.error(rounding);
                match found > bound(limits.mass) {
                    true => moved.error(rounding.max(self.lost_by_flows(model, trial))),
                    false => found,
                }
            }
        };
        let lost = match (self.plan.time.mode, &model.flow) {
            (TimeMode::Steady, Some(flow)) => flow.rounding(&trial.pressure) / balance.turnover,
            _ => 0.0,
        };
        let debt = if self.repays() { DEBT } else { 1.0 };
        let forces = balance.momentum.unwrap_or(0.0);
        let checks = [
            (
                Conserved::Mass,
                balance.mass.max(step),
                (debt * bound(limits.mass)).max(lost),
            ),
            (Conserved::Momentum, forces, bound(limits.momentum)),
            (Conserved::Energy, conjured, bound(limits.energy)),
        ];
        for (quantity, found, limit) in checks {
            // What is no number misses every limit.
            if found.is_nan() || found > limit {
                let time = trial.time;
                return Err(StepError::Unbalanced {
                    time,
                    quantity,
                    found,
                    limit,
                });
            }
        }
        Ok(balance)
    }

    /// Holds a state that is handed out to what explicit steps may owe it: fluid, and swings of the pressure
    /// that more steps would have to wear down.
    ///
    /// # Errors
    /// [`StepError::Unbalanced`], [`StepError::LaggedStrainOscillation`].
    pub(super) fn audit_output(
        &self,
        scale: &Scale,
        trial: &State,
        balance: &Balance,
    ) -> Result<(), StepError> {
        let time = trial.time;
        let [mass, lag] = [self.plan.audit.mass, self.plan.audit.lag].map(bound);
        if self.repays() && balance.mass > mass {
            return Err(StepError::Unbalanced {
                time,
                quantity: Conserved::Mass,
                found: balance.mass,
                limit: mass,
            });
        }
        let found = scale.relative(&self.model, self.unsettled, &trial.pressure);
        match found <= lag {
            true => Ok(()),
            false => Err(StepError::LaggedStrainOscillation {
                time,
                found,
                limit: lag,
            }),
        }
    }

    /// What rounding of the flows may lose in a step, m^D: a sealed body at rest moves nothing, and the longer the step the
    /// more of it are differences of large flows.
    fn lost_by_flows(&self, model: &Model<D>, trial: &State) -> f64 {
        let rate = (model.flow.as_ref()).map_or(0.0, |flow| flow.rounding(&trial.pressure));
        rate * (trial.time - self.state.time)
    }

    /// Share of what the pores hold that may be lost to inexact arithmetic, and to strain that has only relaxed.
    fn rounding(&self) -> f64 {
        match self.lags() {
            true => RELAXED * self.plan.scheme_options.adr_tolerance,
            false => ROUNDING,
        }
    }

    /// Takes note of what strain leaves unsettled in a step.
    pub(super) fn remember_lag(&mut self, report: &StepReport) {
        let now = report.unsettled.unwrap_or(0.0);
        self.unsettled = now.max(FADING * self.unsettled);
    }

    /// Whether a step may owe fluid that the next ones repay.
    fn repays(&self) -> bool {
        self.plan.scheme == SchemeChoice::Explicit && self.model.coupling.is_some()
    }

    /// Whether strain may lag behind the pressure: what one step loses the next one gains, so that the run is
    /// held to the limit, and no step alone.
    fn lags(&self) -> bool {
        let semi = matches!(self.plan.scheme, SchemeChoice::SemiImplicit(_));
        self.repays() || semi && self.model.coupling.is_some()
    }

    /// Enters the balance of forces and the energies of a state; gives the energy that came from nowhere
    /// over all that was supplied or stored.
    pub(super) fn measure_mechanics(
        &self,
        model: &Model<D>,
        state: &State,
        balance: &mut Balance,
    ) -> f64 {
        let audit = model.audit(&state.view());
        balance.energy = audit.as_ref().map(|audit| audit.energy);
        balance.potential = audit.as_ref().map(|audit| audit.potential);
        let Some(audit) = audit else { return 0.0 };
        let inertia = (model.solid.as_deref()).filter(|solid| !solid.mass.is_empty());
        match inertia {
            Some(solid) => balance.balance_motion(moment(model, solid, state, audit)),
            None => {
                balance.balance_forces(audit.unbalanced, audit.forces);
                // What breaks at once takes more than the trapezoidal rule knows of.
                match self.plan.damage {
                    None => balance.balance_supply(supply(model, state, audit)),
                    Some(_) => 0.0,
                }
            }
        }
    }
}

/// A limit as it counts: one is none.
fn bound(limit: f64) -> f64 {
    if limit < 1.0 { limit } else { f64::INFINITY }
}

/// What the balances need of a body with inertia.
fn moment<const D: usize>(
    model: &Model<D>,
    solid: &SolidModel<D>,
    state: &State,
    audit: Audit,
) -> Moment {
    let of_components = solid.mass.iter().flat_map(|mass| [*mass; D]);
    Moment {
        time: state.time,
        mass: of_components.collect(),
        velocity: state.velocity.clone(),
        displacement: state.displacement.clone(),
        external: model.external_force(state.time, &state.pressure),
        total: audit.left,
        walls: state.walls.clone(),
        held: solid.internal_wall_force(&state.displacement, &state.walls, &[]),
        elastic: audit.elastic,
    }
}

/// What the balance of energy needs of a body without inertia.
fn supply<const D: usize>(model: &Model<D>, state: &State, audit: Audit) -> Supply {
    let mut supply = Supply {
        time: state.time,
        energy: audit.energy,
        loads: audit.loads,
        displacement: state.displacement.clone(),
        held: audit.held,
        walls: state.walls.clone(),
        ..Supply::default()
    };
    let Some(flow) = &model.flow else {
        return supply;
    };
    let (time, pressure) = (state.time, &state.pressure);
    let mut rate = vec![0.0; pressure.len()];
    flow.rate(time, &mut rate);
    let sides = flow.walls.iter();
    let sides = sides.map(|wall| -wall.pressure.at(time) * wall.outflow(time, pressure).0);
    let wells = flow.wells.power(&flow.controls, time, pressure);
    supply.inflow = dot(&rate, pressure) + sides.sum::<f64>() + wells;
    if !flow.fixed.is_empty() {
        let content = model.content(&state.displacement, &state.walls);
        flow.imbalance(time, pressure, &mut rate);
        let fixed = flow.fixed.iter().map(|fixed| {
            let i = fixed.point;
            [
                pressure[i],
                flow.capacity[i] * pressure[i] + content[i],
                rate[i],
            ]
        });
        supply.fixed = fixed.collect();
    }
    supply
}

/// Σ |V s Δp| between two states, m^D.
fn exchanged<const D: usize>(model: &Model<D>, from: &State, to: &State) -> f64 {
    let capacity = model.flow.iter().flat_map(|flow| &flow.capacity);
    let pairs = to.pressure.iter().zip(&from.pressure);
    pairs
        .zip(capacity)
        .map(|((to, from), c)| (c * (to - from)).abs())
        .sum()
}

/// Fluid content of the pores above that at rest, m^D.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Stored {
    /// By pressure and by strain.
    pub parts: [f64; 2],
    /// The same in absolute amounts: what rounding is relative to.
    pub held: f64,
}

impl Stored {
    /// That of a state.
    pub(super) fn of<const D: usize>(model: &Model<D>, state: &State) -> Self {
        let Some(flow) = &model.flow else {
            return Stored::default();
        };
        let mut content = match model.coupling {
            Some(_) => model.content(&state.displacement, &state.walls),
            None => Vec::new(),
        };
        if let Some(response) = model.crack_response(&state.view()) {
            let cracks = model.crack_content(Some(&response));
            content
                .iter_mut()
                .zip(cracks)
                .for_each(|(c, own)| *c += own);
        }
        let pairs = flow.capacity.iter().zip(&state.pressure);
        let size: f64 = pairs.map(|(c, p)| (c * p).abs()).sum();
        let pores = model.cracks().map_or(&[][..], |cracks| &cracks.pores);
        Stored {
            parts: [
                flow.stored(&state.pressure) + pores.iter().sum::<f64>(),
                content.iter().sum(),
            ],
            held: size + content.iter().map(|c| c.abs()).sum::<f64>(),
        }
    }
}
