//! How fast fields changed in a step: where the next one starts, and how far backward Euler is off.

use crate::schemes::State;

/// How fast a step of `dt` seconds went.
#[derive(Debug, Clone, Default)]
pub(super) struct Rates {
    dt: f64,
    /// m/s, shape `(n·D,)`.
    pub displacement: Vec<f64>,
    /// Pa/s, shape `(n,)`.
    pressure: Vec<f64>,
}

impl Rates {
    /// Takes those that led from `old` to `new`.
    pub fn take(&mut self, old: &State, new: &State, dt: f64) {
        let set = |rates: &mut Vec<f64>, new: &[f64], old: &[f64]| {
            rates.clear();
            rates.extend(new.iter().zip(old).map(|(new, old)| (new - old) / dt));
        };
        self.dt = dt;
        set(&mut self.displacement, &new.displacement, &old.displacement);
        set(&mut self.pressure, &new.pressure, &old.pressure);
    }

    /// Root mean square over the volume of the error of a backward Euler step of `dt` seconds with the
    /// rates `now`: half of Δt² p̈, whose p̈ is what the rates have changed by since the step before.
    pub fn error(&self, now: &Rates, volume: &[f64]) -> Option<f64> {
        if self.pressure.is_empty() {
            return None;
        }
        let share = now.dt * now.dt / (now.dt + self.dt);
        let pairs = now.pressure.iter().zip(&self.pressure).zip(volume);
        let sum: f64 = pairs.map(|((now, last), v)| v * (now - last).powi(2)).sum();
        Some(share * (sum / volume.iter().sum::<f64>()).sqrt())
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
        assert_eq!(Rates::default().error(&last, &volume), None);
        now.take(&state(1.5), &state(1.75), 0.25);
        // Backward differences of a parabola: p̈ Δt²/2 = 6/2 · 0.25², at a quarter of the volume.
        let expected = 3.0 * 0.25 * 0.25 * 0.5;
        let found = last.error(&now, &volume).unwrap();
        assert!((found - expected).abs() < 1e-12, "{found}");
    }
}
