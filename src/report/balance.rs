//! Mass balance: what came in, what went out, what is stored.

use serde::{Deserialize, Serialize};

use super::lenient;
use super::motion::{Moment, Motion};
use super::supply::{Ledger, Supply};

/// Cumulative volumes over a run in m^D; rates in m^D/s for a steady state.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Balance {
    /// Brought in by wells, sources and fluxes, net.
    #[serde(deserialize_with = "lenient")]
    pub injected: f64,
    /// Gone out through sides of prescribed pressure, net.
    #[serde(deserialize_with = "lenient")]
    pub outflow: f64,
    /// Brought in at points of prescribed pressure, net.
    #[serde(deserialize_with = "lenient")]
    pub fixed: f64,
    /// Gain of storage.
    #[serde(deserialize_with = "lenient")]
    pub stored: f64,
    /// Everything that moved, in absolute amounts: the scale of `mass`.
    #[serde(deserialize_with = "lenient")]
    pub turnover: f64,
    /// |injected + fixed − outflow − stored| over the turnover, or over what pressure or strain stored or what
    /// moved within where that is more: in a sealed body nothing goes in or out.
    #[serde(deserialize_with = "lenient")]
    pub mass: f64,
    /// Gain of storage by pressure and by strain.
    #[serde(skip)]
    pub parts: [f64; 2],
    /// Σ |V s Δp| over all points and steps: what moved within.
    #[serde(skip)]
    pub exchanged: f64,
    /// Largest amount that the pores held so far, m^D: the scale of rounding.
    #[serde(skip)]
    pub held: f64,
    /// Largest Σ|f| + Σ|Qᵀp| so far, N.
    #[serde(skip)]
    pub forces: f64,
    /// Balances of a body with inertia.
    #[serde(skip)]
    pub motion: Motion,
    /// Energy of a body without.
    #[serde(skip)]
    pub ledger: Ledger,
    /// Forces out of balance over all forces, Σ|f| + Σ|Qᵀp|, or a hundredth of the largest so far; with
    /// inertia over the largest so far, what accelerates the solid included; with mechanics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<f64>,
    /// Energy of Eq. 73, ½ uᵀKu + ½ pᵀSp, J (per metre of thickness in 2-D); with mechanics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<f64>,
    /// The energy less the work of the loads that act now, J: never grows while they are constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub potential: Option<f64>,
    /// Kinetic energy ½ vᵀMv, J; with inertia.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinetic: Option<f64>,
    /// Work of loads, fluid and walls on the solid since the start, J; with inertia.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work: Option<f64>,
    /// Energy from nowhere over all that was supplied or stored so far. With inertia
    /// |kinetic + elastic energy − work − both at the start| over the largest energy so far; not measured where
    /// rock breaks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_error: Option<f64>,
}

/// Amounts of one step, or rates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Flows {
    /// From wells, sources and fluxes, net.
    pub injected: f64,
    /// From wells, sources and fluxes, each in absolute amount.
    pub gross: f64,
    /// Out through each side.
    pub outflow: Vec<f64>,
    /// In at points of prescribed pressure.
    pub fixed: f64,
    /// The same per prescribed pressure, in the order of the flow model's loads.
    pub held: Vec<f64>,
}

impl Flows {
    /// Adds what came in at a point of the prescribed pressure `load`.
    pub fn hold(&mut self, load: usize, amount: f64) {
        self.fixed += amount;
        self.held.resize(self.held.len().max(load + 1), 0.0);
        self.held[load] += amount;
    }

    /// Adds `weight` times other flows.
    pub fn add(&mut self, weight: f64, other: &Flows) {
        self.injected += weight * other.injected;
        self.gross += weight * other.gross;
        self.fixed += weight * other.fixed;
        let held = self.held.len().max(other.held.len());
        self.held.resize(held, 0.0);
        let pairs = self.held.iter_mut().zip(&other.held);
        pairs.for_each(|(own, o)| *own += weight * o);
        self.outflow.resize(other.outflow.len(), 0.0);
        self.outflow
            .iter_mut()
            .zip(&other.outflow)
            .for_each(|(own, o)| *own += weight * o);
    }
}

impl Balance {
    /// Adds the flows of one step.
    pub fn add(&mut self, flows: &Flows) {
        self.injected += flows.injected;
        self.outflow += flows.outflow.iter().sum::<f64>();
        self.fixed += flows.fixed;
        let through: f64 = flows.outflow.iter().map(|f| f.abs()).sum();
        self.turnover += flows.gross + through + flows.fixed.abs();
    }

    /// Closes the balance with the gain of storage since the start, by pressure and by strain; what `rounding` (m^D) may lose is
    /// not lost.
    pub fn close(&mut self, parts: [f64; 2], rounding: f64) {
        self.parts = parts;
        self.stored = parts[0] + parts[1];
        self.mass = self.moved().error(rounding);
    }

    /// What has moved since the start.
    pub fn moved(&self) -> Moved {
        Moved {
            gap: self.injected + self.fixed - self.outflow - self.stored,
            turnover: self.turnover,
            exchanged: self.exchanged,
            parts: self.parts,
        }
    }

    /// Enters the state of a body with inertia; gives the energy from nowhere over the largest so far.
    pub fn balance_motion(&mut self, now: Moment) -> f64 {
        let found = self.motion.follow(now);
        self.momentum = Some(found.momentum);
        self.kinetic = Some(found.kinetic);
        self.work = Some(found.work);
        self.energy_error = Some(found.energy);
        found.unexplained
    }

    /// Enters the state of a body without inertia; gives the energy from nowhere over all that was supplied
    /// or stored.
    pub fn balance_supply(&mut self, now: Supply) -> f64 {
        let made = self.ledger.follow(now);
        self.energy_error = Some(made);
        made
    }

    /// Enters the forces out of balance and all forces, N. Once loads have ended, what they leave is
    /// compared with a share of what they were.
    pub fn balance_forces(&mut self, unbalanced: f64, forces: f64) {
        self.forces = self.forces.max(forces);
        self.momentum = Some(over(unbalanced, forces.max(REMEMBERED * self.forces)));
    }
}

/// Share of the largest forces so far that still counts as their scale.
const REMEMBERED: f64 = 1e-2;

/// All that a balance holds, but for the last states of motion and ledger, which are those of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BalanceRecord {
    sums: [f64; 6],
    parts: [f64; 2],
    exchanged: f64,
    held: f64,
    forces: f64,
    motion: Motion,
    ledger: Ledger,
    found: [Option<f64>; 6],
}

impl Balance {
    /// What a checkpoint keeps.
    pub fn record(&self) -> BalanceRecord {
        BalanceRecord {
            sums: [
                self.injected,
                self.outflow,
                self.fixed,
                self.stored,
                self.turnover,
                self.mass,
            ],
            parts: self.parts,
            exchanged: self.exchanged,
            held: self.held,
            forces: self.forces,
            motion: self.motion.clone(),
            ledger: self.ledger.clone(),
            found: [
                self.momentum,
                self.energy,
                self.potential,
                self.kinetic,
                self.work,
                self.energy_error,
            ],
        }
    }

    /// The balance of a record, after `measure` has entered the state that it belongs to.
    pub fn restore(record: &BalanceRecord, measure: impl FnOnce(&mut Balance)) -> Self {
        let [injected, outflow, fixed, stored, turnover, mass] = record.sums;
        let mut balance = Balance {
            injected,
            outflow,
            fixed,
            stored,
            turnover,
            mass,
            parts: record.parts,
            exchanged: record.exchanged,
            held: record.held,
            forces: record.forces,
            motion: record.motion.clone(),
            ledger: record.ledger.clone(),
            ..Balance::default()
        };
        measure(&mut balance);
        let [momentum, energy, potential, kinetic, work, energy_error] = record.found;
        Balance {
            momentum,
            energy,
            potential,
            kinetic,
            work,
            energy_error,
            ..balance
        }
    }
}

/// Fluid that moved over some time, m^D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// What came in less what went out and what was stored.
    pub gap: f64,
    /// Everything that moved in or out, in absolute amounts.
    pub turnover: f64,
    /// What moved within.
    pub exchanged: f64,
    /// Gain of storage by pressure and by strain.
    pub parts: [f64; 2],
}

impl Moved {
    /// What moved since `before`.
    pub fn since(&self, before: &Moved) -> Moved {
        Moved {
            gap: self.gap - before.gap,
            turnover: self.turnover - before.turnover,
            exchanged: self.exchanged - before.exchanged,
            parts: std::array::from_fn(|k| self.parts[k] - before.parts[k]),
        }
    }

    /// Share of the fluid that was lost or made beyond `rounding` (m^D).
    pub fn error(&self, rounding: f64) -> f64 {
        // NaN must not pass for rounding.
        let beyond = self.gap.abs() - rounding;
        let gap = if beyond <= 0.0 { 0.0 } else { beyond };
        let whole = self
            .parts
            .iter()
            .fold(self.turnover.max(self.exchanged), |most, own| {
                most.max(own.abs())
            });
        over(gap, whole)
    }
}

/// A part over its whole; zero of nothing.
fn over(part: f64, whole: f64) -> f64 {
    if part <= 0.0 && whole <= 0.0 {
        0.0
    } else {
        part / whole.max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_balance_is_zero_and_a_leak_shows() {
        let flows = Flows {
            injected: 3.0,
            gross: 3.0,
            outflow: vec![1.0, -0.5],
            fixed: 0.5,
            held: vec![0.5],
        };
        let mut balance = Balance::default();
        balance.add(&flows);
        balance.close([3.0, 0.0], 0.0);
        assert!(balance.mass < 1e-15);
        balance.close([2.0, 0.0], 0.0);
        assert!((balance.mass - 1.0 / 5.0).abs() < 1e-15);
    }
}
