//! Mechanics alone without inertia: equilibrium at every time.

use super::solid::SolidSolver;
use super::{Memory, Scheme, SchemeCounters, State, StepError, StepReport};
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

/// Keeps what the state drove: damage does not heal.
pub fn advance<const D: usize>(model: &Model<D>, state: &mut State) {
    let Some(solid) = &model.solid else { return };
    if let (Some(damage), Some(response)) = (&solid.damage, model.response(&state.view())) {
        damage.advance(&response.driving, &mut state.history);
        damage.settle(&response, &mut state.normal);
    }
}

/// Largest growth of damage at a point between two states; `None` without damage.
pub fn growth<const D: usize>(model: &Model<D>, old: &State, new: &State) -> Option<f64> {
    let damage = model.solid.as_ref()?.damage.as_ref()?;
    let (before, after) = (damage.of(&old.history), damage.of(&new.history));
    Some(
        after
            .iter()
            .zip(&before)
            .map(|(a, b)| a - b)
            .fold(0.0, f64::max),
    )
}

impl<const D: usize> Scheme<D> for QuasiStatic<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn local_order(&self) -> f64 {
        1.0
    }

    fn recall(&mut self, memory: &Memory) {
        self.solid.recall(memory);
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        self.solid.equilibrate(model, state)?;
        advance(model, state);
        self.solid.remember(&mut state.memory);
        Ok(())
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        self.recall(&old.memory);
        trial.clone_from(old);
        trial.time = old.time + dt;
        let iterations = self.solid.equilibrate(model, trial)?;
        trial.check()?;
        advance(model, trial);
        self.solid.remember(&mut trial.memory);
        Ok(StepReport {
            growth: growth(model, old, trial),
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
