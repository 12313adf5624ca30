//! The implicit matrix C + a L, factored anew only when `a` or L changes.

use perifrac_solvers::{
    Coordinates, LinearSolver, Problem, SolveError, SolveReport, SolverCounters, SolverSpec,
    Symmetry, choose, multiply,
};

use crate::model::FlowModel;

use super::StepError;

/// Solver of (C + a L) x = b with rows of fixed points replaced by the identity.
pub struct ImplicitSystem {
    solver: Box<dyn LinearSolver>,
    chosen: (String, String),
    values: Vec<f64>,
    coefficient: Option<f64>,
    is_fixed: Vec<bool>,
    lift: Vec<f64>,
}

impl ImplicitSystem {
    /// Chooses and analyses the solver once.
    ///
    /// # Errors
    /// [`StepError`] if the solver is refused.
    pub fn new<const D: usize>(
        spec: &SolverSpec,
        flow: &FlowModel<D>,
    ) -> Result<Self, StepError> {
        let coordinates = flow.operator.neighbourhood().cloud.flat_positions();
        let values = vec![0.0; flow.pattern.nonzeros()];
        let problem = Problem {
            pattern: flow.view(&values),
            symmetry: Symmetry::PositiveDefinite,
            coordinates: Some(Coordinates { dimension: D, values: &coordinates }),
            unknowns_per_point: 1,
        };
        let (spec, reason) = match spec.name() {
            "auto" => {
                let choice = choose(&problem)?;
                (choice.spec, choice.reason)
            }
            _ => (spec.clone(), "asked for".to_owned()),
        };
        let mut solver = spec.build()?;
        solver.analyse(&problem)?;
        let mut is_fixed = vec![false; if flow.fixed.is_empty() { 0 } else { flow.points() }];
        flow.fixed.iter().for_each(|fixed| is_fixed[fixed.point] = true);
        Ok(ImplicitSystem {
            solver,
            chosen: (spec.to_string(), reason),
            values,
            coefficient: None,
            lift: Vec::new(),
            is_fixed,
        })
    }

    /// The solver in use and why.
    pub fn chosen(&self) -> &(String, String) {
        &self.chosen
    }

    /// Work done.
    pub fn counters(&self) -> &SolverCounters {
        self.solver.counters()
    }

    /// Makes the matrix capacity·C + a L the current one, `capacity` being 1 or, for a steady
    /// state, 0; `ground` rows get their own diagonal once more.
    ///
    /// # Errors
    /// [`SolveError`] if it cannot be factored.
    pub fn prepare<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        capacity: f64,
        a: f64,
        ground: &[usize],
    ) -> Result<(), SolveError> {
        let same = |old: f64| (old - a).abs() <= 1e-12 * a.abs();
        if ground.is_empty() && self.coefficient.is_some_and(same) {
            return Ok(());
        }
        self.coefficient = None;
        self.values.iter_mut().zip(&flow.conductance).for_each(|(v, l)| *v = a * l);
        for row in 0..flow.points() {
            self.values[flow.pattern.diagonal(row)] += capacity * flow.capacity[row];
        }
        for &row in ground {
            self.values[flow.pattern.diagonal(row)] *= 2.0;
        }
        self.fix_rows(flow);
        self.solver.refresh(flow.view(&self.values))?;
        self.coefficient = Some(a);
        Ok(())
    }

    /// Replaces rows and columns of fixed points, keeping their diagonal as the scale.
    fn fix_rows<const D: usize>(&mut self, flow: &FlowModel<D>) {
        if self.is_fixed.is_empty() {
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
    /// # Errors
    /// [`SolveError`] if the solution cannot be trusted.
    pub fn solve<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        rhs: &mut [f64],
        x: &mut [f64],
    ) -> Result<SolveReport, SolveError> {
        self.lift(flow, rhs, x);
        self.solver.solve(flow.view(&self.values), rhs, x)
    }

    /// Moves the known values of fixed points to the right-hand side.
    fn lift<const D: usize>(&mut self, flow: &FlowModel<D>, rhs: &mut [f64], x: &[f64]) {
        if self.is_fixed.is_empty() {
            return;
        }
        let known: Vec<f64> =
            x.iter().zip(&self.is_fixed).map(|(x, fixed)| if *fixed { *x } else { 0.0 }).collect();
        self.lift.resize(x.len(), 0.0);
        multiply(flow.matrix(), &known, &mut self.lift);
        let a = self.coefficient.unwrap_or(1.0);
        for row in 0..x.len() {
            rhs[row] = match self.is_fixed[row] {
                true => self.values[flow.pattern.diagonal(row)] * known[row],
                false => rhs[row] - a * self.lift[row],
            };
        }
    }
}
