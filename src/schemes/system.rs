//! The implicit matrix S + a L of flow, factored anew only when `a` or L changes.

use perifrac_solvers::{
    Coordinates, Demand, LinearSolver, Problem, SolveError, SolverCounters, Symmetry, multiply,
};

use crate::model::{Control, FlowModel};

use super::solid::{Chosen, build_solver, ratio};
use super::{Memory, StepError, StepReport};

/// Solver of (S + a L) x = b with rows of fixed points replaced by the identity. S is the capacity of
/// the points, with what a fixed-stress split adds to it.
pub struct ImplicitSystem {
    solver: Box<dyn LinearSolver>,
    chosen: Chosen,
    values: Vec<f64>,
    coefficient: Option<f64>,
    /// What the wells in the matrix are held at.
    controls: Vec<Control>,
    /// Coefficient at the start of the step, which stays as long as it is wanted.
    kept: Option<f64>,
    /// Whether preconditioners may lag behind until [`ImplicitSystem::begin_anew`].
    lags: bool,
    /// What the diagonal stores, shape `(n,)`, m^D/Pa; zero for a steady state.
    storage: Vec<f64>,
    /// Whether the stabilising storage is part of the matrix.
    stabilised: bool,
    /// Row sums of L: conductance of each point to the sides of prescribed pressure.
    leak: Vec<f64>,
    /// What grounding added to each diagonal.
    ground: Vec<f64>,
    is_fixed: Vec<bool>,
    any_fixed: bool,
    lift: Vec<f64>,
    defect: Vec<f64>,
    correction: Vec<f64>,
    held: Vec<f64>,
}

/// Residual, relative to the right-hand side, that needs no further improvement.
const REFINED: f64 = 1e-13;
const REFINEMENTS: usize = 4;
/// Part of the improvement still wanted that a correction aims at, and the least it aims at.
const FURTHER: f64 = 0.1;
const LEAST: f64 = 0.1;
/// Residual of an error estimate: a step changes by less than a thousandth of this.
pub(super) const FILTERED: f64 = 1e-4;
/// Relative change of the coefficient that keeps a factor.
const SAME: f64 = 1e-12;
/// Residual, relative to the right-hand side, beyond which a solution is refused. At contrasts of 1e12
/// the resolution of the pressure itself leaves 1e-6; the mass balance of the report tells.
const ACCEPTED: f64 = 1e-5;

/// The coefficient of the step before where that is as good as the wanted one: its factor can stay.
pub(super) fn kept_if_same(kept: Option<f64>, wanted: f64) -> f64 {
    let same = |old: &f64| (old - wanted).abs() <= SAME * wanted.abs();
    kept.filter(same).unwrap_or(wanted)
}

impl ImplicitSystem {
    /// Chooses and analyses the solver once.
    ///
    /// # Errors
    /// [`StepError`] if the solver is refused.
    pub fn new<const D: usize>(demand: &Demand, flow: &FlowModel<D>) -> Result<Self, StepError> {
        let coordinates = flow.operator.neighbourhood().cloud.flat_positions();
        let values = vec![0.0; flow.pattern.nonzeros()];
        let problem = Problem {
            partition: flow.subdomain().partition(),
            solves: demand.solves,
            contrast: ratio(flow.mobility.iter().copied()),
            lattice: (*flow.lattice).as_ref().map_err(String::as_str),
            coordinates: Some(Coordinates {
                dimension: D,
                values: &coordinates,
            }),
            ..Problem::new(flow.view(&values), Symmetry::PositiveDefinite, 1)
        };
        let (solver, chosen) = build_solver(&demand.spec, &problem, &flow.timers)?;
        Ok(ImplicitSystem {
            solver,
            chosen,
            values,
            coefficient: None,
            controls: flow.controls.clone(),
            kept: None,
            lags: false,
            storage: vec![0.0; flow.points()],
            stabilised: false,
            leak: flow.leak(),
            ground: vec![0.0; flow.points()],
            is_fixed: flow.fixed_mask(),
            any_fixed: !flow.fixed.is_empty(),
            lift: Vec::new(),
            defect: Vec::new(),
            correction: Vec::new(),
            held: Vec::new(),
        })
    }

    /// The solver in use and why.
    pub fn chosen(&self) -> &Chosen {
        &self.chosen
    }

    /// Work done.
    pub fn counters(&self) -> &SolverCounters {
        self.solver.counters()
    }

    /// Makes the next [`ImplicitSystem::prepare`] fill the matrix anew, because L, the storage or the
    /// conductance to the sides have changed.
    pub fn forget<const D: usize>(&mut self, flow: &FlowModel<D>) {
        (self.coefficient, self.kept) = (None, None);
        self.leak = flow.leak();
    }

    /// Lets preconditioners lag behind the matrix until the next call, which a step begins with: what it
    /// finds must not depend on the steps before.
    pub fn begin_anew(&mut self) {
        self.lags = true;
        self.solver.begin_anew();
    }

    /// Goes on from an accepted state.
    pub fn recall(&mut self, memory: &Memory) {
        self.kept = memory.coefficient;
    }

    /// Enters what the next step needs.
    pub fn remember(&self, memory: &mut Memory) {
        memory.coefficient = self.coefficient;
    }

    /// Makes the matrix S + a L the current one for `storage` (shape `(n,)`, m^D/Pa); `ground` rows get
    /// their own diagonal once more. As long as `a` is the same, so must be the storage.
    ///
    /// # Errors
    /// [`SolveError`] if it cannot be factored.
    pub fn prepare<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        storage: &[f64],
        a: f64,
        ground: &[usize],
    ) -> Result<(), SolveError> {
        self.follow_wells(flow);
        let a = kept_if_same(self.kept, a);
        let is_current = |own: f64| own.to_bits() == a.to_bits();
        if ground.is_empty() && self.coefficient.is_some_and(is_current) {
            return Ok(());
        }
        self.coefficient = None;
        if !self.lags {
            self.solver.begin_anew();
        }
        (flow.timers.clone()).time("assembly", || self.fill(flow, storage, a, ground));
        self.solver.refresh(flow.view(&self.values))?;
        self.coefficient = Some(a);
        Ok(())
    }

    /// Fills the matrix anew where wells are held at something else than in it.
    fn follow_wells<const D: usize>(&mut self, flow: &FlowModel<D>) {
        if self.controls != flow.controls {
            self.controls.clone_from(&flow.controls);
            self.coefficient = None;
            self.leak = flow.leak();
        }
    }

    /// Sets the values to those of S + a L.
    fn fill<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        storage: &[f64],
        a: f64,
        ground: &[usize],
    ) {
        self.values
            .iter_mut()
            .zip(&flow.conductance)
            .for_each(|(v, l)| *v = a * l);
        // A steady state stores nothing, so nothing there is stabilised.
        self.stabilised = !flow.stabilisation.is_empty() && storage.iter().any(|own| *own > 0.0);
        if self.stabilised {
            let pairs = self.values.iter_mut().zip(&flow.stabilisation);
            pairs.for_each(|(v, s)| *v += s);
        }
        for (row, diagonal) in flow.pattern.diagonals() {
            self.values[diagonal] += storage[row];
        }
        self.storage.copy_from_slice(storage);
        self.ground.fill(0.0);
        let grounded = ground.iter().filter(|row| flow.subdomain().owns(**row));
        for &row in grounded {
            let diagonal = flow.pattern.diagonal(row);
            self.ground[row] = self.values[diagonal];
            self.values[diagonal] *= 2.0;
        }
        flow.subdomain().complete(&mut self.ground, 1);
        self.fix_rows(flow);
    }

    /// Replaces rows and columns of fixed points, keeping their diagonal as the scale.
    fn fix_rows<const D: usize>(&mut self, flow: &FlowModel<D>) {
        if !self.any_fixed {
            return;
        }
        for row in 0..flow.points() {
            for k in flow.pattern.row(row) {
                let column = flow.pattern.columns[k] as usize;
                if column != row && (self.is_fixed[row] || self.is_fixed[column]) {
                    self.values[k] = 0.0;
                }
            }
        }
    }

    /// Solves for `x`; entries of `x` at fixed points are given, the others are the guess.
    ///
    /// The solver has verified its own residual; here it is evaluated once more with differences of
    /// the unknowns, which large conductances do not blur, and improved if it can be. That is what
    /// keeps mass balanced at large permeability contrasts.
    ///
    /// # Errors
    /// [`SolveError`] if the solution cannot be trusted.
    pub fn solve<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<usize, SolveError> {
        // The solver sees rows and columns of fixed points cut off, the residual below does not.
        let mut lifted = rhs.to_vec();
        self.lift(flow, &mut lifted, x);
        let scale: f64 = lifted.iter().map(|b| b.abs()).sum();
        let mut iterations = self
            .solver
            .solve(flow.view(&self.values), &lifted, x)?
            .iterations;
        let mut left = self.residual(flow, rhs, x);
        for _ in 0..REFINEMENTS {
            if left <= REFINED * scale {
                break;
            }
            self.correction.resize(x.len(), 0.0);
            self.correction.fill(0.0);
            let (matrix, defect) = (flow.view(&self.values), &self.defect);
            let enough = (FURTHER * REFINED * scale / left).min(LEAST);
            iterations += self
                .solver
                .solve_to(matrix, defect, &mut self.correction, enough)?
                .iterations;
            let candidate: Vec<f64> = x.iter().zip(&self.correction).map(|(x, c)| x + c).collect();
            let after = self.residual(flow, rhs, &candidate);
            if after >= 0.5 * left {
                break;
            }
            x.copy_from_slice(&candidate);
            left = after;
        }
        if left > ACCEPTED * scale {
            return Err(SolveError::Inaccurate {
                residual: left / scale,
                bar: ACCEPTED,
                refinements: REFINEMENTS,
                advice: "the permeability contrast or the share of storage is beyond what double \
                         precision resolves; reduce the contrast or the step",
            });
        }
        Ok(iterations)
    }

    /// (S + a L)⁻¹ rhs from rest, zero at fixed points: the filter of error estimates, of which a few
    /// digits matter.
    ///
    /// # Errors
    /// [`SolveError`] of the solver.
    pub fn filter<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        rhs: &[f64],
        report: &mut StepReport,
    ) -> Result<Vec<f64>, SolveError> {
        let mut error = vec![0.0; rhs.len()];
        let pairs = rhs.iter().zip(&self.is_fixed);
        let free: Vec<f64> = pairs
            .map(|(r, fixed)| if *fixed { 0.0 } else { *r })
            .collect();
        let matrix = flow.view(&self.values);
        let solved = self.solver.solve_to(matrix, &free, &mut error, FILTERED)?;
        report.iterations += solved.iterations;
        Ok(error)
    }

    /// Sets the defect to b − (S + a L) x, with L x from differences; gives its sum of absolutes.
    fn residual<const D: usize>(&mut self, flow: &FlowModel<D>, rhs: &[f64], x: &[f64]) -> f64 {
        let a = self.coefficient.unwrap_or(1.0);
        self.defect.resize(x.len(), 0.0);
        self.defect.fill(0.0);
        flow.subtract_exchange(x, &mut self.defect);
        self.held.resize(x.len(), 0.0);
        self.held.fill(0.0);
        if self.stabilised {
            flow.subtract_stabilisation(x, &mut self.held);
        }
        for (row, defect) in self.defect.iter_mut().enumerate() {
            let own = a * self.leak[row] + self.storage[row] + self.ground[row];
            *defect = match self.is_fixed[row] {
                true => 0.0,
                false => rhs[row] + a * *defect + self.held[row] - own * x[row],
            };
        }
        self.defect.iter().map(|d| d.abs()).sum()
    }

    /// Moves the known values of fixed points to the right-hand side.
    fn lift<const D: usize>(&mut self, flow: &FlowModel<D>, rhs: &mut [f64], x: &[f64]) {
        if !self.any_fixed {
            return;
        }
        let known: Vec<f64> = x
            .iter()
            .zip(&self.is_fixed)
            .map(|(x, fixed)| if *fixed { *x } else { 0.0 })
            .collect();
        self.lift.resize(x.len(), 0.0);
        multiply(flow.matrix(), &known, &mut self.lift);
        let a = self.coefficient.unwrap_or(1.0);
        self.lift.iter_mut().for_each(|lift| *lift *= a);
        if self.stabilised {
            let mut held = vec![0.0; x.len()];
            multiply(flow.view(&flow.stabilisation), &known, &mut held);
            self.lift.iter_mut().zip(&held).for_each(|(l, h)| *l += h);
        }
        for (row, diagonal) in flow.pattern.diagonals() {
            rhs[row] = match self.is_fixed[row] {
                true => self.values[diagonal] * known[row],
                false => rhs[row] - self.lift[row],
            };
        }
        flow.subdomain().complete(rhs, 1);
    }
}
