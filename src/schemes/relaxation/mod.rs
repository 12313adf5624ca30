//! Adaptive dynamic relaxation (Algorithm 2, Eqs. 64–68 and 70): equilibrium without a linear system.
//!
//! Mass is fictitious, as is usual for relaxation, so that a pseudo-step of one is stable whatever the stiffness.
//! Damping is critical for the mode that moves, by its Rayleigh quotient (Underwood 1983), or as printed for the local
//! stiffness that the last step showed (Eqs. 65 and 66), smoothed (Eq. 67) and bounded (Eq. 68).

mod mass;
mod motion;

use perifrac_solvers::{SolveError, dot, interrupted, norm2};

use super::memory::Rates;
use super::solid::SolidSolver;
use super::{Memory, SchemeCounters, State, StepError, solid_of};
use crate::model::{Coupling, Model, SolidModel};
use crate::plan::{SchemeOptions, SolidMethod};
use mass::fictitious_mass;
use motion::{Motion, SOFTEST};

/// Relaxation of the solid, or single steps of it.
pub struct Relaxation {
    options: SchemeOptions,
    /// Fictitious mass per point, N/m; for the stiffness refilled so many times.
    mass: Option<(u64, Vec<f64>)>,
    /// (stiffness of the plates)⁻¹.
    plates: Option<nalgebra::DMatrix<f64>>,
    stiffness: Vec<f64>,
    followed: Rates,
    iterations: u64,
    products: u64,
    single_steps: u64,
}

/// Energy of what is out of balance, over that of what the solid moved in a step, at which relaxation ends where it
/// follows explicit steps: strain lags by a hundredth of a step, where the pressure lags by half of one.
///
/// Terzaghi's column at 0.25 m takes 27,300 iterations with it for an error of the pressure of 5.0e-4, and 85,700 for the
/// same with forces balanced to 1e-6. At 1e-3 it takes 21,500 for 5.3e-4, but at 0.5 m energy is lost in the first
/// steps (3.3e-2); at 1e-1 the strain that lags feeds on itself.
const LEFT: f64 = 1e-4;
/// Iterations between two looks at that.
const LOOK: usize = 4;

impl Relaxation {
    /// Relaxation with the plan's options.
    pub fn new(options: SchemeOptions) -> Self {
        Relaxation {
            options,
            mass: None,
            plates: None,
            stiffness: Vec::new(),
            followed: Rates::default(),
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
            false => Some(
                plate_stiffness
                    .try_inverse()
                    .ok_or(StepError::UnsupportedPlate)?,
            ),
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

    /// Forces out of balance with the plates in equilibrium, into `force`.
    fn forces<const D: usize>(
        &mut self,
        model: &Model<D>,
        external: &[f64],
        state: &mut State,
        force: &mut Vec<f64>,
    ) -> Result<(), StepError> {
        let solid = solid_of(model)?;
        self.place_plates(solid, model.coupling.is_some(), state);
        force.clear();
        force.extend_from_slice(external);
        model.subtract_force(solid, &state.view(), force);
        self.products += 1;
        Ok(())
    }

    fn relax<const D: usize>(
        &mut self,
        model: &Model<D>,
        external: &[f64],
        bar: &Bar<'_>,
        state: &mut State,
        mut force: Vec<f64>,
    ) -> Result<usize, StepError> {
        let mass = self.mass.take();
        let own = mass.as_ref().map_or(&[][..], |(_, own)| own);
        let mut motion = Motion::new(own, force.len(), &self.options, &self.stiffness);
        let mut next = Vec::with_capacity(force.len());
        let (mut done, mut size) = (0, norm2(&force));
        let mut settled = size <= bar.size;
        while done < self.options.adr_iterations && !settled && size.is_finite() && !interrupted() {
            done += 1;
            motion.kick::<D>(&force);
            let moved = state.displacement.iter_mut().zip(&motion.velocity);
            moved.for_each(|(u, v)| *u += v);
            self.forces(model, external, state, &mut next)?;
            motion.measure::<D>(&force, &next, &state.displacement);
            std::mem::swap(&mut force, &mut next);
            size = norm2(&force);
            let looks = done.is_multiple_of(LOOK);
            settled = size <= bar.size || looks && bar.is_settled::<D>(&motion, state, &force);
        }
        if let Some(stiffness) = motion.stiffness() {
            self.stiffness = stiffness;
        }
        self.mass = mass;
        self.iterations += done as u64;
        if interrupted() {
            return Err(SolveError::Interrupted.into());
        }
        match settled {
            true => Ok(done),
            false => Err(StepError::RelaxationNotConverged {
                time: state.time,
                iterations: done,
                residual: size / bar.forces,
                tolerance: bar.size / bar.forces,
            }),
        }
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

    /// Size of all forces on the solid, N: what imbalances are relative to (Eq. 70).
    fn scale<const D: usize>(
        model: &Model<D>,
        solid: &SolidModel<D>,
        external: &[f64],
        state: &State,
    ) -> f64 {
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
        let in_situ = solid.in_situ_force.powi(2) / external.len().max(1) as f64;
        let squares = dot(external, external) + dot(&released, &released) + in_situ;
        (squares + walls + drive).sqrt()
    }

    /// Puts the solid where it will be if it goes on as in the last step, where forces are smaller there.
    fn guess<const D: usize>(
        &mut self,
        model: &Model<D>,
        external: &[f64],
        (state, dt): (&mut State, f64),
        force: &mut Vec<f64>,
    ) -> Result<(), StepError> {
        if self.followed.dt <= 0.0 || self.followed.displacement.len() != force.len() {
            return Ok(());
        }
        let before = (state.displacement.clone(), state.walls.clone());
        let moved = state
            .displacement
            .iter_mut()
            .zip(&self.followed.displacement);
        moved.for_each(|(u, rate)| *u += dt * rate);
        let mut ahead = Vec::with_capacity(force.len());
        self.forces(model, external, state, &mut ahead)?;
        match norm2(&ahead) < norm2(force) {
            true => *force = ahead,
            false => (state.displacement, state.walls) = before,
        }
        Ok(())
    }
}

/// Where relaxation ends.
struct Bar<'a> {
    /// Forces out of balance, N.
    size: f64,
    /// All forces, N.
    forces: f64,
    /// Displacement before a step, m, and the forces that the step threw out of balance there, N.
    step: Option<(&'a [f64], &'a [f64])>,
}

impl Bar<'_> {
    /// Whether little is left of what a step threw out of balance.
    fn is_settled<const D: usize>(
        &self,
        motion: &Motion<'_>,
        state: &State,
        force: &[f64],
    ) -> bool {
        let Some((before, thrown)) = self.step else {
            return false;
        };
        let mut work = 0.0;
        for (k, u) in state.displacement.iter().enumerate() {
            work += (u - before[k]) * (thrown[k] - force[k]);
        }
        motion.energy::<D>(force) <= LEFT * 0.5 * work
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
        let mut force = Vec::with_capacity(external.len());
        self.forces(model, &external, state, &mut force)?;
        let forces = Self::scale(model, solid, &external, state);
        let bar = Bar {
            size: self.options.adr_tolerance * forces,
            forces,
            step: None,
        };
        let size = norm2(&force);
        if self.options.solid == SolidMethod::Verlet
            || (self.options.solid == SolidMethod::Switched && size <= bar.size)
        {
            self.single::<D>(state, &force);
            return Ok(1);
        }
        if size <= bar.size {
            return Ok(0);
        }
        self.relax(model, &external, &bar, state, force)
    }

    fn follow(&mut self, model: &Model<D>, state: &mut State, dt: f64) -> Result<usize, StepError> {
        if self.options.solid == SolidMethod::Verlet || !self.options.adr_follows {
            return self.equilibrate(model, state);
        }
        let solid = solid_of(model)?;
        self.prepare(solid)?;
        let before = state.displacement.clone();
        solid.place_walls(state.time, &mut state.walls);
        let external = external(solid, model.coupling.as_ref(), state);
        let mut force = Vec::with_capacity(external.len());
        self.forces(model, &external, state, &mut force)?;
        let forces = Self::scale(model, solid, &external, state);
        let thrown = force.clone();
        let bar = Bar {
            size: self.options.adr_tolerance * forces,
            forces,
            step: Some((&before, &thrown)),
        };
        self.guess(model, &external, (state, dt), &mut force)?;
        let iterations = self.relax(model, &external, &bar, state, force)?;
        let moved = state.displacement.iter().zip(&before);
        self.followed = Rates {
            dt,
            displacement: moved.map(|(new, old)| (new - old) / dt).collect(),
            pressure: Vec::new(),
        };
        Ok(iterations)
    }

    fn accuracy(&self) -> f64 {
        self.options.adr_tolerance
    }

    fn recall(&mut self, memory: &Memory) {
        self.followed.clone_from(&memory.followed);
        self.stiffness.clone_from(&memory.local_stiffness);
        if let (true, Some((_, mass))) = (self.stiffness.is_empty(), &self.mass) {
            self.stiffness.resize(mass.len(), SOFTEST.sqrt());
        }
    }

    fn remember(&self, memory: &mut Memory) {
        memory.followed.clone_from(&self.followed);
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
