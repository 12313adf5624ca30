//! Balances of a body with inertia, from states alone: what the scheme did is not asked.
//!
//! Between two states M Δv = ½ Δt (F₀ + F₁) with F the forces out of balance, and the kinetic and the
//! elastic energy gain the work W of what acts from outside, ½ (g₀ + g₁)·Δu with g = f + Qᵀp and
//! the same at moving walls. Velocity Verlet keeps the first to rounding, and of the second leaves
//! ⅛ Δt² F·M⁻¹F: an error of second order that does not grow with the number of steps (Hairer, Lubich
//! and Wanner 2003, Acta Numerica 12, 399).

use perifrac_solvers::dot;

use crate::model::{Audit, Model, SolidModel};
use crate::schemes::State;

/// Follows a body with inertia.
#[derive(Debug, Clone, Default)]
pub struct Motion {
    last: Option<Moment>,
    /// Kinetic and elastic energy at the start, J.
    start: f64,
    /// Work since then, J.
    work: f64,
    /// Largest forces and largest energy so far: scales that last when the load is gone.
    forces: f64,
    energies: f64,
}

/// What is needed of the state before.
#[derive(Debug, Clone)]
struct Moment {
    time: f64,
    velocity: Vec<f64>,
    displacement: Vec<f64>,
    walls: Vec<f64>,
    /// f + Qᵀp, N.
    external: Vec<f64>,
    /// External less internal forces, N.
    total: Vec<f64>,
    /// What holds the walls against the solid, N.
    held: Vec<f64>,
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
    /// Σ|M Δv/Δt − F| over the largest Σ of forces so far.
    pub momentum: f64,
}

/// Share of the largest forces so far that still counts as a scale at rest: what is left of a load that
/// has ended is judged by it.
const REMEMBERED: f64 = 1e-2;

impl Motion {
    /// Forces out of balance at rest, over all forces.
    pub fn imbalance(&mut self, audit: &Audit) -> f64 {
        self.forces = self.forces.max(audit.scale);
        share(audit.left, audit.scale.max(REMEMBERED * self.forces))
    }

    /// Takes in the next state; nothing without inertia. `audit` is that of the state.
    pub fn follow<const D: usize>(
        &mut self,
        model: &Model<D>,
        state: &State,
        audit: &Audit,
    ) -> Option<Balanced> {
        let solid = model
            .solid
            .as_ref()
            .filter(|solid| !solid.mass.is_empty())?;
        let now = Moment::of(model, solid, state);
        let size = |forces: &[f64]| forces.iter().map(|f| f.abs()).sum::<f64>();
        let outside = size(&now.external) + size(&now.held);
        let internal = now.external.iter().zip(&now.total).map(|(g, f)| g - f);
        let inside: f64 = internal.map(f64::abs).sum();
        self.forces = self.forces.max(outside).max(inside);
        let kinetic = kinetic(solid, &state.velocity);
        let left = match &self.last {
            None => {
                self.start = kinetic + audit.elastic;
                0.0
            }
            Some(before) => {
                self.work += now.work_since(before);
                now.impulse_left(before, solid)
            }
        };
        let gap = kinetic + audit.elastic - self.work - self.start;
        let energies = [kinetic + audit.elastic, self.start.abs(), self.work.abs()];
        self.energies = energies.into_iter().fold(self.energies, f64::max);
        self.last = Some(now);
        Some(Balanced {
            kinetic,
            work: self.work,
            energy: share(gap.abs(), self.energies),
            momentum: share(left, self.forces),
        })
    }
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// ½ vᵀMv, J.
fn kinetic<const D: usize>(solid: &SolidModel<D>, velocity: &[f64]) -> f64 {
    let squares = velocity.chunks(D).map(|v| dot(v, v));
    let energies = solid.mass.iter().zip(squares).map(|(m, square)| m * square);
    0.5 * energies.sum::<f64>()
}

impl Moment {
    fn of<const D: usize>(model: &Model<D>, solid: &SolidModel<D>, state: &State) -> Self {
        let external = model.push(state.time, &state.pressure);
        let mut total = external.clone();
        solid.subtract_internal(&state.displacement, &state.walls, &mut total);
        Moment {
            time: state.time,
            velocity: state.velocity.clone(),
            held: solid.internal_wall_force(&state.displacement, &state.walls, &[]),
            displacement: state.displacement.clone(),
            walls: state.walls.clone(),
            external,
            total,
        }
    }

    /// Work on the solid since `before`, J, by the trapezoidal rule.
    fn work_since(&self, before: &Moment) -> f64 {
        let on_points = (0..self.displacement.len()).map(|i| {
            let moved = self.displacement[i] - before.displacement[i];
            0.5 * (self.external[i] + before.external[i]) * moved
        });
        let on_walls = (0..self.walls.len()).map(|k| {
            let moved = self.walls[k] - before.walls[k];
            0.5 * (self.held[k] + before.held[k]) * moved
        });
        on_points.sum::<f64>() + on_walls.sum::<f64>()
    }

    /// Σ|M Δv/Δt − ½ (F₀ + F₁)| since `before`, N.
    fn impulse_left<const D: usize>(&self, before: &Moment, solid: &SolidModel<D>) -> f64 {
        let dt = self.time - before.time;
        if dt <= 0.0 {
            return 0.0;
        }
        let left = |i: usize| {
            let gained = solid.mass[i / D] * (self.velocity[i] - before.velocity[i]) / dt;
            (gained - 0.5 * (self.total[i] + before.total[i])).abs()
        };
        (0..self.velocity.len()).map(left).sum()
    }
}
