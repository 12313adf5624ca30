//! The energy of a body without inertia, and what supplies it, from its states alone.
//!
//! Between two states in equilibrium the energy of Eq. 73 gains the work ½ (f₀ + f₁)·Δu of the loads, the
//! same at moving walls, and what the fluid brings: ∫ pᵀ(q − L p) dt, of which Darcy's law dissipates a part
//! and rock that breaks another. So it never gains more than loads, walls and the inflow supply; what goes
//! beyond is made by the scheme.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// What the audit of energy needs of a state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Supply {
    /// Time, s.
    pub time: f64,
    /// Energy of Eq. 73 with what damage took, J.
    pub energy: f64,
    /// Loads on the displacement, N, shape `(n·D,)`.
    pub loads: Vec<f64>,
    /// Displacement, m, shape `(n·D,)`.
    pub displacement: Vec<f64>,
    /// Forces that hold the walls, N, and their places, m.
    pub held: Vec<f64>,
    /// Places of the walls, m.
    pub walls: Vec<f64>,
    /// Power of what flows in from sources and sides, W.
    pub inflow: f64,
    /// At points of prescribed pressure: the pressure (Pa), the content (m^D) and the rate q − L p (m^D/s).
    pub fixed: Vec<[f64; 3]>,
}

/// Follows the energy of a body without inertia.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    #[serde(skip)]
    last: Option<Arc<Supply>>,
    /// Energy from nowhere so far, J.
    made: f64,
    /// All that was supplied so far, in absolute amounts, J.
    supplied: f64,
    /// Largest energy so far, J.
    largest: f64,
}

impl Ledger {
    /// Takes in the next state; gives the energy from nowhere over all that was supplied or stored.
    pub fn follow(&mut self, now: Supply) -> f64 {
        self.largest = self.largest.max(now.energy.abs());
        if let Some(before) = &self.last {
            let (supplied, amount) = now.supplied_since(before);
            let beyond = now.energy - before.energy - supplied;
            // NaN must not pass for balance.
            self.made += if beyond < 0.0 { 0.0 } else { beyond };
            self.supplied += amount;
        }
        self.last = Some(Arc::new(now));
        let whole = self.supplied.max(self.largest);
        match self.made <= 0.0 {
            true => 0.0,
            false => self.made / whole.max(f64::MIN_POSITIVE),
        }
    }
}

impl Supply {
    /// Most that may have been supplied since `before`, J, and the sum of its parts in absolute amounts.
    fn supplied_since(&self, before: &Supply) -> (f64, f64) {
        let loads = work(
            [&before.loads, &self.loads],
            [&before.displacement, &self.displacement],
        );
        let walls = work([&before.held, &self.held], [&before.walls, &self.walls]);
        let dt = self.time - before.time;
        let inflow = dt * self.inflow.max(before.inflow);
        let fixed: f64 = self.fixed.iter().zip(&before.fixed).map(fixed(dt)).sum();
        let parts = [loads, walls, inflow, fixed];
        (
            parts.iter().sum(),
            parts.iter().map(|part| part.abs()).sum(),
        )
    }
}

/// Work along the ways by the trapezoidal rule, J.
fn work(forces: [&[f64]; 2], places: [&[f64]; 2]) -> f64 {
    let along = |i: usize| 0.5 * (forces[0][i] + forces[1][i]) * (places[1][i] - places[0][i]);
    (0..forces[0].len()).map(along).sum()
}

/// What comes in at a point of prescribed pressure in `dt` seconds: what its pores gain and pass on.
fn fixed(dt: f64) -> impl Fn((&[f64; 3], &[f64; 3])) -> f64 {
    move |(now, before)| {
        let gained = 0.5 * (now[0] + before[0]) * (now[1] - before[1]);
        let passed = |state: &[f64; 3]| -state[0] * state[2];
        gained + dt * passed(now).max(passed(before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of stiffness 1 that a load follows.
    fn spring(time: f64, energy: f64) -> Supply {
        Supply {
            time,
            energy,
            loads: vec![time],
            displacement: vec![time],
            ..Supply::default()
        }
    }

    #[test]
    fn work_of_a_load_is_no_energy_from_nowhere_and_more_than_it_is() {
        let mut ledger = Ledger::default();
        for k in 0..=10 {
            let time = 0.1 * f64::from(k);
            assert!(ledger.follow(spring(time, 0.5 * time * time)) < 1e-14);
        }
        assert!((ledger.follow(spring(1.0, 0.75)) - 0.25 / 0.75).abs() < 1e-12);
    }

    #[test]
    fn what_is_dissipated_is_not_missed_and_nan_does_not_pass() {
        let mut ledger = Ledger::default();
        ledger.follow(spring(0.0, 1.0));
        assert!(ledger.follow(spring(0.0, 0.5)) <= 0.0);
        assert!(ledger.follow(spring(0.0, f64::NAN)).is_nan());
    }
}
