//! Wells that go over to a limit, or back, within the step that calls for it.

use super::time_loop::Run;
use crate::model::{Control, Model};
use crate::schemes::{Scheme, State, StepError, StepReport};

/// Changes of control that wells have made on the way to one state: each is made once, or the well would go to and fro.
#[derive(Debug, Default)]
struct Changes(Vec<(usize, Control, Control)>);

impl Changes {
    /// Enters the changes from `now` to `next`.
    ///
    /// # Errors
    /// [`StepError::OscillatingWell`] for one that was made before.
    fn enter<const D: usize>(
        &mut self,
        model: &Model<D>,
        (now, next): (&[Control], &[Control]),
        time: f64,
    ) -> Result<(), StepError> {
        let pairs = now.iter().zip(next).enumerate();
        for (well, (&from, &to)) in pairs.filter(|(_, (from, to))| from != to) {
            if self.0.contains(&(well, from, to)) {
                let wells = model.flow.iter().flat_map(|flow| flow.wells.iter());
                let name = wells.map(|well| well.name.clone()).nth(well);
                let name = name.unwrap_or_default();
                return Err(StepError::OscillatingWell { name, time });
            }
            self.0.push((well, from, to));
        }
        Ok(())
    }
}

impl<const D: usize> Run<'_, D> {
    /// Holds the wells of the model at what the state says.
    pub(super) fn follow_wells(&mut self) {
        let controls = self.state.controls();
        self.hold(&controls);
    }

    fn hold(&mut self, controls: &[Control]) {
        if let Some(flow) = &mut self.model.flow {
            flow.set_controls(controls);
        }
    }

    /// The controls that suit a state better than those that have led to it.
    fn better(&self, state: &State) -> Option<Vec<Control>> {
        let flow = self.model.flow.as_ref()?;
        flow.suited_controls(state.time, &state.pressure)
    }

    /// One step, done again with the controls of the wells that its end calls for. The wells of the model are then held as in
    /// `trial`.
    ///
    /// # Errors
    /// As [`Scheme::step`]; [`StepError::OscillatingWell`].
    pub(super) fn step(
        &mut self,
        scheme: &mut dyn Scheme<D>,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        self.follow_wells();
        let mut report = scheme.step(&self.model, &self.state, dt, trial)?;
        trial.wells.clone_from(&self.state.wells);
        let mut changes = Changes::default();
        while let Some(next) = self.better(trial) {
            changes.enter(&self.model, (&trial.controls(), &next), trial.time)?;
            self.hold(&next);
            let mut from = self.state.clone();
            from.set_controls(&next);
            let before = report.iterations;
            report = scheme.step(&self.model, &from, dt, trial)?;
            report.iterations += before;
            trial.wells = from.wells;
        }
        Ok(report)
    }

    /// Holds the wells at what the pressure of the state calls for, without a step.
    ///
    /// # Errors
    /// [`StepError::OscillatingWell`].
    pub(super) fn settle_wells(&mut self) -> Result<(), StepError> {
        let mut changes = Changes::default();
        while let Some(next) = self.better(&self.state) {
            let now = self.state.controls();
            changes.enter(&self.model, (&now, &next), self.state.time)?;
            self.state.set_controls(&next);
            self.hold(&next);
        }
        // What the start calls for is no change.
        (self.state.wells.iter_mut()).for_each(|well| well.switches = 0);
        Ok(())
    }

    /// Solves for a state with `solve`, again with the controls that its result calls for.
    ///
    /// # Errors
    /// As `solve`; [`StepError::OscillatingWell`].
    pub(super) fn settled<T>(
        &mut self,
        mut solve: impl FnMut(&Model<D>, &mut State) -> Result<T, StepError>,
    ) -> Result<T, StepError> {
        let start = self.state.pressure.clone();
        let mut changes = Changes::default();
        let mut found = solve(&self.model, &mut self.state)?;
        while let Some(next) = self.better(&self.state) {
            let now = self.state.controls();
            changes.enter(&self.model, (&now, &next), self.state.time)?;
            self.state.set_controls(&next);
            self.hold(&next);
            self.state.pressure.clone_from(&start);
            found = solve(&self.model, &mut self.state)?;
        }
        Ok(found)
    }
}
