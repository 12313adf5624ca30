//! Damped motion to equilibrium; one pseudo-step is the unit of time.

use crate::parallel;
use crate::plan::{AdrDamping, SchemeOptions};

/// Largest local stiffness in units of the fictitious mass: keeps damping stable (Eq. 68).
const STIFFEST: f64 = 0.15;
/// Smallest (Eq. 68).
pub(super) const SOFTEST: f64 = 1e-9;
/// Displacement increment, relative to the largest displacement, below which the local stiffness
/// stays (Eq. 66).
const STILL: f64 = 1e-12;

/// Velocities of a relaxation, and what damps them.
pub(super) struct Motion<'a> {
    mass: &'a [f64],
    pub velocity: Vec<f64>,
    damping: Damping,
    /// Rayleigh quotient ω² of the last step.
    quotient: f64,
    started: bool,
}

enum Damping {
    /// Eqs. 65 to 68: smoothed local stiffness over mass per point.
    Local { stiffness: Vec<f64>, smoothing: f64 },
    /// Critical for the Rayleigh quotient ω² = v·Kv/(v·Mv) of the last step: c/m = 2ω at all points.
    Global(f64),
}

impl<'a> Motion<'a> {
    /// At rest, with the local stiffness of the last relaxation.
    pub(crate) fn new(
        mass: &'a [f64],
        unknowns: usize,
        options: &SchemeOptions,
        stiffness: &[f64],
    ) -> Self {
        Motion {
            mass,
            velocity: vec![0.0; unknowns],
            damping: match options.adr_damping {
                AdrDamping::Local => Damping::Local {
                    stiffness: stiffness.to_vec(),
                    smoothing: options.adr_smoothing,
                },
                AdrDamping::Global => Damping::Global(0.0),
            },
            quotient: 0.0,
            started: false,
        }
    }

    /// The local stiffness that the next relaxation starts with, if it is used.
    pub(crate) fn stiffness(self) -> Option<Vec<f64>> {
        match self.damping {
            Damping::Local { stiffness, .. } => Some(stiffness),
            Damping::Global(_) => None,
        }
    }

    /// Velocity for the step from the forces at its start.
    pub(crate) fn kick<const D: usize>(&mut self, force: &[f64]) {
        match &self.damping {
            // Lines 13 and 14 of Algorithm 2.
            Damping::Local { stiffness, .. } => {
                half_kick::<D>((self.mass, stiffness), force, &mut self.velocity);
            }
            // Central differences (Underwood 1983), from rest by half a step.
            Damping::Global(damping) => {
                let (kept, share) = match self.started {
                    true => ((2.0 - damping) / (2.0 + damping), 2.0 / (2.0 + damping)),
                    false => (0.0, 0.5),
                };
                let mass = self.mass;
                parallel::chunks(&mut self.velocity, D * TASK, 1, |task, own| {
                    let force = force[D * TASK * task..].chunks_exact(D);
                    let points = own.chunks_exact_mut(D).zip(force);
                    for ((own, force), mass) in points.zip(&mass[TASK * task..]) {
                        let share = share / mass;
                        for axis in 0..D {
                            own[axis] = kept * own[axis] + share * force[axis];
                        }
                    }
                });
            }
        }
        self.started = true;
    }

    /// What the forces at both ends of the step tell about the stiffness.
    pub(crate) fn measure<const D: usize>(
        &mut self,
        before: &[f64],
        after: &[f64],
        displacement: &[f64],
    ) {
        self.quotient = quotient::<D>(self.mass, &self.velocity, (before, after));
        let (mass, velocity) = (self.mass, &self.velocity);
        match &mut self.damping {
            Damping::Local {
                stiffness,
                smoothing,
            } => {
                let forces = (before, after);
                measure_local::<D>(
                    (mass, stiffness),
                    *smoothing,
                    velocity,
                    forces,
                    displacement,
                );
                half_kick::<D>((mass, stiffness), after, &mut self.velocity);
            }
            Damping::Global(damping) => *damping = 2.0 * self.quotient.clamp(0.0, MOST).sqrt(),
        }
    }

    /// Energy of what is out of balance by `force`, N, if it is as soft as what moved in the last step, J.
    pub(crate) fn energy<const D: usize>(&self, force: &[f64]) -> f64 {
        let points = force.chunks_exact(D).zip(self.mass);
        let square = |force: &[f64]| force.iter().map(|f| f * f).sum::<f64>();
        let pushed: f64 = points.map(|(force, mass)| square(force) / mass).sum();
        0.5 * pushed / self.quotient.max(f64::MIN_POSITIVE)
    }
}

/// v·Kv/(v·Mv) of a step that changed the forces.
fn quotient<const D: usize>(
    mass: &[f64],
    velocity: &[f64],
    (before, after): (&[f64], &[f64]),
) -> f64 {
    let (mut work, mut weight) = (0.0, 0.0);
    for (point, mass) in mass.iter().enumerate() {
        let (mut own, mut square) = (0.0, 0.0);
        for k in point * D..(point + 1) * D {
            own += velocity[k] * (before[k] - after[k]);
            square += velocity[k] * velocity[k];
        }
        work += own;
        weight += mass * square;
    }
    (work / weight.max(f64::MIN_POSITIVE)).max(0.0)
}

/// Largest ω² that damps: beyond, velocities would turn round.
const MOST: f64 = 1.0;
/// Points that one task moves, at least.
const TASK: usize = 4096;

/// c/m = 2 √(K/m), Eq. 65, and half a step with it.
fn half_kick<const D: usize>(
    (mass, stiffness): (&[f64], &[f64]),
    force: &[f64],
    velocity: &mut [f64],
) {
    let points = velocity.chunks_mut(D).zip(force.chunks(D));
    for ((own, force), (mass, stiffness)) in points.zip(mass.iter().zip(stiffness)) {
        let damping = 2.0 * stiffness.sqrt();
        for (own, force) in own.iter_mut().zip(force) {
            *own += 0.5 * (force / mass - damping * *own);
        }
    }
}

/// Eqs. 66 to 68 from the step that the velocity made.
fn measure_local<const D: usize>(
    (mass, stiffness): (&[f64], &mut [f64]),
    smoothing: f64,
    velocity: &[f64],
    (before, after): (&[f64], &[f64]),
    displacement: &[f64],
) {
    let largest = displacement.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    for (point, smooth) in stiffness.iter_mut().enumerate() {
        let range = point * D..(point + 1) * D;
        let squares = velocity[range.clone()].iter().map(|v| v * v);
        let moved = squares.sum::<f64>().sqrt();
        if moved <= STILL * largest {
            continue;
        }
        let change: f64 = range
            .map(|k| (after[k] - before[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        let own = (change / (moved * mass[point])).clamp(SOFTEST, STIFFEST);
        *smooth = smoothing * own + (1.0 - smoothing) * *smooth;
    }
}
