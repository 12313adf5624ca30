//! Mechanical equilibrium at a given pressure: assembled and solved, or relaxed.

use nalgebra::DMatrix;
use perifrac_solvers::{
    Coordinates, CsrMatrix, CsrView, Demand, LinearSolver, NearNullspace, Outline, Problem,
    SolverSpec, Symmetry, choose, norm2,
};

use super::border::BorderedSystem;
use super::timed::TimedSolver;
use super::{Memory, SchemeCounters, State, StepError, solid_of};
use crate::model::{Model, SolidModel};
use crate::report::Timers;

/// Brings the solid to equilibrium.
pub trait SolidSolver<const D: usize>: Send {
    /// Name for reports.
    fn name(&self) -> &'static str;

    /// Moves displacement and walls of `state` into equilibrium with its pressure at its time.
    ///
    /// # Errors
    /// [`StepError`] if no equilibrium is reached.
    fn equilibrate(&mut self, model: &Model<D>, state: &mut State) -> Result<usize, StepError>;

    /// Moves the state of an explicit step of `dt` seconds towards equilibrium, from where it was before the step, as
    /// far as the error of the step asks for.
    ///
    /// # Errors
    /// As [`SolidSolver::equilibrate`].
    fn follow(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        _dt: f64,
    ) -> Result<usize, StepError> {
        self.equilibrate(model, state)
    }

    /// Forces out of balance, relative to all forces, that it leaves.
    fn accuracy(&self) -> f64;

    /// Goes on from what an accepted state remembers.
    fn recall(&mut self, memory: &Memory);

    /// Enters what the next step needs.
    fn remember(&self, memory: &mut Memory);

    /// Work done so far.
    fn counters(&self) -> SchemeCounters;

    /// Linear solver in use, and why it was chosen.
    fn solver(&self) -> Option<(String, String)> {
        None
    }
}

/// Newton's method on the assembled stiffness: one solve for a linear solid.
pub struct Assembled {
    solver: Box<dyn LinearSolver>,
    chosen: Chosen,
    border: BorderedSystem,
    /// Largest forces so far, Σ of absolutes, N.
    largest: f64,
    newton: u64,
    refilled: Option<u64>,
    /// The stiffness, where the model holds none.
    own: Option<CsrMatrix>,
}

/// Forces out of balance, relative to all forces, that count as equilibrium.
const BALANCED: f64 = 1e-11;
/// The same where not even one solve would change anything.
const ROUNDING: f64 = 1e-17;
/// Forces out of balance beyond which a solution is refused, unless they are all rounding errors.
const ACCEPTED: f64 = 1e-7;
/// Share of the largest force so far that still counts as a scale: rounding errors outlast loads.
const REMEMBERED: f64 = 1e-2;
/// Last correction, relative to the displacement, up to which rounding errors of the forces are no
/// harm: it is the error of the solve before.
const SETTLED: f64 = 1e-6;
const MOST_NEWTON: usize = 6;

impl Assembled {
    /// Chooses and analyses the solver once.
    ///
    /// # Errors
    /// [`StepError`] if the solver is refused.
    pub fn new<const D: usize>(demand: &Demand, solid: &SolidModel<D>) -> Result<Self, StepError> {
        Self::with(demand, solid, None)
    }

    /// The same with a stiffness of its own, for a model that holds none.
    ///
    /// # Errors
    /// [`StepError`] if the matrix is too large, or the solver is refused.
    pub fn apart<const D: usize>(
        demand: &Demand,
        solid: &SolidModel<D>,
    ) -> Result<Self, StepError> {
        let own = solid.assembled()?;
        Self::with(demand, solid, Some(own))
    }

    fn with<const D: usize>(
        demand: &Demand,
        solid: &SolidModel<D>,
        own: Option<CsrMatrix>,
    ) -> Result<Self, StepError> {
        let coordinates = solid.elastic.around.cloud.flat_positions();
        let matrix = own.as_ref().map_or_else(|| solid.matrix(), CsrMatrix::view);
        let problem = Problem {
            solves: demand.solves,
            ..mechanics_problem(solid, matrix, &coordinates)
        };
        let (solver, chosen) = build_solver(&demand.spec, &problem, &solid.timers)?;
        Ok(Assembled {
            solver,
            chosen,
            border: BorderedSystem::default(),
            largest: 0.0,
            newton: 0,
            refilled: None,
            own,
        })
    }

    fn prepare<const D: usize>(&mut self, solid: &SolidModel<D>) -> Result<(), StepError> {
        if self.refilled == Some(solid.refills) {
            return Ok(());
        }
        self.refilled = None;
        let matrix = self
            .own
            .as_ref()
            .map_or_else(|| solid.matrix(), CsrMatrix::view);
        self.solver.refresh(matrix)?;
        let columns = solid
            .plates()
            .into_iter()
            .map(|plate| {
                let mut column = vec![0.0; solid.unknowns()];
                let response = &solid.walls[plate].response;
                response
                    .iter()
                    .for_each(|&(unknown, r)| column[unknown as usize] = r);
                column
            })
            .collect();
        let plate_stiffness = plate_stiffness(solid);
        let solver = &mut self.solver;
        self.border = BorderedSystem::new(columns, plate_stiffness, |column| {
            let mut x = vec![0.0; column.len()];
            solver.solve(matrix, column, &mut x)?;
            Ok(x)
        })?;
        self.refilled = Some(solid.refills);
        Ok(())
    }
}

/// The linear problem of mechanics alone; `coordinates` are those of the points.
pub(super) fn mechanics_problem<'a, const D: usize>(
    solid: &'a SolidModel<D>,
    matrix: CsrView<'a>,
    coordinates: &'a [f64],
) -> Problem<'a> {
    Problem {
        partition: solid.subdomain().partition(),
        contrast: ratio(solid.elastic.lame.iter().map(|lame| lame.mu)),
        volume_stiffness: volume_stiffness(solid),
        coordinates: Some(Coordinates {
            dimension: D,
            values: coordinates,
        }),
        near_nullspace: NearNullspace::RigidModes,
        lattice: solid.lattice.as_ref().map_err(String::as_str),
        ..Problem::new(matrix, Symmetry::PositiveDefinite, D)
    }
}

/// Largest (λ + 2μ)/μ of all points.
pub(super) fn volume_stiffness<const D: usize>(solid: &SolidModel<D>) -> f64 {
    let ratios = solid
        .elastic
        .lame
        .iter()
        .map(|lame| lame.volume_stiffness());
    ratios.fold(1.0, f64::max)
}

/// A linear solver and why it was chosen.
pub(super) type Chosen = (String, String);

/// Builds the solver of a spec for a problem, timed by `timers`; `auto` is chosen by the problem.
///
/// # Errors
/// [`StepError`] if the solver is refused.
pub(super) fn build_solver(
    spec: &SolverSpec,
    problem: &Problem<'_>,
    timers: &Timers,
) -> Result<(Box<dyn LinearSolver>, Chosen), StepError> {
    let (spec, reason) = match spec.name() {
        "auto" => {
            let choice = choose(&Outline::of(problem))?;
            (choice.spec, choice.reason)
        }
        _ => (spec.clone(), "asked for".to_owned()),
    };
    let mut solver = TimedSolver::new(spec.build()?, timers.clone());
    solver.analyse(problem)?;
    Ok((Box::new(solver), (spec.to_string(), reason)))
}

/// Largest over smallest of positive numbers; 1 without any.
pub(super) fn ratio(values: impl Iterator<Item = f64>) -> f64 {
    let start = (f64::INFINITY, 0.0_f64);
    let (low, high) = values
        .filter(|value| *value > 0.0)
        .fold(start, |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if high > 0.0 { high / low } else { 1.0 }
}

/// Stiffness among the plates.
pub(super) fn plate_stiffness<const D: usize>(solid: &SolidModel<D>) -> DMatrix<f64> {
    let plates = solid.plates();
    DMatrix::from_fn(plates.len(), plates.len(), |k, l| {
        solid.wall_stiffness[(plates[k], plates[l])]
    })
}

impl<const D: usize> SolidSolver<D> for Assembled {
    fn name(&self) -> &'static str {
        "newton"
    }

    fn equilibrate(&mut self, model: &Model<D>, state: &mut State) -> Result<usize, StepError> {
        let solid = solid_of(model)?;
        solid.place_walls(state.time, &mut state.walls);
        let mut iterations = 0;
        let (mut last, mut moved) = (f64::INFINITY, f64::INFINITY);
        for pass in 0..=MOST_NEWTON {
            let at = self.imbalance(model, solid, state);
            let (left, scale) = (at.left, at.scale);
            if (left <= BALANCED * scale && pass > 0) || left <= ROUNDING * scale {
                return Ok(iterations);
            }
            if left >= 0.25 * last || pass == MOST_NEWTON {
                let rounding = || solid.rounding(&state.displacement, &state.walls);
                return match left <= ACCEPTED * scale || (moved <= SETTLED && left <= rounding()) {
                    true => Ok(iterations),
                    false => Err(StepError::NoEquilibrium {
                        time: state.time,
                        residual: left / scale,
                        iterations,
                    }),
                };
            }
            last = left;
            self.prepare(solid)?;
            let (inner, change) = self.correct(solid, at, state)?;
            iterations += 1 + inner;
            moved = norm2(&change) / norm2(&state.displacement).max(f64::MIN_POSITIVE);
        }
        Ok(iterations)
    }

    fn accuracy(&self) -> f64 {
        BALANCED
    }

    fn recall(&mut self, memory: &Memory) {
        self.largest = memory.largest_force;
    }

    fn remember(&self, memory: &mut Memory) {
        memory.largest_force = self.largest;
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            mechanics: Some(self.solver.counters().clone()),
            newton_iterations: self.newton,
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.chosen.clone())
    }
}

/// Forces out of balance at a state.
struct Imbalance {
    /// On the points, N.
    force: Vec<f64>,
    /// On the plates, N.
    plates: Vec<f64>,
    /// Σ of absolutes; infinite where it is no number.
    left: f64,
    /// Σ of all forces, N.
    scale: f64,
}

impl Assembled {
    fn imbalance<const D: usize>(
        &mut self,
        model: &Model<D>,
        solid: &SolidModel<D>,
        state: &State,
    ) -> Imbalance {
        let (force, scale) = model.unbalanced(state.time, &state.view());
        let plates = self.plate_forces(model, solid, state);
        let sum: f64 = force.iter().chain(&plates).map(|f| f.abs()).sum();
        let scale = scale + solid.drive(state.time);
        self.largest = self.largest.max(scale);
        Imbalance {
            force,
            plates,
            // NaN must not pass for equilibrium.
            left: if sum.is_nan() { f64::INFINITY } else { sum },
            scale: scale.max(REMEMBERED * self.largest),
        }
    }

    /// Moves a state by what balances its forces; gives the iterations and how far points moved, m.
    fn correct<const D: usize>(
        &mut self,
        solid: &SolidModel<D>,
        at: Imbalance,
        state: &mut State,
    ) -> Result<(usize, Vec<f64>), StepError> {
        let mut change = vec![0.0; at.force.len()];
        let matrix = self
            .own
            .as_ref()
            .map_or_else(|| solid.matrix(), CsrMatrix::view);
        let solved = self.solver.solve(matrix, &at.force, &mut change)?;
        self.newton += 1;
        let moved = self.border.close(&mut change, &at.plates);
        let pairs = state.displacement.iter_mut().zip(&change);
        pairs.for_each(|(u, c)| *u += c);
        for (plate, by) in solid.plates().into_iter().zip(moved) {
            state.walls[plate] += by;
        }
        Ok((solved.iterations, change))
    }

    fn plate_forces<const D: usize>(
        &self,
        model: &Model<D>,
        solid: &SolidModel<D>,
        state: &State,
    ) -> Vec<f64> {
        let plates = solid.plates();
        if plates.is_empty() {
            return Vec::new();
        }
        let pressure = model.coupling.as_ref().map_or(&[][..], |_| &state.pressure);
        let all = solid.wall_residual(state.time, &state.displacement, &state.walls, pressure);
        plates.into_iter().map(|plate| all[plate]).collect()
    }
}
