//! Theis' solution for a rate that changes over time, by superposition.

use super::theis::Theis;
use super::{ExactPressure, Exclusion};

/// Sum of Theis' solutions for the changes of a rate that is zero before t = 0 and follows a table from then on.
///
/// A jump by ΔQ at t = 0 adds ΔQ E₁(a/t)/(4π √det κ), a = r·κ⁻¹r S/4. Along a straight piece of the table from t₁ to t₂, of slope
/// m, it is m [I(t − t₁) − I(t − min(t, t₂))] in place of ΔQ E₁, with
///
///   I(θ) = ∫₀^θ E₁(a/τ) dτ = (θ + a) E₁(a/θ) − θ e^(−a/θ).
#[derive(Clone, Debug, PartialEq)]
pub struct TheisSeries {
    theis: Theis,
    /// Time, s, and rate, m²/s.
    rates: Vec<[f64; 2]>,
}

impl TheisSeries {
    /// The solution around the well of `theis`, whose own rate does not count, for `rates`: pairs of a time (s, increasing) and a
    /// rate (m²/s), straight lines between them, constant before the first and after the last.
    #[must_use]
    pub fn new(theis: Theis, rates: Vec<[f64; 2]>) -> Self {
        Self { theis, rates }
    }

    /// Rate at `time`, m²/s.
    fn rate(&self, time: f64) -> f64 {
        let after = self.rates.iter().position(|[at, _]| *at > time);
        match after {
            Some(0) => self.rates[0][1],
            Some(next) => {
                let ([t0, r0], [t1, r1]) = (self.rates[next - 1], self.rates[next]);
                r0 + (r1 - r0) * (time - t0) / (t1 - t0)
            }
            None => self.rates.last().map_or(0.0, |[_, rate]| *rate),
        }
    }

    /// What the piece from `from` to `to` (s) adds by `time`, over 1/(4π √det κ).
    fn piece(&self, argument: f64, time: f64, [[start, first], [to, last]]: [[f64; 2]; 2]) -> f64 {
        let (from, until) = (start.max(0.0), to.min(time));
        if until <= from {
            return 0.0;
        }
        let slope = (last - first) / (to - start);
        let integral = |span: f64| match span > 0.0 {
            true => {
                let u = argument / span;
                (span + argument) * super::exponential_integral(u) - span * (-u).exp()
            }
            false => 0.0,
        };
        slope * (integral(time - from) - integral(time - until))
    }
}

impl ExactPressure for TheisSeries {
    fn name(&self) -> &'static str {
        "theis"
    }

    /// The initial pressure up to t = 0; infinite at the well afterwards. A third coordinate is ignored.
    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let start = self.theis.parameters().initial_pressure;
        if time <= 0.0 {
            return start;
        }
        let (argument, scale) = (self.theis.argument(position), self.theis.scale());
        let jump = self.rate(0.0) * super::exponential_integral(argument / time);
        let pieces = self.rates.windows(2);
        let pieces = pieces.map(|ends| self.piece(argument, time, [ends[0], ends[1]]));
        start + scale * (jump + pieces.sum::<f64>())
    }

    fn excluded(&self) -> Vec<Exclusion> {
        self.theis.excluded()
    }
}

#[cfg(test)]
mod tests {
    use super::super::TheisParameters;
    use super::*;

    fn series(rates: &[[f64; 2]]) -> TheisSeries {
        let theis = Theis::new(TheisParameters {
            well: [0.0, 0.0],
            rate: 1.0,
            mobility: 1e-10,
            shape: [1.0, 1.0, 0.0],
            storage: 2e-9,
            initial_pressure: 5e5,
            excluded_radius: 0.1,
        });
        TheisSeries::new(theis.unwrap(), rates.to_vec())
    }

    fn at_rate(rate: f64) -> Theis {
        let parameters = series(&[[0.0, 1.0]]).theis.parameters().clone();
        Theis::new(TheisParameters { rate, ..parameters }).unwrap()
    }

    #[test]
    fn a_constant_rate_is_theis() {
        let (series, theis) = (series(&[[0.0, 3e-4]]), at_rate(3e-4));
        for (x, t) in [(0.5, 1.0), (2.0, 50.0)] {
            let [found, exact] = [series.pressure(&[x, 0.0], t), theis.pressure(&[x, 0.0], t)];
            assert!((found / exact - 1.0).abs() < 1e-14, "{found} {exact}");
        }
    }

    /// A ramp is the sum of many small jumps.
    #[test]
    fn a_ramp_is_a_sum_of_jumps() {
        let series = series(&[[2.0, 0.0], [7.0, 1e-3], [9.0, 4e-4]]);
        let small = 4000;
        for time in [5.0, 8.0, 40.0] {
            let jumps = [(2.0, 5.0, 1e-3), (7.0, 2.0, -6e-4)].map(|(from, span, change)| {
                let one = |k: i32| {
                    let at = from + span * (f64::from(k) + 0.5) / f64::from(small);
                    let jump = at_rate(change / f64::from(small));
                    jump.pressure(&[0.7, 0.4], time - at) - 5e5
                };
                (0..small).map(one).sum::<f64>()
            });
            let (found, sum) = (
                series.pressure(&[0.7, 0.4], time) - 5e5,
                jumps[0] + jumps[1],
            );
            assert!((found / sum - 1.0).abs() < 1e-5, "{time}: {found} {sum}");
        }
    }

    /// Long after a shut-in everything spreads: Q (t − t_p) and the pulse of the same volume agree.
    #[test]
    fn long_after_the_end_only_the_volume_matters() {
        let series = series(&[[0.0, 1e-3], [1.0, 1e-3], [1.001, 0.0]]);
        let (time, volume) = (1e4, 1e-3 * 1.0005);
        // An instantaneous line source: V/(4πκt) e^(−a/t).
        let pulse = volume / (4.0 * std::f64::consts::PI * 1e-10 * time);
        let found = series.pressure(&[0.1, 0.0], time) - 5e5;
        assert!((found / pulse - 1.0).abs() < 1e-3, "{found} {pulse}");
    }
}
