//! Adaptive dynamic relaxation (Algorithm 2, Eqs. 64–68 and 70): equilibrium without a linear system.
//!
//! Mass is fictitious, as is usual for relaxation: a quarter of the row sums of the stiffness, so
//! that a pseudo-step of one is stable whatever the stiffness. Damping is critical for the local
//! stiffness that the last step showed (Eqs. 65 and 66), smoothed (Eq. 67) and bounded (Eq. 68).

use perifrac_solvers::{SolveError, dot, interrupted, norm2};
use rayon::prelude::*;

use super::solid::SolidSolver;
use super::{Memory, SchemeCounters, State, StepError, solid_of};
use crate::assembly::row_of;
use crate::model::{Coupling, Model, SolidModel};
use crate::plan::{SchemeOptions, SolidMethod};

/// Relaxation of the solid, or single steps of it.
pub struct Relaxation {
    options: SchemeOptions,
    /// Fictitious mass per point, N/m; for the stiffness refilled so many times.
    mass: Option<(u64, Vec<f64>)>,
    /// (stiffness of the plates)⁻¹.
    plates: Option<nalgebra::DMatrix<f64>>,
    stiffness: Vec<f64>,
    iterations: u64,
    products: u64,
    single_steps: u64,
}

/// Share of the mass in excess of what stability without damping needs.
const SAFETY: f64 = 1.2;
/// Largest local stiffness in units of the fictitious mass: keeps damping stable (Eq. 68).
const STIFFEST: f64 = 0.15;
/// Smallest (Eq. 68).
const SOFTEST: f64 = 1e-9;
/// Displacement increment, relative to the largest displacement, below which the local stiffness
/// stays (Eq. 66).
const STILL: f64 = 1e-12;

impl Relaxation {
    /// Relaxation with the plan's options.
    pub fn new(options: SchemeOptions) -> Self {
        Relaxation {
            options,
            mass: None,
            plates: None,
            stiffness: Vec::new(),
            iterations: 0,
            products: 0,
            single_steps: 0,
        }
    }

    fn prepare<const D: usize>(&mut self, solid: &SolidModel<D>) -> Result<(), StepError> {
        if self
            .mass
            .as_ref()
            .is_some_and(|(refills, _)| *refills == solid.refills)
        {
            return Ok(());
        }
        self.mass = Some((solid.refills, fictitious_mass(solid)));
        if self.stiffness.is_empty() {
            self.stiffness = vec![SOFTEST.sqrt(); solid.elastic.points()];
        }
        let plate_stiffness = super::solid::plate_stiffness(solid);
        self.plates = match plate_stiffness.is_empty() {
            true => None,
            false => Some(plate_stiffness.try_inverse().ok_or(StepError::LoosePlate)?),
        };
        Ok(())
    }

    /// Puts the plates where they are in equilibrium with the points.
    fn place_plates<const D: usize>(
        &self,
        solid: &SolidModel<D>,
        coupled: bool,
        state: &mut State,
    ) {
        let Some(inverse) = &self.plates else { return };
        let pressure = if coupled { &state.pressure[..] } else { &[] };
        let left = solid.wall_residual(state.time, &state.displacement, &state.walls, pressure);
        let plates = solid.plates();
        let force = nalgebra::DVector::from_iterator(plates.len(), plates.iter().map(|&k| left[k]));
        for (&plate, by) in plates.iter().zip((inverse * force).iter()) {
            state.walls[plate] += by;
        }
    }

    /// Forces out of balance with the plates in equilibrium.
    fn forces<const D: usize>(
        &mut self,
        model: &Model<D>,
        external: &[f64],
        state: &mut State,
    ) -> Vec<f64> {
        let Some(solid) = &model.solid else {
            return Vec::new();
        };
        let coupled = model.coupling.is_some();
        self.place_plates(solid, coupled, state);
        let mut force = external.to_vec();
        model.subtract_force(solid, &state.view(), &mut force);
        self.products += 1;
        force
    }

    fn relax<const D: usize>(
        &mut self,
        model: &Model<D>,
        external: &[f64],
        bar: f64,
        state: &mut State,
        mut force: Vec<f64>,
    ) -> Result<usize, StepError> {
        let mass = self.mass.take().map(|(_, mass)| mass).unwrap_or_default();
        let mut motion = Motion::new::<D>(&mass, force.len(), self.options.adr_smoothing);
        motion.stiffness.copy_from_slice(&self.stiffness);
        let mut outcome = Err(0.0);
        for iteration in 1..=self.options.adr_iterations {
            if interrupted() {
                break;
            }
            motion.kick::<D>(&force);
            state
                .displacement
                .iter_mut()
                .zip(&motion.velocity)
                .for_each(|(u, v)| *u += v);
            let next = self.forces(model, external, state);
            motion.measure::<D>(&force, &next, &state.displacement);
            motion.settle::<D>(&next);
            force = next;
            let size = norm2(&force);
            if size <= bar {
                outcome = Ok(iteration);
                break;
            }
            if !size.is_finite() {
                outcome = Err(size);
                break;
            }
            outcome = Err(size);
        }
        self.stiffness.copy_from_slice(&motion.stiffness);
        self.mass = Some((solid_of(model)?.refills, mass));
        let done = *outcome.as_ref().unwrap_or(&self.options.adr_iterations);
        self.iterations += done as u64;
        if interrupted() {
            return Err(SolveError::Interrupted.into());
        }
        outcome.map_err(|size| StepError::NotRelaxed {
            time: state.time,
            iterations: done,
            residual: self.options.adr_tolerance * size / bar,
            tolerance: self.options.adr_tolerance,
        })
    }

    /// One step of Algorithm 1 from rest, with the fictitious mass.
    fn single<const D: usize>(&mut self, state: &mut State, force: &[f64]) {
        let Some((_, mass)) = &self.mass else { return };
        for (point, own) in state.displacement.chunks_mut(D).enumerate() {
            for (axis, u) in own.iter_mut().enumerate() {
                *u += 0.5 * force[point * D + axis] / mass[point];
            }
        }
        self.single_steps += 1;
    }
}

/// SAFETY/4 of the largest row sum of |K| per point.
fn fictitious_mass<const D: usize>(solid: &SolidModel<D>) -> Vec<f64> {
    let sum = |row: usize| -> f64 {
        solid.stiffness.data()[row_of(&solid.stiffness, row)]
            .iter()
            .map(|k| k.abs())
            .sum()
    };
    let at = |point: usize| {
        let largest = (0..D).map(|axis| sum(point * D + axis)).fold(0.0, f64::max);
        0.25 * SAFETY * largest
    };
    (0..solid.elastic.points())
        .into_par_iter()
        .map(at)
        .collect()
}

/// Velocities and local stiffness of a relaxation; one pseudo-step is the unit of time.
struct Motion<'a> {
    mass: &'a [f64],
    velocity: Vec<f64>,
    /// Smoothed local stiffness over mass per point.
    stiffness: Vec<f64>,
    smoothing: f64,
}

impl<'a> Motion<'a> {
    fn new<const D: usize>(mass: &'a [f64], unknowns: usize, smoothing: f64) -> Self {
        Motion {
            mass,
            velocity: vec![0.0; unknowns],
            stiffness: vec![0.0; unknowns / D],
            smoothing,
        }
    }

    /// c/m = 2 √(K/m), Eq. 65.
    fn damping(&self, point: usize) -> f64 {
        2.0 * self.stiffness[point].sqrt()
    }

    /// Lines 13 and 14 of Algorithm 2.
    fn kick<const D: usize>(&mut self, force: &[f64]) {
        for point in 0..self.mass.len() {
            let damping = self.damping(point);
            let range = point * D..(point + 1) * D;
            for (own, force) in self.velocity[range.clone()].iter_mut().zip(&force[range]) {
                *own += 0.5 * (force / self.mass[point] - damping * *own);
            }
        }
    }

    /// Lines 17 and 18.
    fn settle<const D: usize>(&mut self, force: &[f64]) {
        self.kick::<D>(force);
    }

    /// Eqs. 66 to 68 from the step that the velocity made.
    fn measure<const D: usize>(&mut self, before: &[f64], after: &[f64], displacement: &[f64]) {
        let largest = displacement.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        for point in 0..self.mass.len() {
            let range = point * D..(point + 1) * D;
            let moved = self.velocity[range.clone()]
                .iter()
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt();
            if moved <= STILL * largest {
                continue;
            }
            let change: f64 = range
                .map(|k| (after[k] - before[k]).powi(2))
                .sum::<f64>()
                .sqrt();
            let own = (change / (moved * self.mass[point])).clamp(SOFTEST, STIFFEST);
            let smooth = &mut self.stiffness[point];
            *smooth = self.smoothing * own + (1.0 - self.smoothing) * *smooth;
        }
    }
}

/// Loads, walls at their prescribed places, and the push of the pressure.
fn external<const D: usize>(
    solid: &SolidModel<D>,
    coupling: Option<&Coupling>,
    state: &State,
) -> Vec<f64> {
    let mut force = vec![0.0; solid.unknowns()];
    solid.loads(state.time, &mut force);
    if let Some(coupling) = coupling {
        coupling.add_pressure_force(solid, &state.pressure, &mut force);
    }
    force
}

impl<const D: usize> SolidSolver<D> for Relaxation {
    fn name(&self) -> &'static str {
        match self.options.solid {
            SolidMethod::Switched => "adr, switched",
            SolidMethod::Adr => "adr",
            SolidMethod::Verlet => "verlet",
        }
    }

    fn equilibrate(&mut self, model: &Model<D>, state: &mut State) -> Result<usize, StepError> {
        let solid = solid_of(model)?;
        self.prepare(solid)?;
        solid.place_walls(state.time, &mut state.walls);
        let external = external(solid, model.coupling.as_ref(), state);
        let force = self.forces(model, &external, state);
        let released = match model.response(&state.view()) {
            Some(response) => solid.crack_force(&response),
            None => Vec::new(),
        };
        let walls: f64 = solid
            .walls
            .iter()
            .zip(&state.walls)
            .map(|(wall, w)| {
                wall.response
                    .iter()
                    .map(|(_, r)| (r * w).powi(2))
                    .sum::<f64>()
            })
            .sum();
        let drive = solid.drive(state.time).powi(2);
        let in_situ = solid.in_situ_force.powi(2) / force.len().max(1) as f64;
        let squares = dot(&external, &external) + dot(&released, &released) + in_situ;
        let bar = self.options.adr_tolerance * (squares + walls + drive).sqrt();
        let size = norm2(&force);
        if self.options.solid == SolidMethod::Verlet
            || (self.options.solid == SolidMethod::Switched && size <= bar)
        {
            self.single::<D>(state, &force);
            return Ok(1);
        }
        if size <= bar {
            return Ok(0);
        }
        self.relax(model, &external, bar, state, force)
    }

    fn accuracy(&self) -> f64 {
        self.options.adr_tolerance
    }

    fn recall(&mut self, memory: &Memory) {
        self.stiffness.clone_from(&memory.local_stiffness);
        if let (true, Some((_, mass))) = (self.stiffness.is_empty(), &self.mass) {
            self.stiffness.resize(mass.len(), SOFTEST.sqrt());
        }
    }

    fn remember(&self, memory: &mut Memory) {
        memory.local_stiffness.clone_from(&self.stiffness);
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            products: self.products,
            relaxation_iterations: self.iterations,
            single_steps: self.single_steps,
            ..SchemeCounters::default()
        }
    }
}
