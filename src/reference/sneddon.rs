//! Sneddon's crack: a straight crack under uniform pressure in an unbounded plane.

use super::error::positive;
use super::{ReferenceError, coordinate};

/// Opening of a pressurised straight crack in plane strain,
/// w(r) = 4 (1 − ν²) p/E √(a² − r²) at the distance r from its middle
/// (I. N. Sneddon, Proc. R. Soc. Lond. A 187, 1946, 229–260).
#[derive(Clone, Debug, PartialEq)]
pub struct Sneddon {
    /// Middle of the crack, m.
    pub middle: [f64; 2],
    /// Half its length a, m.
    pub half_length: f64,
    /// (1 − ν²)/E, 1/Pa.
    pub compliance: f64,
}

impl Sneddon {
    /// The solution for a crack of `half_length` (m) around `middle` in rock with Young's modulus
    /// (Pa) and Poisson's ratio.
    ///
    /// # Errors
    /// [`ReferenceError`] where the length or the modulus is not above zero.
    pub fn new(
        middle: [f64; 2],
        half_length: f64,
        youngs_modulus: f64,
        poissons_ratio: f64,
    ) -> Result<Self, ReferenceError> {
        positive("half length of the crack", half_length)?;
        positive("Young's modulus", youngs_modulus)?;
        Ok(Sneddon {
            middle,
            half_length,
            compliance: (1.0 - poissons_ratio * poissons_ratio) / youngs_modulus,
        })
    }

    /// Opening in m under `pressure` (Pa) at a `position` (m) on the crack; 0 beyond its tips.
    pub fn opening(&self, position: &[f64], pressure: f64) -> f64 {
        let from = |axis: usize| coordinate(position, axis) - self.middle[axis];
        let left = self.half_length.powi(2) - from(0).powi(2) - from(1).powi(2);
        4.0 * self.compliance * pressure * left.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opening_is_an_ellipse_of_the_known_area() {
        let sneddon = Sneddon::new([1.0, 2.0], 0.5, 10e9, 0.25).unwrap();
        let middle = sneddon.opening(&[1.0, 2.0], 1e6);
        assert!((middle - 4.0 * (1.0 - 0.0625) * 1e6 * 0.5 / 10e9).abs() < 1e-18);
        assert!(sneddon.opening(&[1.6, 2.0], 1e6).abs() <= 0.0);
        let parts = 20_000;
        let place = |k: usize| 0.5 + (k as f64 + 0.5) / f64::from(parts);
        let sum: f64 = (0..parts as usize)
            .map(|k| sneddon.opening(&[place(k), 2.0], 1e6))
            .sum();
        // π/2 · w₀ · a for the whole ellipse of the opening.
        let area = std::f64::consts::FRAC_PI_2 * middle * 0.5;
        assert!((sum / f64::from(parts) - area).abs() < 1e-5 * area);
    }
}
