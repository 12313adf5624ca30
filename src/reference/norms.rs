//! How far a computed field is from the exact one.

use super::{ExactPressure, ReferenceError};

/// One point of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Computed value.
    pub numerical: f64,
    /// Exact value.
    pub exact: f64,
    /// Volume of the point, m³ (m² in 2-D).
    pub volume: f64,
    /// Whether the point is left out.
    pub excluded: bool,
}

/// Norms of computed minus exact, in the unit of the field (Pa for pressures).
///
/// ```
/// use perifrac::prelude::ErrorNorms;
///
/// let norms = ErrorNorms::compare(&[1.0, 2.0, 4.0], &[1.0, 2.0, 3.0], &[1.0; 3], &[])?;
/// assert_eq!((norms.max, norms.worst_point, norms.range), (1.0, 2, 2.0));
/// # Ok::<(), perifrac::reference::ReferenceError>(())
/// ```
///
/// Sums run over the points in their order on one thread, with compensation, so the result does
/// not depend on the number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorNorms {
    /// Root of the volume-weighted mean square, √(Σ V e² / Σ V).
    pub l2: f64,
    /// Greatest absolute error.
    pub max: f64,
    /// Greatest minus least exact value over the compared points.
    pub range: f64,
    /// `l2` over `range`; infinite (or 0 for no error) where the exact field is constant.
    pub l2_relative: f64,
    /// `l2` over the root mean square of the exact values; infinite (or 0 for no error) where they
    /// vanish.
    pub l2_over_norm: f64,
    /// `max` over `range`; infinite (or 0 for no error) where the exact field is constant.
    pub max_relative: f64,
    /// Index of the point with the greatest error, the first of equals.
    pub worst_point: usize,
    /// Number of points compared.
    pub compared: usize,
    /// Number of points left out.
    pub excluded: usize,
}

impl ErrorNorms {
    /// Norms over `samples`, numbered in their order.
    ///
    /// # Errors
    /// [`ReferenceError::BadSample`] and [`ReferenceError::BadVolume`] for a compared point without
    /// finite values or a usable volume, [`ReferenceError::NothingCompared`] where no volume is
    /// left. Excluded points may hold anything.
    pub fn from_samples(samples: impl IntoIterator<Item = Sample>) -> Result<Self, ReferenceError> {
        let mut sums = Sums::default();
        for (point, sample) in samples.into_iter().enumerate() {
            sums.add(point, sample)?;
        }
        sums.finish()
    }

    /// Norms of `numerical` minus `exact`, one entry per point; points whose `excluded` flag is set
    /// are left out (an empty mask excludes none).
    ///
    /// # Errors
    /// [`ReferenceError::LengthMismatch`], and those of [`ErrorNorms::from_samples`].
    pub fn compare(
        numerical: &[f64],
        exact: &[f64],
        volumes: &[f64],
        excluded: &[bool],
    ) -> Result<Self, ReferenceError> {
        let points = numerical.len();
        same_length("exact values", points, exact.len())?;
        same_length("volumes", points, volumes.len())?;
        if !excluded.is_empty() {
            same_length("exclusion mask", points, excluded.len())?;
        }
        Self::from_samples((0..points).map(|point| Sample {
            numerical: numerical[point],
            exact: exact[point],
            volume: volumes[point],
            excluded: excluded.get(point).copied().unwrap_or(false),
        }))
    }

    /// Norms of the pressures `numerical` (Pa) against `solution` at `time` (s), leaving out what
    /// the solution excludes. `positions` (m) gives one point per value.
    ///
    /// # Errors
    /// [`ReferenceError::LengthMismatch`], and those of [`ErrorNorms::from_samples`].
    pub fn against<P: AsRef<[f64]>>(
        solution: &dyn ExactPressure,
        time: f64,
        positions: impl IntoIterator<Item = P>,
        volumes: &[f64],
        numerical: &[f64],
    ) -> Result<Self, ReferenceError> {
        let exclusions = solution.excluded();
        let (exact, excluded): (Vec<f64>, Vec<bool>) = positions
            .into_iter()
            .map(|position| {
                let position = position.as_ref();
                let left_out = exclusions
                    .iter()
                    .any(|exclusion| exclusion.contains(position));
                (solution.pressure(position, time), left_out)
            })
            .unzip();
        same_length("positions", numerical.len(), exact.len())?;
        Self::compare(numerical, &exact, volumes, &excluded)
    }
}

/// Fails unless a list runs over all points.
fn same_length(list: &'static str, expected: usize, found: usize) -> Result<(), ReferenceError> {
    if expected == found {
        Ok(())
    } else {
        Err(ReferenceError::LengthMismatch {
            list,
            expected,
            found,
        })
    }
}

/// Sum with the lost low parts kept aside (Neumaier).
#[derive(Default)]
struct Compensated {
    sum: f64,
    lost: f64,
}

impl Compensated {
    fn add(&mut self, term: f64) {
        let total = self.sum + term;
        let (large, small) = if self.sum.abs() >= term.abs() {
            (self.sum, term)
        } else {
            (term, self.sum)
        };
        self.lost += (large - total) + small;
        self.sum = total;
    }

    fn value(&self) -> f64 {
        self.sum + self.lost
    }
}

/// What the norms are made of.
struct Sums {
    squares: Compensated,
    exact_squares: Compensated,
    volume: Compensated,
    worst: Option<(usize, f64)>,
    least: f64,
    greatest: f64,
    compared: usize,
    excluded: usize,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            squares: Compensated::default(),
            exact_squares: Compensated::default(),
            volume: Compensated::default(),
            worst: None,
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            compared: 0,
            excluded: 0,
        }
    }
}

impl Sums {
    fn add(&mut self, point: usize, sample: Sample) -> Result<(), ReferenceError> {
        let Sample {
            numerical,
            exact,
            volume,
            excluded,
        } = sample;
        if excluded {
            self.excluded += 1;
            return Ok(());
        }
        if !numerical.is_finite() || !exact.is_finite() {
            return Err(ReferenceError::BadSample {
                point,
                numerical,
                exact,
            });
        }
        if !volume.is_finite() || volume < 0.0 {
            return Err(ReferenceError::BadVolume { point, volume });
        }
        let error = (numerical - exact).abs();
        self.squares.add(volume * error * error);
        self.exact_squares.add(volume * exact * exact);
        self.volume.add(volume);
        if self.worst.is_none_or(|(_, worst)| error > worst) {
            self.worst = Some((point, error));
        }
        self.least = self.least.min(exact);
        self.greatest = self.greatest.max(exact);
        self.compared += 1;
        Ok(())
    }

    fn finish(self) -> Result<ErrorNorms, ReferenceError> {
        let volume = self.volume.value();
        let Some((worst_point, max)) = self.worst.filter(|_| volume > 0.0) else {
            return Err(ReferenceError::NothingCompared {
                excluded: self.excluded,
            });
        };
        let l2 = (self.squares.value() / volume).sqrt();
        let range = self.greatest - self.least;
        let norm = (self.exact_squares.value() / volume).sqrt();
        let over = |error: f64, scale: f64| if error > 0.0 { error / scale } else { 0.0 };
        Ok(ErrorNorms {
            l2,
            max,
            range,
            l2_relative: over(l2, range),
            l2_over_norm: over(l2, norm),
            max_relative: over(max, range),
            worst_point,
            compared: self.compared,
            excluded: self.excluded,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FiveSpot, InjectorCorner};
    use super::*;

    #[test]
    fn norms_of_a_hand_computed_field() {
        let norms = ErrorNorms::compare(
            &[1.0, 2.5, 9.0, 2.0],
            &[1.0, 2.0, 3.0, 5.0],
            &[1.0, 2.0, 9.0, 1.0],
            &[false, false, true, false],
        )
        .unwrap();
        assert!((norms.l2 - (9.5_f64 / 4.0).sqrt()).abs() < 1e-15);
        assert!((norms.max - 3.0).abs() < 1e-15);
        assert!((norms.range - 4.0).abs() < 1e-15);
        assert!((norms.l2_relative - norms.l2 / 4.0).abs() < 1e-15);
        assert!((norms.max_relative - 0.75).abs() < 1e-15);
        assert_eq!(
            (norms.worst_point, norms.compared, norms.excluded),
            (3, 3, 1)
        );
    }

    #[test]
    fn a_million_equal_errors_keep_their_size() {
        let samples = (0..1_000_000).map(|point| Sample {
            numerical: 0.1,
            exact: f64::from(point % 2),
            volume: if point % 2 == 0 { 0.1 } else { 0.0 },
            excluded: false,
        });
        let norms = ErrorNorms::from_samples(samples).unwrap();
        assert!((norms.l2 - 0.1).abs() < 1e-16, "{}", norms.l2);
    }

    #[test]
    fn wells_are_left_out_of_the_comparison_with_a_five_spot() {
        let spot = FiveSpot::new(1.0, [0.0; 2], 2.0, InjectorCorner::LowerLeft).unwrap();
        let positions = [
            [0.0, 0.0],
            [0.05, 0.02],
            [0.3, 0.4],
            [0.6, 0.1],
            [0.99, 0.99],
        ];
        let numerical: Vec<f64> = positions
            .iter()
            .map(|position| spot.pressure(position, 0.0) + 0.25)
            .collect();
        let norms = ErrorNorms::against(&spot, 0.0, positions, &[0.2; 5], &numerical).unwrap();
        assert_eq!((norms.compared, norms.excluded), (2, 3));
        assert!((norms.l2 - 0.25).abs() < 1e-14 && (norms.max - 0.25).abs() < 1e-14);
        let range = (spot.pressure(&positions[2], 0.0) - spot.pressure(&positions[3], 0.0)).abs();
        assert!((norms.l2_relative - 0.25 / range).abs() < 1e-13);
    }

    #[test]
    fn lost_values_and_empty_comparisons_are_errors() {
        let lost = ErrorNorms::compare(&[0.0, f64::NAN], &[0.0, 1.0], &[1.0; 2], &[]);
        assert!(matches!(
            lost,
            Err(ReferenceError::BadSample { point: 1, .. })
        ));
        let none = ErrorNorms::compare(&[f64::NAN], &[0.0], &[1.0], &[true]);
        assert_eq!(none, Err(ReferenceError::NothingCompared { excluded: 1 }));
        let short = ErrorNorms::compare(&[0.0; 3], &[0.0; 2], &[1.0; 3], &[]);
        assert!(matches!(
            short,
            Err(ReferenceError::LengthMismatch { found: 2, .. })
        ));
        let bad = ErrorNorms::compare(&[0.0], &[0.0], &[-1.0], &[]);
        assert!(matches!(bad, Err(ReferenceError::BadVolume { .. })));
    }

    #[test]
    fn a_constant_exact_field_has_no_finite_relative_error() {
        let norms = ErrorNorms::compare(&[1.0, 2.0], &[1.0, 1.0], &[1.0; 2], &[]).unwrap();
        assert!(norms.l2_relative.is_infinite());
        let norms = ErrorNorms::compare(&[1.0], &[1.0], &[1.0], &[]).unwrap();
        assert!(norms.max_relative.abs() < f64::MIN_POSITIVE);
    }
}
