//! The five-spot on the way to its steady state, from a uniform pressure.
//!
//! Early, the pressure is that of the nearest mirror images of the wells, each by Theis's solution;
//! late, it is the steady one less the modes of the sealed square that have not died out. Both hold at
//! all times, so that a few terms of the one or the other are exact to rounding.

use std::f64::consts::PI;

use super::super::error::{finite, positive};
use super::super::{ExactPressure, Exclusion, ReferenceError, exponential_integral};
use super::FiveSpot;

/// Dimensionless time κt/(sL²) up to which images are summed, and modes after it.
const EARLY: f64 = 0.05;

/// Images of either well per axis and direction: those left out are further away than 3 L, where
/// E₁(9/4/0.05) is below 1e-21.
const IMAGES: i32 = 2;

/// −ln of what is below rounding.
const ROUNDING: f64 = 41.0;

/// Pressure of the confined five-spot over time.
#[derive(Clone, Debug, PartialEq)]
pub struct FiveSpotTransient {
    steady: FiveSpot,
    /// κ/s, m²/s.
    diffusivity: f64,
    /// Pa.
    initial_pressure: f64,
}

impl FiveSpotTransient {
    /// The way to `steady` with the given `diffusivity` κ/s (m²/s) from a uniform `initial_pressure`
    /// (Pa), which stays the mean because the wells are balanced.
    ///
    /// # Errors
    /// [`ReferenceError`] where the diffusivity is not above zero or the pressure is not finite.
    pub fn new(
        steady: FiveSpot,
        diffusivity: f64,
        initial_pressure: f64,
    ) -> Result<Self, ReferenceError> {
        positive("diffusivity of the five-spot (m²/s)", diffusivity)?;
        finite("initial pressure of the five-spot (Pa)", initial_pressure)?;
        Ok(Self {
            steady,
            diffusivity,
            initial_pressure,
        })
    }
}

impl ExactPressure for FiveSpotTransient {
    fn name(&self) -> &'static str {
        "five_spot_transient"
    }

    /// The initial pressure up to t = 0; infinite at the wells afterwards.
    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let FiveSpot { side, scale, .. } = self.steady;
        let (x, y) = (
            self.steady.fraction(position, 0),
            self.steady.fraction(position, 1),
        );
        let tau = self.diffusivity * time / (side * side);
        let change = match tau {
            tau if tau <= 0.0 => 0.0,
            tau if tau <= EARLY => early(x, y, tau),
            tau => super::normalised(x, y) - lacking(x, y, tau),
        };
        self.initial_pressure + scale * change
    }

    fn excluded(&self) -> Vec<Exclusion> {
        self.steady.excluded()
    }
}

/// Sum over the nearest images of the wells, over the scale.
fn early(x: f64, y: f64, tau: f64) -> f64 {
    let mut sum = 0.0;
    for m in -IMAGES..=IMAGES {
        for n in -IMAGES..=IMAGES {
            let image = |shift: f64| {
                let (dx, dy) = (x - f64::from(2 * m) - shift, y - f64::from(2 * n) - shift);
                exponential_integral((dx * dx + dy * dy) / (4.0 * tau))
            };
            sum += image(0.0) - image(1.0);
        }
    }
    0.5 * sum
}

/// What the modes of the square still lack, over the scale: those with m + n odd are driven and decay
/// as exp(−(m² + n²) π² τ).
fn lacking(x: f64, y: f64, tau: f64) -> f64 {
    let most = (ROUNDING / (PI * PI * tau)).sqrt().ceil() as u32;
    let cosine = |order: u32, at: f64| (PI * f64::from(order) * at).cos();
    let mut sum = 0.0;
    for m in 0..=most {
        for n in (0..=most).filter(|n| (m + n) % 2 == 1) {
            let square = PI * PI * f64::from(m * m + n * n);
            // The mean square of a cosine is a half, that of the constant one.
            let norm = if m == 0 || n == 0 { 0.5 } else { 0.25 };
            // A quarter of the rate enters the square: Q/4κ is π/2 of the scale; at either well.
            sum += PI / (norm * square) * (-square * tau).exp() * cosine(m, x) * cosine(n, y);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::InjectorCorner;
    use super::*;

    const PLACES: [(f64, f64); 5] = [(0.1, 0.1), (0.5, 0.3), (0.0, 0.9), (0.9, 0.75), (0.3, 0.0)];

    fn unit() -> FiveSpot {
        FiveSpot::new(1.0, [0.0; 2], 1.0, InjectorCorner::LowerLeft).unwrap()
    }

    /// Two derivations of the same field, where both sums are short.
    #[test]
    fn images_and_modes_agree() {
        for tau in [0.02, 0.05, 0.1] {
            for (x, y) in PLACES {
                let (images, modes) = (
                    early(x, y, tau),
                    super::super::normalised(x, y) - lacking(x, y, tau),
                );
                // At 0.1 the images left out count a little.
                let bound = if tau > EARLY { 1e-8 } else { 1e-13 };
                assert!(
                    (images - modes).abs() < bound,
                    "{tau} ({x}, {y}): {images} {modes}"
                );
            }
        }
    }

    #[test]
    fn it_goes_from_the_initial_pressure_to_the_steady_one() {
        let spot = FiveSpot::new(2.0, [1.0, -1.0], 3.0, InjectorCorner::UpperLeft).unwrap();
        let exact = FiveSpotTransient::new(spot.clone(), 0.5, 7.0).unwrap();
        for (x, y) in PLACES {
            let at = [1.0 + 2.0 * x, -1.0 + 2.0 * y];
            assert!((exact.pressure(&at, 0.0) - 7.0).abs() < 1e-15);
            let gap = exact.pressure(&at, 40.0) - 7.0 - spot.pressure(&at, 0.0);
            assert!(gap.abs() < 1e-13, "{gap}");
            let end = exact.pressure(&at, f64::INFINITY) - 7.0 - spot.pressure(&at, 0.0);
            assert!(end.abs() < 1e-15, "{end}");
        }
        assert!(!exact.steady_only());
    }

    /// ∂p/∂t = ∇²p between the wells, on either side of where the sums change.
    #[test]
    fn it_solves_the_diffusion_equation() {
        let exact = FiveSpotTransient::new(unit(), 1.0, 0.0).unwrap();
        let (h, k) = (1e-3, 1e-6);
        for time in [0.01, 0.04, 0.06, 0.2] {
            let p = |x: f64, y: f64, t: f64| exact.pressure(&[x, y], t);
            let (x, y) = (0.4, 0.35);
            let around =
                p(x + h, y, time) + p(x - h, y, time) + p(x, y + h, time) + p(x, y - h, time);
            let laplacian = (around - 4.0 * p(x, y, time)) / (h * h);
            let rate = (p(x, y, time + k) - p(x, y, time - k)) / (2.0 * k);
            assert!(
                (laplacian - rate).abs() < 1e-4 * rate.abs().max(1.0),
                "{time}: {laplacian} {rate}"
            );
        }
    }

    #[test]
    fn no_storage_is_refused() {
        assert!(FiveSpotTransient::new(unit(), f64::INFINITY, 0.0).is_err());
        assert!(FiveSpotTransient::new(unit(), 0.0, 0.0).is_err());
    }
}
