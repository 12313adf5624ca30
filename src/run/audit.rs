//! The audit of a step: what it does to the balances, against the limits of the plan.

use perifrac_solvers::dot;

use super::time_loop::Run;
use crate::model::{Audit, Model};
use crate::plan::{SchemeChoice, TimeMode};
use crate::report::{Balance, Moment, Supply};
use crate::schemes::{Conserved, State, StepError, StepReport};

/// Fluid that rounding may lose, relative to all that the pores hold: the sums of a million steps over a
/// body at rest drift by less.
const ROUNDING: f64 = 1e-13;

impl<const D: usize> Run<'_, D> {
    /// The balances as they would be if the trial were accepted.
    ///
    /// # Errors
    /// [`StepError::Unbalanced`] where one misses the plan's limit.
    pub(super) fn audit(&self, report: &StepReport, trial: &State) -> Result<Balance, StepError> {
        let mut balance = self.balance.clone();
        let before = balance.moved();
        balance.add(&report.flows);
        balance.held = balance.held.max(held(&self.model, trial));
        balance.exchanged += exchanged(&self.model, &self.state, trial);
        let stored = match report.stored {
            Some(own) => [balance.stored + own, 0.0],
            None => {
                let now = self.stored(trial);
                std::array::from_fn(|k| now[k] - self.start_volume[k])
            }
        };
        let rounding = match self.plan.time.mode {
            TimeMode::Transient => ROUNDING * balance.held,
            // Rates, not volumes.
            TimeMode::Steady => 0.0,
        };
        balance.close(stored, rounding);
        let conjured = self.measure_mechanics(trial, &mut balance);
        let step = match self.lags() {
            true => 0.0,
            false => balance.moved().since(&before).error(rounding),
        };
        let limits = &self.plan.audit;
        let forces = balance.momentum.unwrap_or(0.0);
        let checks = [
            (Conserved::Mass, balance.mass.max(step), limits.mass),
            (Conserved::Momentum, forces, limits.momentum),
            (Conserved::Energy, conjured, limits.energy),
        ];
        for (quantity, found, limit) in checks {
            // NaN misses every limit.
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

    /// Whether strain may lag behind the pressure: what one step loses the next one gains, so that the run is
    /// held to the limit, and no step alone.
    fn lags(&self) -> bool {
        let relaxes = SchemeChoice::Explicit == self.plan.scheme
            || matches!(self.plan.scheme, SchemeChoice::SemiImplicit(_));
        relaxes && self.model.coupling.is_some()
    }

    /// Enters the balance of forces and the energies of a state; gives the energy that came from nowhere
    /// over all that was supplied or stored.
    fn measure_mechanics(&self, state: &State, balance: &mut Balance) -> f64 {
        let State {
            time,
            pressure,
            displacement,
            walls,
            history,
            ..
        } = state;
        let audit = (self.model).audit(*time, pressure, displacement, walls, history);
        balance.energy = audit.as_ref().map(|audit| audit.energy);
        balance.potential = audit.as_ref().map(|audit| audit.potential);
        let Some(audit) = audit else { return 0.0 };
        match moment(&self.model, state, audit.elastic) {
            Some(now) => balance.balance_motion(now),
            None => {
                balance.balance_forces(audit.unbalanced, audit.forces);
                // What breaks at once takes more than the trapezoidal rule knows of.
                match self.plan.damage {
                    None => balance.balance_supply(supply(&self.model, state, audit)),
                    Some(_) => 0.0,
                }
            }
        }
    }

    /// Fluid content of the pores above that at rest, by pressure and by strain, m^D.
    pub(super) fn stored(&self, state: &State) -> [f64; 2] {
        let Some(flow) = &self.model.flow else {
            return [0.0; 2];
        };
        let strain: f64 = match self.model.coupling {
            Some(_) => self
                .model
                .content(&state.displacement, &state.walls)
                .iter()
                .sum(),
            None => 0.0,
        };
        [flow.stored(&state.pressure), strain]
    }
}

/// What the balances need of a body with inertia; nothing without.
fn moment<const D: usize>(model: &Model<D>, state: &State, elastic: f64) -> Option<Moment> {
    let solid = model
        .solid
        .as_ref()
        .filter(|solid| !solid.mass.is_empty())?;
    let external = model.push(state.time, &state.pressure);
    let mut total = external.clone();
    solid.subtract_internal(&state.displacement, &state.walls, &mut total);
    let of_components = solid.mass.iter().flat_map(|mass| [*mass; D]);
    Some(Moment {
        time: state.time,
        mass: of_components.collect(),
        velocity: state.velocity.clone(),
        displacement: state.displacement.clone(),
        external,
        total,
        walls: state.walls.clone(),
        held: solid.internal_wall_force(&state.displacement, &state.walls, &[]),
        elastic,
    })
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
    supply.inflow = dot(&rate, pressure) + sides.sum::<f64>();
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

/// What the pores hold under pressure and by strain, in absolute amounts, m^D.
fn held<const D: usize>(model: &Model<D>, state: &State) -> f64 {
    let Some(flow) = &model.flow else { return 0.0 };
    let pairs = flow.capacity.iter().zip(&state.pressure);
    let stored: f64 = pairs.map(|(c, p)| (c * p).abs()).sum();
    let strain: f64 = match model.coupling {
        Some(_) => {
            let content = model.content(&state.displacement, &state.walls);
            content.iter().map(|c| c.abs()).sum()
        }
        None => 0.0,
    };
    stored + strain
}
