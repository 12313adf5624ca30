//! How often the matrices of a plan are solved with between two changes of their values.

use perifrac_solvers::Demand;

use super::{DamageModel, Integrator, Plan, StepRule, TimeMode};

/// A solve and the corrections that follow it.
const STEADY_SOLVES: usize = 3;
/// Steps with one matrix when steps adapt: they are lengthened rarely and by much.
const ADAPTIVE_STEPS: usize = 3;
/// Passes between flow and mechanics that a step takes, about.
const PASSES: usize = 6;
/// A crack of 0.3 mm in a band of 0.1 m conducts 2e4 times as well as rock of 1 mD.
const CRACK_CONTRAST: f64 = 1e4;
/// Steps of an adaptive run, about.
const ADAPTIVE_RUN: usize = 50;

impl Plan {
    /// Demand on the solver of a matrix that changes with the length of the step.
    pub fn stage_demand(&self) -> Demand {
        if self.time.mode == TimeMode::Steady {
            return self.demand(STEADY_SOLVES);
        }
        let stages = match self.scheme.integrator() {
            Some(Integrator::TrBdf2) => 2,
            _ => 1,
        };
        let steps = match self.time.step {
            StepRule::Fixed(_) => self.fixed_steps(),
            _ => ADAPTIVE_STEPS,
        };
        self.demand(steps * stages)
    }

    /// Demand on the solver of a matrix that stays the same for the whole run.
    pub fn solid_demand(&self) -> Demand {
        if self.time.mode == TimeMode::Steady {
            return self.demand(STEADY_SOLVES);
        }
        let steps = match self.time.step {
            StepRule::Fixed(_) => self.fixed_steps(),
            _ if self.flow.is_none() => 1,
            _ => ADAPTIVE_RUN,
        };
        let passes = if self.flow.is_some() { PASSES } else { 1 };
        self.demand(steps * passes)
    }

    /// Least contrast of what points conduct that a solver is chosen for: cracks open.
    pub fn expected_contrast(&self) -> f64 {
        let split = (self.damage).is_some_and(|damage| damage.model == DamageModel::Split);
        match split && self.fracture_flow.is_some() {
            true => CRACK_CONTRAST,
            false => 1.0,
        }
    }

    /// Demand on the solver of a matrix that changes with damage, in every iteration.
    pub fn fracture_demand(&self) -> Demand {
        self.demand(1)
    }

    fn fixed_steps(&self) -> usize {
        match self.time.step {
            StepRule::Fixed(dt) => ((self.time.end / dt).ceil() as usize).max(1),
            _ => 1,
        }
    }

    fn demand(&self, solves: usize) -> Demand {
        Demand {
            spec: self.solver.clone(),
            solves,
        }
    }
}
