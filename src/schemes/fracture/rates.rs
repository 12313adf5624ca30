//! How fast fields changed in a step: where the next one starts, and how far backward Euler is off.

use crate::model::Model;
use crate::operators::Response;
use crate::schemes::memory::Rates;
use crate::schemes::{State, StepError, flow_of};

impl Rates {
    /// Error of the step of `dt` seconds from one state to the other, into which its rates are entered; with the response to
    /// the other where cracks hold fluid of their own.
    /// `None` in the first step, and in a step in which a crack takes in points, and after it: the growth of damage
    /// alone bounds those.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without flow.
    pub(super) fn judge<const D: usize>(
        model: &Model<D>,
        response: Option<&Response<D>>,
        (old, new): (&State, &mut State),
        dt: f64,
    ) -> Result<Option<f64>, StepError> {
        let (mut now, last) = (Rates::default(), &old.memory.rates);
        now.take(old, new, dt);
        // The pressure in the crack jumps where it takes in points, by an amount that does not depend on the length of
        // the step: no error of the time, and no step is short enough for it.
        if response.is_some_and(|response| model.has_unfilled(response)) {
            now.pressure.clear();
        }
        let start = &flow_of(model)?.initial;
        let pairs = new.pressure.iter().zip(start);
        let change: Vec<f64> = pairs.map(|(new, start)| new - start).collect();
        let error = last.error(&now, &model.cloud.volume, &change);
        new.memory.rates = now;
        Ok(error)
    }

    /// Takes those that led from `old` to `new`.
    fn take(&mut self, old: &State, new: &State, dt: f64) {
        let set = |rates: &mut Vec<f64>, new: &[f64], old: &[f64]| {
            rates.clear();
            rates.extend(new.iter().zip(old).map(|(new, old)| (new - old) / dt));
        };
        self.dt = dt;
        set(&mut self.displacement, &new.displacement, &old.displacement);
        set(&mut self.pressure, &new.pressure, &old.pressure);
    }

    /// Error of a backward Euler step with the rates `now`, Pa: half of Δt² p̈, whose p̈ is what the rates have
    /// changed by since the step before.
    ///
    /// It is the root mean square over the root mean square of `change`, which the pressure has gone through
    /// since the start, times the largest of it: a fracture is a small part of the volume, and an average over
    /// all of it would make little of what is wrong there.
    fn error(&self, now: &Rates, volume: &[f64], change: &[f64]) -> Option<f64> {
        if self.pressure.is_empty() || now.pressure.is_empty() {
            return None;
        }
        let share = now.dt * now.dt / (now.dt + self.dt);
        let pairs = now.pressure.iter().zip(&self.pressure).zip(volume);
        let error: f64 = pairs.map(|((now, last), v)| v * (now - last).powi(2)).sum();
        let size: f64 = change.iter().zip(volume).map(|(c, v)| v * c * c).sum();
        let largest = change.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        match size > 0.0 {
            true => Some(share * (error / size).sqrt() * largest),
            false => Some(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(time: f64) -> State {
        State {
            time,
            // p̈ = 6 and 0.
            pressure: vec![3.0 * time * time, 5.0 * time],
            ..State::default()
        }
    }

    #[test]
    fn the_error_is_half_the_square_of_the_step_times_the_curvature() {
        let [mut last, mut now] = [Rates::default(), Rates::default()];
        let volume = [1.0, 3.0];
        last.take(&state(1.0), &state(1.5), 0.5);
        assert_eq!(Rates::default().error(&last, &volume, &[1.0; 2]), None);
        now.take(&state(1.5), &state(1.75), 0.25);
        // Backward differences of a parabola: p̈ Δt²/2 = 6/2 · 0.25², at a quarter of the volume.
        let error = 3.0 * 0.25 * 0.25;
        for (change, expected) in [
            ([1.0, -1.0], 0.5 * error),
            ([2.0, 0.0], error),
            ([0.0; 2], 0.0),
        ] {
            let found = last.error(&now, &volume, &change).unwrap();
            assert!((found - expected).abs() < 1e-12, "{found}");
        }
    }
}
