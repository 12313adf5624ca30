//! Balances of a body with inertia, from its states alone: what the scheme did is not asked.
//!
//! Between two states M Δv = ½ Δt (F₀ + F₁) with F the forces out of balance, and the kinetic and the
//! elastic energy gain the work W of what acts from outside, ½ (g₀ + g₁)·Δu with g = f + Qᵀp and
//! the same at moving walls. Velocity Verlet keeps the first to rounding, and leaves ⅛ Δt² Δ(F·M⁻¹F) of
//! the second: an error of second order that does not grow with the number of steps (Hairer, Lubich and
//! Wanner 2003, Acta Numerica 12, 399), but without bounds where steps are unstable.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Follows a body with inertia.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    #[serde(skip)]
    last: Option<Arc<Moment>>,
    /// Whether the energies at the start are known.
    begun: bool,
    /// Kinetic and elastic energy at the start, J.
    start: f64,
    /// Work since then, J.
    work: f64,
    /// Energy that the scheme's own error made since then, J.
    own: f64,
    /// Energy at the last state, J: what a step in which a load appears gives is supplied by the next.
    held: f64,
    /// Largest forces, energy and supply so far: scales that last when the load is gone.
    forces: f64,
    energies: f64,
    supplied: f64,
}

/// What the balances need of a state; all of shape `(n·D,)` but for the walls.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Moment {
    /// Time, s.
    pub time: f64,
    /// Mass of each unknown, kg.
    pub mass: Vec<f64>,
    /// Velocity, m/s.
    pub velocity: Vec<f64>,
    /// Displacement, m.
    pub displacement: Vec<f64>,
    /// f + Qᵀp, N.
    pub external: Vec<f64>,
    /// External less internal forces, N.
    pub total: Vec<f64>,
    /// Place of the walls, m.
    pub walls: Vec<f64>,
    /// What holds the walls against the solid, N.
    pub held: Vec<f64>,
    /// Elastic energy, J.
    pub elastic: f64,
}

/// Balances at a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balanced {
    /// Kinetic energy, J (per metre of thickness in 2-D).
    pub kinetic: f64,
    /// Work of loads, fluid and walls on the solid since the start, J.
    pub work: f64,
    /// |kinetic + elastic − work − that at the start| over the largest energy so far.
    pub energy: f64,
    /// The same without the error of stable steps.
    pub unexplained: f64,
    /// Σ|M Δv/Δt − F| over the largest Σ of forces so far.
    pub momentum: f64,
}

/// Energy over all that was supplied from which steps are unstable. Stable ones leave (ω Δt)²/4 of the
/// energy of a mode, a third or so of the highest one at the share of the limit that is taken; the energy
/// of unstable ones grows with the square of the displacement, the work of loads with itself.
const MOST: f64 = 4.0;

impl Motion {
    /// Takes in the next state.
    pub fn follow(&mut self, now: Moment) -> Balanced {
        let size = |forces: &[f64]| forces.iter().map(|f| f.abs()).sum::<f64>();
        let internal = now.external.iter().zip(&now.total).map(|(g, f)| g - f);
        let inside: f64 = internal.map(f64::abs).sum();
        let outside = size(&now.external) + size(&now.held);
        self.forces = self.forces.max(outside).max(inside);
        let kinetic = now.kinetic();
        let left = match &self.last {
            None => {
                if !std::mem::replace(&mut self.begun, true) {
                    self.start = kinetic + now.elastic;
                }
                0.0
            }
            Some(before) => {
                self.work += now.work_since(before);
                self.own += now.own_error_since(before);
                now.impulse_left(before)
            }
        };
        let gap = kinetic + now.elastic - self.work - self.start;
        self.supplied = self.supplied.max(self.start).max(self.work.abs());
        let stable = self.held <= MOST * self.supplied;
        let own = if stable { self.own } else { 0.0 };
        self.held = kinetic + now.elastic;
        self.energies = self.energies.max(self.held).max(self.supplied);
        self.last = Some(Arc::new(now));
        Balanced {
            kinetic,
            work: self.work,
            energy: share(gap, self.energies),
            unexplained: share(gap - own, self.energies),
            momentum: share(left, self.forces),
        }
    }
}

fn share(part: f64, whole: f64) -> f64 {
    // NaN must not pass for balance.
    if part.abs() <= 0.0 {
        0.0
    } else {
        part.abs() / whole.max(f64::MIN_POSITIVE)
    }
}

impl Moment {
    /// ½ vᵀMv, J.
    fn kinetic(&self) -> f64 {
        let pairs = self.mass.iter().zip(&self.velocity);
        0.5 * pairs.map(|(m, v)| m * v * v).sum::<f64>()
    }

    /// Work on the solid since `before`, J, by the trapezoidal rule.
    fn work_since(&self, before: &Moment) -> f64 {
        let work = |now: [&[f64]; 2], then: [&[f64]; 2]| -> f64 {
            let along = |i: usize| 0.5 * (now[0][i] + then[0][i]) * (now[1][i] - then[1][i]);
            (0..now[0].len()).map(along).sum()
        };
        let on_points = work(
            [&self.external, &self.displacement],
            [&before.external, &before.displacement],
        );
        on_points + work([&self.held, &self.walls], [&before.held, &before.walls])
    }

    /// F·M⁻¹F, N²/kg.
    fn thrust(&self) -> f64 {
        let pairs = self.mass.iter().zip(&self.total);
        pairs.map(|(m, f)| f * f / m).sum()
    }

    fn own_error_since(&self, before: &Moment) -> f64 {
        let dt = self.time - before.time;
        0.125 * dt * dt * (self.thrust() - before.thrust())
    }

    /// Σ|M Δv/Δt − ½ (F₀ + F₁)| since `before`, N.
    fn impulse_left(&self, before: &Moment) -> f64 {
        let dt = self.time - before.time;
        if dt <= 0.0 {
            return 0.0;
        }
        let left = |i: usize| {
            let gained = self.mass[i] * (self.velocity[i] - before.velocity[i]) / dt;
            (gained - 0.5 * (self.total[i] + before.total[i])).abs()
        };
        (0..self.velocity.len()).map(left).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass on a spring of frequency 1, by velocity Verlet; the load is taken from `load`.
    fn oscillate(dt: f64, steps: usize, load: impl Fn(f64) -> f64) -> (Balanced, f64) {
        let (mut u, mut v) = (0.0, 0.0);
        let mut motion = Motion::default();
        let mut worst = 0.0_f64;
        let mut moment = |time: f64, u: f64, v: f64| {
            let now = Moment {
                time,
                mass: vec![1.0],
                velocity: vec![v],
                displacement: vec![u],
                external: vec![load(time)],
                total: vec![load(time) - u],
                elastic: 0.5 * u * u,
                ..Moment::default()
            };
            let found = motion.follow(now);
            worst = worst.max(found.unexplained);
            found
        };
        let mut found = moment(0.0, u, v);
        for step in 0..steps {
            let time = dt * step as f64;
            v += 0.5 * dt * (load(time) - u);
            u += dt * v;
            v += 0.5 * dt * (load(time + dt) - u);
            found = moment(time + dt, u, v);
        }
        (found, worst)
    }

    #[test]
    fn what_verlet_leaves_is_its_own_error_and_nothing_else() {
        let pulse = |time: f64| if time < 3.0 { 1.0 } else { 0.0 };
        let (found, worst) = oscillate(0.1, 1000, pulse);
        assert!(found.momentum < 1e-12 && found.work > 0.1, "{found:?}");
        assert!(worst < 1e-12, "{worst}");
        assert!((1e-6..5e-3).contains(&found.energy), "{found:?}");
    }

    #[test]
    fn an_unstable_step_makes_energy_from_nowhere() {
        let (found, worst) = oscillate(2.1, 60, |_| 1.0);
        assert!(found.energy > 0.9 && worst > 0.5, "{found:?}");
    }
}
