//! The confined five-spot: one injector and one producer at opposite corners of a sealed square.
//!
//! Mirroring the square across its sides fills the plane with wells: injectors at (2mL, 2nL),
//! producers at ((2m+1)L, (2n+1)L). A row of equal wells with period 2L has the closed form
//! Σ ln r² = ln[2(cosh a − cos b)], a = π|y − y_row|/L, b = π(x − x_row)/L, which is
//! a + ln(1 − 2e⁻ᵃ cos b + e⁻²ᵃ). The logarithms die off like e⁻ᵃ, so their sum over rows
//! converges at once and cannot overflow. The parts linear in a sum up to the field of line sinks
//! and sources that alternate every L, which inside the square is π(½ − y/L).

mod transient;

use std::f64::consts::PI;

use super::error::{finite, positive};
use super::{ExactPressure, Exclusion, ReferenceError, coordinate};

pub use transient::FiveSpotTransient;

/// Rows of wells kept on each side; the first one dropped contributes less than e⁻¹³ᵖⁱ ≈ 2e-18.
const ROWS: i32 = 13;

/// e^−π, by which the waves of a row are smaller than those of the one before.
const ROW_DECAY: f64 = 0.043_213_918_263_772_26;

/// Part of the side length around each well that a comparison leaves out.
const EXCLUDED_FRACTION: f64 = 0.1;

/// ∫₀¹ −ln(s) w(s) ds for the kernel of Eq. 78, w = 2π²s(1 + cos πs)/(π² − 4).
const KERNEL_LOGARITHM: f64 = 0.960_583_803_925_396_4;

/// Quarter period K of the elliptic functions with parameter ½.
const QUARTER_PERIOD: f64 = 1.854_074_677_301_371_9;

/// Corner of the square at which the injector sits; the producer is at the opposite one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InjectorCorner {
    /// Least x, least y.
    #[default]
    LowerLeft,
    /// Greatest x, least y.
    LowerRight,
    /// Least x, greatest y.
    UpperLeft,
    /// Greatest x, greatest y.
    UpperRight,
}

impl InjectorCorner {
    /// Whether the injector is at the far end of the x axis and of the y axis.
    fn far_ends(self) -> [bool; 2] {
        match self {
            Self::LowerLeft => [false, false],
            Self::LowerRight => [true, false],
            Self::UpperLeft => [false, true],
            Self::UpperRight => [true, true],
        }
    }
}

/// Steady pressure of the confined five-spot (Sec. 5.3), zero on the diagonal between the wells.
#[derive(Clone, Debug, PartialEq)]
pub struct FiveSpot {
    side: f64,
    origin: [f64; 2],
    scale: f64,
    corner: InjectorCorner,
}

impl FiveSpot {
    /// A square of the given `side` (m) whose least corner is `origin` (m).
    ///
    /// `scale` is μ_f Q/2πK in Pa ([`FiveSpot::pressure_scale`]).
    ///
    /// # Errors
    /// [`ReferenceError`] where the side is not above zero or another parameter is not finite.
    pub fn new(
        side: f64,
        origin: [f64; 2],
        scale: f64,
        corner: InjectorCorner,
    ) -> Result<Self, ReferenceError> {
        positive("side of the five-spot (m)", side)?;
        finite("pressure scale of the five-spot (Pa)", scale)?;
        finite("x origin of the five-spot (m)", origin[0])?;
        finite("y origin of the five-spot (m)", origin[1])?;
        Ok(Self {
            side,
            origin,
            scale,
            corner,
        })
    }

    /// Pressure scale μ_f Q/2πK in Pa.
    ///
    /// `rate` is the volume rate per metre of thickness of the whole well, m²/s, of which a quarter
    /// enters the square; `mobility` is K/μ_f, m²/(Pa·s).
    #[must_use]
    pub fn pressure_scale(rate: f64, mobility: f64) -> f64 {
        rate / (2.0 * PI * mobility)
    }

    /// Pressure in Pa at the centre of the injector when its rate is spread over `radius` λ (m) by
    /// the kernel of Eq. 78; the producer has the opposite value.
    ///
    /// p = (μ_f Q/2πK) [ln(√2 L/K_e) − ln λ + 0.9605838039]. Holds while the kernel reaches no
    /// further than the nearest image well, λ ≤ √2 L.
    ///
    /// # Errors
    /// [`ReferenceError::NotPositive`] where the radius is not above zero.
    pub fn well_pressure(&self, radius: f64) -> Result<f64, ReferenceError> {
        positive("radius of the well kernel (m)", radius)?;
        let regular = (std::f64::consts::SQRT_2 * self.side / (QUARTER_PERIOD * radius)).ln();
        Ok(self.scale * (regular + KERNEL_LOGARITHM))
    }

    /// Positions of the injector and the producer, m.
    #[must_use]
    pub fn wells(&self) -> [[f64; 2]; 2] {
        let end = |axis: usize, far: bool| self.origin[axis] + if far { self.side } else { 0.0 };
        let [x, y] = self.corner.far_ends();
        [[end(0, x), end(1, y)], [end(0, !x), end(1, !y)]]
    }

    /// Coordinate as a fraction of the side, measured from the injector and folded into the square.
    fn fraction(&self, position: &[f64], axis: usize) -> f64 {
        let fraction = (coordinate(position, axis) - self.origin[axis]) / self.side;
        let from_injector = if self.corner.far_ends()[axis] {
            1.0 - fraction
        } else {
            fraction
        };
        let folded = from_injector.rem_euclid(2.0);
        if folded > 1.0 { 2.0 - folded } else { folded }
    }
}

impl ExactPressure for FiveSpot {
    fn name(&self) -> &'static str {
        "five_spot"
    }

    /// Outside the square the mirrored field is given; a third coordinate is ignored.
    fn pressure(&self, position: &[f64], _time: f64) -> f64 {
        self.scale * normalised(self.fraction(position, 0), self.fraction(position, 1))
    }

    fn steady_only(&self) -> bool {
        true
    }

    fn excluded(&self) -> Vec<Exclusion> {
        let radius = EXCLUDED_FRACTION * self.side;
        self.wells()
            .iter()
            .map(|well| Exclusion {
                centre: well.to_vec(),
                radius,
            })
            .collect()
    }
}

/// Pressure over scale at (x, y) in the unit square, injector at the origin.
fn normalised(x: f64, y: f64) -> f64 {
    // Sines of both half-angles, so that either well is met exactly.
    let (sine, cosine) = ((0.5 * PI * x).sin(), (0.5 * PI * (1.0 - x)).sin());
    let squares = [4.0 * sine * sine, 4.0 * cosine * cosine];
    let below = rows(PI * y, squares);
    let above = rows(PI * (1.0 - y), [squares[1], squares[0]]);
    0.5 * (PI * (0.5 - y) + ((below[1] * above[0]) / (below[0] * above[1])).ln())
}

/// Products of 1 − 2e⁻ᵃ cos b + e⁻²ᵃ over every other row on one side, the nearest one first, and over those between;
/// `distance` is a of the nearest, `squares` are 4 sin²(b/2) of both kinds. All rows but the nearest are at π and more,
/// where e⁻ᵃ is that of the row before times e^−π.
fn rows(distance: f64, squares: [f64; 2]) -> [f64; 2] {
    let gap = -(-distance).exp_m1();
    let mut wave = 1.0 - gap;
    let mut products = [gap * gap + wave * squares[0], 1.0];
    for row in 1..=ROWS as usize {
        wave *= ROW_DECAY;
        let gap = 1.0 - wave;
        products[row % 2] *= gap * gap + wave * squares[row % 2];
    }
    products
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    /// As [`normalised`], with a logarithm for every row.
    fn by_logarithms(x: f64, y: f64) -> f64 {
        // Sines of both half-angles, so that either well is met exactly.
        let (sine, cosine) = ((0.5 * PI * x).sin(), (0.5 * PI * (1.0 - x)).sin());
        let mut sum = PI * (0.5 - y);
        for row in (-ROWS..=ROWS + 1).rev() {
            let distance = PI * (y - f64::from(row)).abs();
            if row % 2 == 0 {
                sum -= row_logarithm(distance, sine);
            } else {
                sum += row_logarithm(distance, cosine);
            }
        }
        0.5 * sum
    }

    /// ln(1 − 2e⁻ᵃ cos b + e⁻²ᵃ), from a and sin(b/2) so that nothing cancels near a well.
    fn row_logarithm(distance: f64, half_angle_sine: f64) -> f64 {
        let gap = -(-distance).exp_m1();
        (gap * gap + 4.0 * (-distance).exp() * half_angle_sine * half_angle_sine).ln()
    }

    #[test]
    fn one_logarithm_of_all_rows_is_the_sum_of_theirs() {
        for place in 0..400 {
            let (x, y) = (f64::from(place % 20) / 19.0, f64::from(place / 20) / 19.0);
            let (fast, slow) = (normalised(x, y), by_logarithms(x, y));
            assert!(
                (fast - slow).abs() < 2e-14 || fast.to_bits() == slow.to_bits(),
                "{x} {y}"
            );
        }
        for near in [1e-3, 1e-8, 1e-14] {
            let (fast, slow) = (
                normalised(near, 2.0 * near),
                by_logarithms(near, 2.0 * near),
            );
            assert!((fast - slow).abs() < 2e-14 * slow.abs());
        }
    }

    fn unit() -> FiveSpot {
        FiveSpot::new(1.0, [0.0; 2], 1.0, InjectorCorner::LowerLeft).unwrap()
    }

    /// ln(√2 |dn/sn|) through theta functions with nome e^(−π).
    fn elliptic(x: f64, y: f64) -> f64 {
        let nome = (-PI).exp();
        let v = Complex64::new(x, y) * (0.5 * PI);
        let (mut theta_1, mut theta_3) = (Complex64::ZERO, Complex64::ONE);
        let (mut zero_2, mut zero_3, mut zero_4) = (0.0, 1.0, 1.0);
        for n in 0..12_i32 {
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            let odd = 2.0 * nome.powf((f64::from(n) + 0.5).powi(2));
            theta_1 += (v * f64::from(2 * n + 1)).sin() * sign * odd;
            zero_2 += odd;
            let even = 2.0 * nome.powi((n + 1) * (n + 1));
            theta_3 += (v * f64::from(2 * (n + 1))).cos() * even;
            zero_3 += even;
            zero_4 -= sign * even;
        }
        let ratio = theta_3 / theta_1 * (zero_2 * zero_4 / (zero_3 * zero_3));
        (std::f64::consts::SQRT_2 * ratio.norm()).ln()
    }

    #[test]
    fn diagonal_values_match_the_table() {
        let table = [
            (0.05, 2.378_339_142_5),
            (0.1, 1.685_081_172_5),
            (0.2, 0.990_160_246_9),
            (0.3, 0.576_984_531_7),
            (0.4, 0.268_342_509_3),
            (0.5, 0.0),
        ];
        for (s, expected) in table {
            let found = unit().pressure(&[s, s], 0.0);
            assert!(
                (found - expected).abs() < 6e-11,
                "s = {s}: {found}, not {expected}"
            );
        }
    }

    #[test]
    fn image_rows_agree_with_elliptic_functions() {
        for i in 0..=20 {
            for j in 0..=20 {
                let (x, y) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                if (i, j) == (0, 0) || (i, j) == (20, 20) {
                    continue;
                }
                let (rows, functions) = (normalised(x, y), elliptic(x, y));
                assert!(
                    (rows - functions).abs() < 1e-12,
                    "({x}, {y}): {rows} {functions}"
                );
            }
        }
        for offset in [1e-3, 1e-6, 1e-12] {
            let (rows, functions) = (normalised(offset, offset), elliptic(offset, offset));
            assert!(
                (rows - functions).abs() < 1e-12,
                "{offset}: {rows} {functions}"
            );
        }
    }

    #[test]
    fn the_square_is_sealed_and_balanced() {
        let (spot, h) = (unit(), 1e-5);
        for s in [0.15, 0.5, 0.8] {
            let slope = spot.pressure(&[h, s], 0.0) - spot.pressure(&[0.0, s], 0.0);
            assert!(slope.abs() < 1e-8, "flow across the side at {s}: {slope}");
            let (near, far) = (
                spot.pressure(&[s, 0.3], 0.0),
                spot.pressure(&[1.0 - s, 0.7], 0.0),
            );
            assert!((near + far).abs() < 1e-13);
            assert!(spot.pressure(&[s, 1.0 - s], 0.0).abs() < 1e-13);
        }
    }

    /// Darcy flux through a quarter circle about the injector, K/μ_f = 1/(2π) and Q = scale.
    #[test]
    fn a_quarter_of_the_rate_enters_the_square() {
        let (spot, h, radius, arcs) = (unit(), 1e-5, 0.3, 400);
        let mean_slope: f64 = (0..arcs)
            .map(|arc| {
                let (sine, cosine) =
                    ((f64::from(arc) + 0.5) * 0.5 * PI / f64::from(arcs)).sin_cos();
                let at = |r: f64| spot.pressure(&[r * cosine, r * sine], 0.0);
                (at(radius + h) - at(radius - h)) / (2.0 * h)
            })
            .sum::<f64>()
            / f64::from(arcs);
        assert!(
            (mean_slope * radius + 1.0).abs() < 1e-8,
            "{}",
            mean_slope * radius
        );
    }

    #[test]
    fn every_corner_gives_the_same_field_turned() {
        let base = unit();
        let (x, y) = (0.2, 0.35);
        let expected = 3.0 * base.pressure(&[x, y], 0.0);
        for (corner, at) in [
            (InjectorCorner::LowerLeft, [x, y]),
            (InjectorCorner::LowerRight, [1.0 - x, y]),
            (InjectorCorner::UpperLeft, [x, 1.0 - y]),
            (InjectorCorner::UpperRight, [1.0 - x, 1.0 - y]),
        ] {
            let spot = FiveSpot::new(2.0, [-5.0, 7.0], 3.0, corner).unwrap();
            let position = [-5.0 + 2.0 * at[0], 7.0 + 2.0 * at[1], 0.4];
            assert!(
                (spot.pressure(&position, 9.0) - expected).abs() < 1e-12,
                "{corner:?}"
            );
            let [injector, producer] = spot.wells();
            let at_wells = [injector, producer].map(|well| spot.pressure(&well, 0.0));
            let opposite = at_wells[0] > 0.0 && at_wells[1] < 0.0;
            assert!(
                opposite && at_wells.iter().all(|p| p.is_infinite()),
                "{corner:?}"
            );
            assert!(
                spot.excluded()
                    .iter()
                    .all(|e| (e.radius - 0.2).abs() < 1e-15)
            );
        }
    }

    /// Mean of the exact field over the kernel of Eq. 78, by quadrature over rings and angles.
    #[test]
    fn the_spread_well_has_the_kernel_mean_of_the_exact_field() {
        let (spot, radius, rings, arcs) = (unit(), 0.2, 4000, 16);
        let mut mean = 0.0;
        for ring in 0..rings {
            let s = ((f64::from(ring) + 0.5) / f64::from(rings)).powi(2);
            let jacobian = 2.0 * s.sqrt() / f64::from(rings);
            let weight = 2.0 * PI * PI * s * (1.0 + (PI * s).cos()) / (PI * PI - 4.0);
            let around: f64 = (0..arcs)
                .map(|arc| {
                    let angle = (f64::from(arc) + 0.5) * 0.5 * PI / f64::from(arcs);
                    spot.pressure(&[radius * s * angle.cos(), radius * s * angle.sin()], 0.0)
                })
                .sum::<f64>()
                / f64::from(arcs);
            mean += weight * around * jacobian;
        }
        let expected = spot.well_pressure(radius).unwrap();
        assert!((mean - expected).abs() < 1e-6, "{mean} {expected}");
        assert!(spot.well_pressure(0.0).is_err());
    }

    #[test]
    fn the_paper_has_its_pressure_scale() {
        let scale = FiveSpot::pressure_scale(1e-3, 1e-13 / 1e-3);
        assert!((scale / 1_591_549.431 - 1.0).abs() < 1e-9, "{scale}");
    }

    #[test]
    fn an_impossible_square_is_refused() {
        let bad = FiveSpot::new(-1.0, [0.0; 2], 1.0, InjectorCorner::LowerLeft);
        assert!(matches!(bad, Err(ReferenceError::NotPositive { .. })));
        let bad = FiveSpot::new(1.0, [0.0; 2], f64::NAN, InjectorCorner::LowerLeft);
        assert!(matches!(bad, Err(ReferenceError::NotFinite { .. })));
    }
}
