//! A smooth manufactured pressure field in a box, with the source it needs.

use std::f64::consts::PI;

use super::error::{finite, positive};
use super::{ExactPressure, ReferenceError, coordinate};

/// What holds at both ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// No flux: a cosine.
    Sealed,
    /// Pressure zero: a sine.
    Prescribed,
}

/// The field along one axis of the box: cos or sin of `half_waves` π (x − origin)/size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Least coordinate of the box, m.
    pub origin: f64,
    /// Length of the box, m.
    pub size: f64,
    /// What holds at its ends.
    pub ends: Ends,
    /// Number of half-waves; 0 between sealed ends makes the field constant along the axis.
    pub half_waves: u32,
}

impl Axis {
    /// Wave number, 1/m.
    fn wave_number(&self) -> f64 {
        f64::from(self.half_waves) * PI / self.size
    }

    /// Value at `x` (m).
    fn value(&self, x: f64) -> f64 {
        let phase = self.wave_number() * (x - self.origin);
        match self.ends {
            Ends::Sealed => phase.cos(),
            Ends::Prescribed => phase.sin(),
        }
    }
}

/// How the field varies in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeFactor {
    /// Not at all.
    Steady,
    /// exp(−rate t).
    Decay {
        /// Decay rate, 1/s.
        rate: f64,
    },
    /// 1 + sin(angular_frequency t).
    Oscillation {
        /// Angular frequency, rad/s.
        angular_frequency: f64,
    },
}

impl TimeFactor {
    /// Factor at `time` (s).
    #[must_use]
    pub fn value(self, time: f64) -> f64 {
        match self {
            Self::Steady => 1.0,
            Self::Decay { rate } => (-rate * time).exp(),
            Self::Oscillation { angular_frequency } => 1.0 + (angular_frequency * time).sin(),
        }
    }

    /// Time derivative of the factor at `time` (s), 1/s.
    #[must_use]
    pub fn derivative(self, time: f64) -> f64 {
        match self {
            Self::Steady => 0.0,
            Self::Decay { rate } => -rate * (-rate * time).exp(),
            Self::Oscillation { angular_frequency } => {
                angular_frequency * (angular_frequency * time).cos()
            }
        }
    }

    /// The parameter, whatever it is, 1/s.
    fn parameter(self) -> f64 {
        match self {
            Self::Steady => 0.0,
            Self::Decay { rate } => rate,
            Self::Oscillation { angular_frequency } => angular_frequency,
        }
    }
}

/// p = amplitude · Π over axes of a cosine or sine · time factor, in one to three dimensions.
///
/// Its source S ∂p/∂t − κ∇²p (1/s) holds for constant mobility and storage.
#[derive(Clone, Debug, PartialEq)]
pub struct Manufactured {
    axes: Vec<Axis>,
    mobility: f64,
    storage: f64,
    amplitude: f64,
    time_factor: TimeFactor,
}

impl Manufactured {
    /// A field of the given `amplitude` (Pa) in a box of one to three `axes`, for a rock with
    /// `mobility` κ = K/μ_f (m²/(Pa·s)) and `storage` S (1/Pa).
    ///
    /// # Errors
    /// [`ReferenceError`] where the number of axes is not 1, 2 or 3, a size or the mobility or the
    /// storage is not above zero, the field would vanish everywhere, or a number is not finite.
    pub fn new(
        axes: &[Axis],
        mobility: f64,
        storage: f64,
        amplitude: f64,
        time_factor: TimeFactor,
    ) -> Result<Self, ReferenceError> {
        if axes.is_empty() || axes.len() > 3 {
            let (subject, found) = ("manufactured field", axes.len());
            return Err(ReferenceError::WrongDimension {
                subject,
                found,
                least: 1,
                most: 3,
            });
        }
        for (index, axis) in axes.iter().enumerate() {
            positive("size of the box (m)", axis.size)?;
            finite("origin of the box (m)", axis.origin)?;
            if axis.ends == Ends::Prescribed && axis.half_waves == 0 {
                return Err(ReferenceError::NoWave { axis: index });
            }
        }
        positive("mobility of the manufactured problem (m²/(Pa·s))", mobility)?;
        positive("storage of the manufactured problem (1/Pa)", storage)?;
        finite("amplitude of the manufactured field (Pa)", amplitude)?;
        finite(
            "rate of the manufactured field (1/s)",
            time_factor.parameter(),
        )?;
        Ok(Self {
            axes: axes.to_vec(),
            mobility,
            storage,
            amplitude,
            time_factor,
        })
    }

    /// Decay rate in 1/s at which the field needs no source: κ|k|²/S.
    #[must_use]
    pub fn natural_decay_rate(&self) -> f64 {
        self.mobility * self.squared_wave_number() / self.storage
    }

    /// The axes of the box.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// |k|² = Σ k² over the axes, 1/m².
    fn squared_wave_number(&self) -> f64 {
        self.axes
            .iter()
            .map(|axis| axis.wave_number().powi(2))
            .sum()
    }

    /// The field without its time factor, Pa.
    fn shape(&self, position: &[f64]) -> f64 {
        let axes = self.axes.iter().enumerate();
        self.amplitude
            * axes
                .map(|(index, axis)| axis.value(coordinate(position, index)))
                .product::<f64>()
    }
}

impl ExactPressure for Manufactured {
    fn name(&self) -> &'static str {
        "manufactured"
    }

    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        self.shape(position) * self.time_factor.value(time)
    }

    /// A field without time variation is the steady state of its source.
    fn steady_only(&self) -> bool {
        self.time_factor == TimeFactor::Steady
    }

    fn source(&self, position: &[f64], time: f64) -> Option<f64> {
        let storing = self.storage * self.time_factor.derivative(time);
        let flowing = self.mobility * self.squared_wave_number() * self.time_factor.value(time);
        Some(self.shape(position) * (storing + flowing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(origin: f64, size: f64, ends: Ends, half_waves: u32) -> Axis {
        Axis {
            origin,
            size,
            ends,
            half_waves,
        }
    }

    fn boxes() -> Vec<Vec<Axis>> {
        vec![
            vec![
                axis(1.0, 2.0, Ends::Sealed, 1),
                axis(-1.0, 3.0, Ends::Prescribed, 2),
            ],
            vec![
                axis(0.0, 1.0, Ends::Prescribed, 1),
                axis(0.5, 1.5, Ends::Sealed, 2),
                axis(-2.0, 4.0, Ends::Prescribed, 3),
            ],
        ]
    }

    fn factors() -> [TimeFactor; 3] {
        [
            TimeFactor::Steady,
            TimeFactor::Decay { rate: 0.7 },
            TimeFactor::Oscillation {
                angular_frequency: 3.0,
            },
        ]
    }

    #[test]
    fn the_source_balances_finite_differences() {
        let (mobility, storage, h) = (0.3, 0.8, 1e-3);
        for (axes, factor) in boxes()
            .iter()
            .flat_map(|b| factors().map(|f| (b.clone(), f)))
        {
            let field = Manufactured::new(&axes, mobility, storage, 2.0, factor).unwrap();
            let (at, time) = ([1.3, 0.75, -1.1], 0.4);
            let at = &at[..axes.len()];
            let centre = field.pressure(at, time);
            let laplacian: f64 = (0..axes.len())
                .map(|index| {
                    let shifted = |by: f64| {
                        let mut position = at.to_vec();
                        position[index] += by;
                        field.pressure(&position, time)
                    };
                    (shifted(h) + shifted(-h) - 2.0 * centre) / (h * h)
                })
                .sum();
            let rate = (field.pressure(at, time + h) - field.pressure(at, time - h)) / (2.0 * h);
            let expected = storage * rate - mobility * laplacian;
            let found = field.source(at, time).unwrap();
            assert!(
                (found - expected).abs() < 1e-4,
                "{factor:?}: {found} {expected}"
            );
            assert!(
                found.abs() > 1e-2,
                "a test point on a node line checks nothing"
            );
        }
    }

    #[test]
    fn prescribed_ends_are_zero_and_sealed_ends_have_no_slope() {
        let [plane, _] = &boxes()[..] else {
            panic!("two boxes")
        };
        let field = Manufactured::new(plane, 1.0, 1.0, 5.0, TimeFactor::Steady).unwrap();
        for y in [-1.0, 2.0] {
            assert!(field.pressure(&[1.3, y], 0.0).abs() < 1e-14);
        }
        for x in [1.0, 3.0] {
            let slope =
                field.pressure(&[x + 1e-5, 0.1], 0.0) - field.pressure(&[x - 1e-5, 0.1], 0.0);
            assert!(slope.abs() < 1e-13, "{slope}");
        }
    }

    #[test]
    fn natural_decay_needs_no_source() {
        let axes = &boxes()[1];
        let still = Manufactured::new(axes, 0.3, 0.8, 2.0, TimeFactor::Steady).unwrap();
        let factor = TimeFactor::Decay {
            rate: still.natural_decay_rate(),
        };
        let field = Manufactured::new(axes, 0.3, 0.8, 2.0, factor).unwrap();
        assert!(field.source(&[0.3, 0.7, 0.2], 0.05).unwrap().abs() < 1e-13);
    }

    #[test]
    fn a_vanishing_field_and_a_fourth_axis_are_refused() {
        let flat = [axis(0.0, 1.0, Ends::Prescribed, 0)];
        let refused = Manufactured::new(&flat, 1.0, 1.0, 1.0, TimeFactor::Steady);
        assert_eq!(refused, Err(ReferenceError::NoWave { axis: 0 }));
        let many = [axis(0.0, 1.0, Ends::Sealed, 1); 4];
        let refused = Manufactured::new(&many, 1.0, 1.0, 1.0, TimeFactor::Steady);
        assert!(matches!(
            refused,
            Err(ReferenceError::WrongDimension { found: 4, .. })
        ));
    }
}
