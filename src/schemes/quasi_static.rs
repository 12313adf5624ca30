//! Mechanics alone without inertia: equilibrium at every time.

use super::solid::SolidSolver;
use super::{Scheme, SchemeCounters, State, StepError, StepReport};
use crate::model::Model;

/// Equilibrium at the end of every step.
pub struct QuasiStatic<const D: usize> {
    solid: Box<dyn SolidSolver<D>>,
    name: String,
}

impl<const D: usize> QuasiStatic<D> {
    /// Scheme with the given way to equilibrium.
    pub fn new(solid: Box<dyn SolidSolver<D>>) -> Self {
        QuasiStatic {
            name: format!("quasi-static ({})", solid.name()),
            solid,
        }
    }
}

impl<const D: usize> Scheme<D> for QuasiStatic<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn local_order(&self) -> f64 {
        1.0
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        self.solid.equilibrate(model, state).map(|_| ())
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        trial.clone_from(old);
        trial.time = old.time + dt;
        let iterations = self.solid.equilibrate(model, trial)?;
        trial.check()?;
        Ok(StepReport {
            iterations,
            // Equilibrium has no error of the step: any step is as good as any other.
            error: Some(0.0),
            ..StepReport::default()
        })
    }

    fn counters(&self) -> SchemeCounters {
        self.solid.counters()
    }

    fn solver(&self) -> Option<(String, String)> {
        self.solid.solver()
    }
}
