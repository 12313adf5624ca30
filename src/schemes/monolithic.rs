//! Displacement and pressure in one system.
//!
//! With p = c p̂ and the mass balance multiplied by −c the matrix
//!
//!   [ K     −c Qᵀ        ]
//!   [ −c Q  −c² (S + a L) ]
//!
//! is symmetric quasi-definite: LDLᵀ exists for every ordering (Vanderbei 1995). The scale c makes the
//! entries of both blocks of one size, so that residuals mean something for both.

use perifrac_solvers::{
    Coordinates, Demand, LinearSolver, NearNullspace, Problem, SolveError, SolverCounters,
    SolverSpec, Symmetry,
};

use super::border::BorderedSystem;
use super::layout::BlockMatrix;
use super::solid::{Chosen, build_solver, plate_stiffness, ratio, volume_stiffness};
use super::stage::{Stage, Target};
use super::system::{FILTERED, kept_if_same};
use super::{
    Assembled, Increment, Memory, SchemeCounters, SolidSolver, State, StepError, StepReport,
    coupling_of, flow_of, solid_of,
};
use crate::model::{Control, Drive, Model, SolidModel};

/// Stage that solves displacement and pressure together.
pub struct Monolithic {
    solver: Box<dyn LinearSolver>,
    chosen: Chosen,
    block: BlockMatrix,
    border: BorderedSystem,
    coefficient: Option<f64>,
    /// Coefficient at the start of the step, which stays as long as it is wanted.
    kept: Option<f64>,
    /// Work of the start.
    mechanics: Option<SolverCounters>,
    /// Row sums of L: conductance of each point to the sides of prescribed pressure.
    leak: Vec<f64>,
    /// What the wells in the matrix are held at.
    controls: Vec<Control>,
}

/// Residual, relative to its block's terms, that needs no further improvement.
const REFINED: f64 = 1e-11;
const REFINEMENTS: usize = 4;
/// Part of the improvement still wanted that a correction aims at, and the least it aims at. The
/// solver measures both blocks together, which may say little of the one that is wanting.
const FURTHER: f64 = 1e-2;
const LEAST: f64 = 1e-2;
/// Residual beyond which a solution is refused, as for flow alone, unless it is rounding of forces.
const ACCEPTED: f64 = 1e-5;

impl Monolithic {
    /// Builds the pattern and analyses the solver once.
    ///
    /// # Errors
    /// [`StepError`] if the solver is refused.
    pub fn new<const D: usize>(demand: &Demand, model: &Model<D>) -> Result<Self, StepError> {
        let block = BlockMatrix::new(model)?;
        let coordinates = model.cloud.flat_positions();
        let problem = Problem {
            partition: solid_of(model)?.subdomain().partition(),
            solves: demand.solves,
            contrast: ratio(flow_of(model)?.mobility.iter().copied()),
            volume_stiffness: volume_stiffness(solid_of(model)?),
            coordinates: Some(Coordinates {
                dimension: D,
                values: &coordinates,
            }),
            near_nullspace: NearNullspace::RigidModes,
            lattice: (coupling_of(model)?.lattice.as_ref()).map_err(String::as_str),
            schur_diagonal: Some(&block.schur_diagonal),
            ..Problem::new(block.matrix.view(), Symmetry::QuasiDefinite, D + 1)
        };
        let (solver, chosen) = build_solver(&demand.spec, &problem, &model.timers)?;
        Ok(Monolithic {
            solver,
            chosen,
            block,
            border: BorderedSystem::default(),
            coefficient: None,
            kept: None,
            mechanics: None,
            leak: flow_of(model)?.leak(),
            controls: flow_of(model)?.controls.clone(),
        })
    }

    fn build_border<const D: usize>(&mut self, solid: &SolidModel<D>) -> Result<(), StepError> {
        let layout = &self.block.layout;
        let width = D + 1;
        let column = |plate: usize| {
            let wall = &solid.walls[plate];
            let mut column = vec![0.0; self.block.matrix.rows()];
            for &(unknown, response) in &wall.response {
                let unknown = unknown as usize;
                column[unknown / D * width + unknown % D] = response;
            }
            for &(point, content) in &wall.content {
                if !self.block.is_fixed[point as usize] {
                    column[point as usize * width + D] = -layout.scale * content;
                }
            }
            column
        };
        let columns = solid.plates().into_iter().map(column).collect();
        let (solver, view) = (&mut self.solver, self.block.matrix.view());
        self.border = BorderedSystem::new(columns, plate_stiffness(solid), |column| {
            let mut x = vec![0.0; column.len()];
            solver.solve(view, column, &mut x)?;
            Ok(x)
        })?;
        Ok(())
    }

    /// Solves for the increment whose entries at fixed points and prescribed walls are given; a relative
    /// residual of `enough` will do.
    fn improve<const D: usize>(
        &mut self,
        solid: &SolidModel<D>,
        defect: &Defect,
        enough: f64,
        x: &mut Increment,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let (width, scale) = (D + 1, self.block.layout.scale);
        let mut rhs = vec![0.0; self.block.matrix.rows()];
        for (point, flow) in defect.flow.iter().enumerate() {
            let force = &defect.force[point * D..][..D];
            rhs[point * width..][..D].copy_from_slice(force);
            rhs[point * width + D] = -scale * flow;
        }
        let mut solution = vec![0.0; rhs.len()];
        let view = self.block.matrix.view();
        report.iterations += self
            .solver
            .solve_to(view, &rhs, &mut solution, enough)?
            .iterations;
        let moved = self.border.close(&mut solution, &defect.plates);
        for point in 0..defect.flow.len() {
            let own = &solution[point * width..][..width];
            let change = &mut x.displacement[point * D..][..D];
            change.iter_mut().zip(own).for_each(|(u, own)| *u += own);
            x.pressure[point] += scale * own[D];
        }
        for (plate, by) in solid.plates().into_iter().zip(moved) {
            x.walls[plate] += by;
        }
        Ok(())
    }

    /// What the increment `x` leaves of both equations, L from differences.
    fn defect<const D: usize>(
        &self,
        model: &Model<D>,
        known: &Known,
        x: &Increment,
    ) -> Result<Defect, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        let a = self.coefficient.unwrap_or(0.0);
        // A stage begins with an increment that is zero but for what is prescribed. Other processes may have more.
        let shared = solid.subdomain().partition().is_some();
        let moves = |values: &[f64]| shared || values.iter().any(|value| value.abs() != 0.0);
        let mut push = vec![0.0; x.displacement.len()];
        if moves(&x.pressure) {
            coupling.add_pressure_force(solid, &x.pressure, &mut push);
        }
        let scale = |values: &[f64]| values.iter().map(|v| v.abs()).sum::<f64>();
        let driven = scale(&known.force) + scale(&push) + scale(&known.plates);
        let mut force: Vec<f64> = known.force.iter().zip(&push).map(|(f, p)| f + p).collect();
        let mut content = vec![0.0; x.pressure.len()];
        let mut exchanged = vec![0.0; x.pressure.len()];
        let mut held = vec![0.0; x.pressure.len()];
        if moves(&x.displacement) || moves(&x.walls) {
            solid.subtract_internal(&x.displacement, &x.walls, &mut force);
            content = model.content(&x.displacement, &x.walls);
        }
        if moves(&x.pressure) {
            flow.subtract_exchange(&x.pressure, &mut exchanged);
            flow.subtract_stabilisation(&x.pressure, &mut held);
        }
        let mut left = vec![0.0; x.pressure.len()];
        let mut flow_scale = 0.0;
        for i in 0..left.len() {
            let stored = (flow.capacity[i] + a * self.leak[i]) * x.pressure[i];
            flow_scale += known.flow[i].abs() + content[i].abs() + stored.abs();
            if !self.block.is_fixed[i] {
                left[i] = known.flow[i] - stored - content[i] + a * exchanged[i] + held[i];
            }
        }
        let plates = plate_forces(solid, known, x);
        let unbalanced = scale(&force) + scale(&plates);
        let lost = share(scale(&left), flow_scale);
        Ok(Defect {
            relative: share(unbalanced, driven).max(lost),
            unbalanced,
            lost,
            plates,
            force,
            flow: left,
        })
    }

    fn run<const D: usize>(
        &mut self,
        model: &Model<D>,
        known: &Known,
        mut x: Increment,
        report: &mut StepReport,
    ) -> Result<Increment, StepError> {
        let solid = solid_of(model)?;
        let mut defect = self.defect(model, known, &x)?;
        if defect.relative <= 0.0 {
            return Ok(x);
        }
        let mut last = f64::INFINITY;
        for _ in 0..=REFINEMENTS {
            let mut candidate = x.clone();
            let enough = (FURTHER * REFINED / last).min(LEAST);
            self.improve(solid, &defect, enough, &mut candidate, report)?;
            let after = self.defect(model, known, &candidate)?;
            if after.relative >= 0.5 * last {
                break;
            }
            (x, last, defect) = (candidate, after.relative, after);
            if last <= REFINED {
                break;
            }
        }
        let rounding = || solid.rounding(&x.displacement, &x.walls);
        if last > ACCEPTED && !(defect.lost <= ACCEPTED && defect.unbalanced <= rounding()) {
            return Err(StepError::Solve(SolveError::Inaccurate {
                residual: last,
                bar: ACCEPTED,
                refinements: REFINEMENTS,
                advice: "the permeability contrast or the contrast of stiffness and storage is beyond \
                         what double precision resolves; reduce it, or use --scheme staggered",
            }));
        }
        Ok(x)
    }
}

/// A residual over its scale; infinite where it is not a number.
fn share(left: f64, whole: f64) -> f64 {
    let share = left / whole.max(f64::MIN_POSITIVE);
    if share.is_nan() { f64::INFINITY } else { share }
}

/// Right-hand sides of a stage.
struct Known {
    /// Forces out of balance at the base, N.
    force: Vec<f64>,
    /// Content to be found room for, m^D.
    flow: Vec<f64>,
    /// Forces on the plates at the base, N.
    plates: Vec<f64>,
}

/// What is left of a stage's equations.
struct Defect {
    force: Vec<f64>,
    flow: Vec<f64>,
    plates: Vec<f64>,
    /// The larger of both parts over their scales.
    relative: f64,
    /// Forces out of balance, Σ of absolutes, N.
    unbalanced: f64,
    /// Fluid out of balance over its scale.
    lost: f64,
}

fn plate_forces<const D: usize>(solid: &SolidModel<D>, known: &Known, x: &Increment) -> Vec<f64> {
    let plates = solid.plates();
    if plates.is_empty() {
        return Vec::new();
    }
    let gained = solid.internal_wall_force(&x.displacement, &x.walls, &x.pressure);
    plates
        .into_iter()
        .zip(&known.plates)
        .map(|(plate, own)| own - gained[plate])
        .collect()
}

impl<const D: usize> Stage<D> for Monolithic {
    fn name(&self) -> &'static str {
        "monolithic"
    }

    fn prepare(&mut self, model: &Model<D>, a: f64) -> Result<(), StepError> {
        let flow = flow_of(model)?;
        if self.controls != flow.controls {
            self.controls.clone_from(&flow.controls);
            (self.coefficient, self.leak) = (None, flow.leak());
        }
        let a = kept_if_same(self.kept, a);
        let is_current = |own: f64| own.to_bits() == a.to_bits();
        if self.coefficient.is_some_and(is_current) {
            return Ok(());
        }
        self.coefficient = None;
        self.solver.begin_anew();
        model.timers.time("assembly", || self.block.fill(flow, a));
        self.solver.refresh(self.block.matrix.view())?;
        self.build_border(solid_of(model)?)?;
        self.coefficient = Some(a);
        Ok(())
    }

    fn solve(
        &mut self,
        model: &Model<D>,
        target: Target<'_>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Increment, StepError> {
        let (flow, solid) = (flow_of(model)?, solid_of(model)?);
        let base = target.base;
        let (force, _) = model.unbalanced(target.time, &base.view());
        let all = solid.wall_residual(target.time, &base.displacement, &base.walls, &base.pressure);
        let known = Known {
            force,
            flow: rhs,
            plates: solid.plates().into_iter().map(|plate| all[plate]).collect(),
        };
        // What is prescribed moves first; the rest follows.
        let mut x = Increment {
            pressure: vec![0.0; flow.points()],
            displacement: vec![0.0; solid.unknowns()],
            walls: vec![0.0; solid.walls.len()],
        };
        flow.fix(target.time, &base.pressure, &mut x.pressure);
        for (k, wall) in solid.walls.iter().enumerate() {
            if let Drive::Displacement(load) = &wall.drive {
                x.walls[k] = load.at(target.time) - base.walls[k];
            }
        }
        self.run(model, &known, x, report)
    }

    fn filter(
        &mut self,
        model: &Model<D>,
        rhs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        let solid = solid_of(model)?;
        let mut x = Increment {
            pressure: vec![0.0; rhs.len()],
            displacement: vec![0.0; solid.unknowns()],
            walls: vec![0.0; solid.walls.len()],
        };
        let mut flow = rhs;
        flow.iter_mut()
            .zip(&self.block.is_fixed)
            .filter(|(_, f)| **f)
            .for_each(|(r, _)| *r = 0.0);
        let defect = Defect {
            force: vec![0.0; solid.unknowns()],
            flow,
            plates: vec![0.0; solid.plates().len()],
            relative: 1.0,
            unbalanced: 0.0,
            lost: 0.0,
        };
        self.improve(solid, &defect, FILTERED, &mut x, report)?;
        Ok(x.pressure)
    }

    fn recall(&mut self, memory: &Memory) {
        self.kept = memory.coefficient;
    }

    fn remember(&self, memory: &mut Memory) {
        memory.coefficient = self.coefficient;
    }

    /// One stage in which nothing flows.
    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        Stage::<D>::prepare(self, model, 0.0)?;
        let base = state.clone();
        let (time, dt) = (state.time, 0.0);
        let target = Target {
            base: &base,
            time,
            dt,
            slot: 0,
        };
        let rhs = vec![0.0; state.pressure.len()];
        let step = Stage::<D>::solve(self, model, target, rhs, &mut StepReport::default())?;
        state.set_sum(&base, 1.0, &step);
        Ok(())
    }

    /// Displacement alone, once, by the solver that suits it best.
    fn equilibrate(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        let once = Demand {
            spec: SolverSpec::default(),
            solves: 1,
        };
        let mut solid = Assembled::new(&once, solid_of(model)?)?;
        solid.equilibrate(model, state)?;
        let work = SolidSolver::<D>::counters(&solid).mechanics;
        // Loads that begin later leave the rock at rest.
        self.mechanics = work.filter(|work| work.solves > 0);
        Ok(())
    }

    fn counters(&self) -> SchemeCounters {
        SchemeCounters {
            mechanics: self.mechanics.clone(),
            solver: self.solver.counters().clone(),
            ..SchemeCounters::default()
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Some(self.chosen.clone())
    }
}
