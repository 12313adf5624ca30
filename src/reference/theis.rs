//! The Theis solution: a line source in an unbounded plane.

use std::f64::consts::PI;

use super::error::{finite, positive};
use super::{ExactPressure, Exclusion, ReferenceError, coordinate, exponential_integral};

/// What describes a Theis problem.
#[derive(Clone, Debug, PartialEq)]
pub struct TheisParameters {
    /// Position of the well in the plane, m.
    pub well: [f64; 2],
    /// Volume rate per metre of thickness, m²/s; positive injects.
    pub rate: f64,
    /// Mobility κ = K/μ_f, m²/(Pa·s).
    pub mobility: f64,
    /// Tensor of the mobility in units of it: xx, yy, xy; `[1, 1, 0]` where flow has no preferred direction.
    pub shape: [f64; 3],
    /// Storage S, 1/Pa.
    pub storage: f64,
    /// Pressure before the well starts at t = 0, Pa.
    pub initial_pressure: f64,
    /// Radius around the well that a comparison leaves out, m.
    pub excluded_radius: f64,
}

/// p = p₀ + Q/(4π √det κ) E₁(r·κ⁻¹r S/4t), with a tensor κ (Papadopulos 1965, Nonsteady flow to a well in an infinite
/// anisotropic aquifer); for κ = κI it is Q/(4πκ) E₁(r² S/4κt).
#[derive(Clone, Debug, PartialEq)]
pub struct Theis(TheisParameters);

impl Theis {
    /// The solution for `parameters`.
    ///
    /// # Errors
    /// [`ReferenceError`] where mobility or storage is not above zero, the excluded radius is
    /// negative, or another parameter is not finite.
    pub fn new(parameters: TheisParameters) -> Result<Self, ReferenceError> {
        positive(
            "mobility of the Theis problem (m²/(Pa·s))",
            parameters.mobility,
        )?;
        positive("storage of the Theis problem (1/Pa)", parameters.storage)?;
        let [xx, yy, xy] = parameters.shape;
        positive("xx of the tensor of the Theis problem", xx)?;
        positive(
            "determinant of the tensor of the Theis problem",
            xx * yy - xy * xy,
        )?;
        finite("x of the Theis well (m)", parameters.well[0])?;
        finite("y of the Theis well (m)", parameters.well[1])?;
        finite("rate of the Theis well (m²/s)", parameters.rate)?;
        finite(
            "initial pressure of the Theis problem (Pa)",
            parameters.initial_pressure,
        )?;
        let radius = parameters.excluded_radius;
        if radius.abs() > 0.0 || radius.is_nan() {
            positive("excluded radius of the Theis well (m)", radius)?;
        }
        Ok(Self(parameters))
    }

    /// r·κ⁻¹r S/4, s.
    pub(super) fn argument(&self, position: &[f64]) -> f64 {
        let [x, y] = [0, 1].map(|axis| coordinate(position, axis) - self.0.well[axis]);
        let [xx, yy, xy] = self.0.shape;
        let determinant = xx * yy - xy * xy;
        let squared = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant;
        squared * self.0.storage / (4.0 * self.0.mobility)
    }

    /// 1/(4π √det κ), Pa s/m².
    pub(super) fn scale(&self) -> f64 {
        let [xx, yy, xy] = self.0.shape;
        1.0 / (4.0 * PI * self.0.mobility * (xx * yy - xy * xy).sqrt())
    }

    /// The parameters it was made from.
    #[must_use]
    pub fn parameters(&self) -> &TheisParameters {
        &self.0
    }
}

impl ExactPressure for Theis {
    fn name(&self) -> &'static str {
        "theis"
    }

    /// The initial pressure up to t = 0; infinite at the well afterwards. A third coordinate is
    /// ignored.
    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let start = self.0.initial_pressure;
        if time <= 0.0 {
            return start;
        }
        let argument = self.argument(position) / time;
        start + self.0.rate * self.scale() * exponential_integral(argument)
    }

    fn excluded(&self) -> Vec<Exclusion> {
        vec![Exclusion {
            centre: self.0.well.to_vec(),
            radius: self.0.excluded_radius,
        }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Theis {
        Theis::new(TheisParameters {
            well: [1.0, -2.0],
            rate: 3e-4,
            mobility: 1e-10,
            shape: [1.0, 1.0, 0.0],
            storage: 2e-9,
            initial_pressure: 5e5,
            excluded_radius: 0.1,
        })
        .unwrap()
    }

    #[test]
    fn pressure_is_the_scale_times_e1() {
        let theis = example();
        // r² S/4κt = 1 at r = 2 m, t = 20 s, and E₁(1) = 0.219383934395520274.
        let expected = 5e5 + 3e-4 / (4.0 * PI * 1e-10) * 0.219_383_934_395_520_27;
        let found = theis.pressure(&[3.0, -2.0, 8.0], 20.0);
        assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
    }

    #[test]
    fn it_satisfies_the_radial_diffusion_equation() {
        let (theis, h, dt) = (example(), 1e-3, 1e-2);
        for (radius, time) in [(0.5, 5.0), (2.0, 30.0), (1.0, 2.0)] {
            let at = |x: f64, y: f64, t: f64| theis.pressure(&[1.0 + x, -2.0 + y], t);
            let centre = at(radius, 0.0, time);
            let laplacian = (at(radius + h, 0.0, time)
                + at(radius - h, 0.0, time)
                + at(radius, h, time)
                + at(radius, -h, time)
                - 4.0 * centre)
                / (h * h);
            let rate = (at(radius, 0.0, time + dt) - at(radius, 0.0, time - dt)) / (2.0 * dt);
            let (storing, flowing) = (2e-9 * rate, 1e-10 * laplacian);
            assert!(
                (storing / flowing - 1.0).abs() < 1e-3,
                "{storing} {flowing}"
            );
        }
    }

    /// ∫ S (p − p₀) dA = Q t.
    #[test]
    fn the_stored_volume_is_the_injected_one() {
        let (theis, time, steps) = (example(), 10.0, 20_000);
        let reach = 20.0;
        let stored: f64 = (0..steps)
            .map(|step| {
                let radius = (f64::from(step) + 0.5) * reach / f64::from(steps);
                let rise = theis.pressure(&[1.0, -2.0 + radius], time) - 5e5;
                2e-9 * rise * 2.0 * PI * radius * reach / f64::from(steps)
            })
            .sum();
        assert!((stored / (3e-4 * time) - 1.0).abs() < 1e-6, "{stored}");
    }

    #[test]
    fn before_the_start_nothing_happened_and_the_well_is_singular() {
        let theis = example();
        for time in [-1.0, 0.0, 1e-6] {
            assert!((theis.pressure(&[9.0, 9.0], time) - 5e5).abs() < 1e-9);
        }
        assert!(theis.pressure(&[1.0, -2.0], 1.0).is_infinite());
        assert!(theis.excluded()[0].contains(&[1.05, -2.05, 3.0]));
    }

    #[test]
    fn impossible_parameters_are_named() {
        let mut parameters = example().parameters().clone();
        parameters.storage = 0.0;
        let message = Theis::new(parameters).unwrap_err().to_string();
        assert!(message.contains("storage"), "{message}");
    }
}
