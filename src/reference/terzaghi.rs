//! The Terzaghi solution: consolidation of a column loaded at its drained end.

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

use super::error::{finite, positive};
use super::{ExactDisplacement, ExactPressure, ReferenceError, coordinate};

/// Time factor c_v t/L² below which images are summed instead of eigenfunctions.
const SWITCH: f64 = 0.1;

/// Number of eigenfunctions: from [`SWITCH`] on, the first one left out is below e⁻⁷⁰.
const MODES: u32 = 8;

/// Pairs of images: up to [`SWITCH`], those left out are below erfc(6/2√0.1) ≈ 5e-41.
const IMAGE_PAIRS: u32 = 3;

/// What describes a Terzaghi problem.
#[derive(Clone, Debug, PartialEq)]
pub struct TerzaghiParameters {
    /// Index of the axis the column lies along: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the end that is loaded and drained (p = 0), m.
    pub drained_end: f64,
    /// Coordinate of the end that is fixed and sealed, m; on either side of the drained one.
    pub sealed_end: f64,
    /// Load P₀ on the drained end from t = 0 on, Pa; compression positive.
    pub load: f64,
    /// Oedometer modulus M = λ + 2μ of the drained rock, Pa.
    pub oedometer_modulus: f64,
    /// Biot coefficient α.
    pub biot_coefficient: f64,
    /// Storage S, 1/Pa.
    pub storage: f64,
    /// Mobility κ = K/μ_f, m²/(Pa·s).
    pub mobility: f64,
}

/// Uniaxial consolidation; s is the distance from the drained end, L the length of the column.
///
/// p = (4γP₀/π) Σ 1/(2i+1) e^(−m²c_v t) sin(ms) and, towards the sealed end,
/// u = P₀(L−s)/M − (αγP₀/M)(8L/π²) Σ 1/(2i+1)² e^(−m²c_v t) cos(ms), with m = (2i+1)π/2L
/// (H. F. Wang, Theory of Linear Poroelasticity, Princeton University Press, 2000). At early
/// times the same field is summed from its images at the ends, which are complementary error
/// functions. Either way the result is accurate to rounding error at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct Terzaghi(TerzaghiParameters);

impl Terzaghi {
    /// The solution for `parameters`.
    ///
    /// # Errors
    /// [`ReferenceError`] where there is no such axis, the ends coincide, the modulus, the Biot
    /// coefficient, the storage or the mobility is not above zero, or a number is not finite.
    pub fn new(parameters: TerzaghiParameters) -> Result<Self, ReferenceError> {
        if parameters.axis > 2 {
            return Err(ReferenceError::WrongDimension {
                subject: "space, counted up to the axis of the Terzaghi column",
                found: parameters.axis.saturating_add(1),
                least: 1,
                most: 3,
            });
        }
        finite("drained end of the column (m)", parameters.drained_end)?;
        finite("sealed end of the column (m)", parameters.sealed_end)?;
        finite("load on the column (Pa)", parameters.load)?;
        for (name, value) in [
            ("oedometer modulus (Pa)", parameters.oedometer_modulus),
            ("Biot coefficient", parameters.biot_coefficient),
            ("storage (1/Pa)", parameters.storage),
            ("mobility (m²/(Pa·s))", parameters.mobility),
        ] {
            positive(name, value)?;
        }
        let solution = Self(parameters);
        positive("length of the column (m)", solution.length())?;
        Ok(solution)
    }

    /// The parameters it was made from.
    #[must_use]
    pub fn parameters(&self) -> &TerzaghiParameters {
        &self.0
    }

    /// Loading efficiency γ = (α/M)/(S + α²/M): undrained pressure over load.
    #[must_use]
    pub fn loading_efficiency(&self) -> f64 {
        self.0.biot_coefficient / self.0.oedometer_modulus / self.confined_storage()
    }

    /// Consolidation coefficient c_v = κ/(S + α²/M), m²/s.
    #[must_use]
    pub fn consolidation_coefficient(&self) -> f64 {
        self.0.mobility / self.confined_storage()
    }

    /// Pressure γP₀ just after loading, Pa.
    #[must_use]
    pub fn undrained_pressure(&self) -> f64 {
        self.loading_efficiency() * self.0.load
    }

    /// Storage at constant uniaxial stress S + α²/M, 1/Pa.
    fn confined_storage(&self) -> f64 {
        self.0.storage + self.0.biot_coefficient.powi(2) / self.0.oedometer_modulus
    }

    /// Length of the column L, m.
    fn length(&self) -> f64 {
        (self.0.sealed_end - self.0.drained_end).abs()
    }

    /// Distance from the drained end over the length, NaN where the position lacks the axis.
    fn relative_distance(&self, position: &[f64]) -> f64 {
        let end = self.0.drained_end;
        (coordinate(position, self.0.axis) - end) / (self.0.sealed_end - end)
    }

    /// Time factor c_v t/L².
    fn time_factor(&self, time: f64) -> f64 {
        self.consolidation_coefficient() * time / self.length().powi(2)
    }
}

impl ExactPressure for Terzaghi {
    fn name(&self) -> &'static str {
        "terzaghi"
    }

    /// The undrained pressure everywhere up to t = 0, the drained end included.
    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let distance = self.relative_distance(position);
        self.undrained_pressure() * Excess::at(distance, self.time_factor(time)).pressure
    }
}

impl ExactDisplacement for Terzaghi {
    /// Towards the sealed end for a compressive load; zero across the column. The undrained state
    /// up to t = 0. NaN where `position` lacks the axis of the column.
    fn displacement(&self, position: &[f64], time: f64) -> Vec<f64> {
        let distance = self.relative_distance(position);
        let excess = Excess::at(distance, self.time_factor(time));
        let coupling = self.0.biot_coefficient * self.loading_efficiency();
        let strain = self.0.load / self.0.oedometer_modulus;
        let span = self.0.sealed_end - self.0.drained_end;
        let along = strain * span * ((1.0 - distance) - coupling * excess.beyond);
        let across = if along.is_nan() { f64::NAN } else { 0.0 };
        (0..position.len())
            .map(|axis| if axis == self.0.axis { along } else { across })
            .collect()
    }
}

/// Pressure over the undrained one, at a distance x from the drained end in column lengths.
#[derive(Clone, Copy, Debug)]
struct Excess {
    /// p(x)/(γP₀).
    pressure: f64,
    /// Its integral from x to the sealed end, over L.
    beyond: f64,
}

impl Excess {
    fn at(x: f64, time_factor: f64) -> Self {
        if time_factor <= 0.0 {
            Self {
                // Zero times x lets a missing coordinate through as NaN.
                pressure: 1.0 + 0.0 * x,
                beyond: 1.0 - x,
            }
        } else if time_factor < SWITCH {
            Self::from_images(x, time_factor)
        } else {
            Self::from_modes(x, time_factor)
        }
    }

    /// Σ (4/π)/(2i+1) e^(−m²T) sin(mx), m = (2i+1)π/2.
    fn from_modes(x: f64, time_factor: f64) -> Self {
        let (mut pressure, mut beyond) = (0.0, 0.0);
        for mode in 0..MODES {
            let wave_number = f64::from(2 * mode + 1) * (PI / 2.0);
            let decay = (-wave_number.powi(2) * time_factor).exp();
            pressure += 2.0 / wave_number * decay * (wave_number * x).sin();
            beyond += 2.0 / wave_number.powi(2) * decay * (wave_number * x).cos();
        }
        Self { pressure, beyond }
    }

    /// 1 − Σ (−1)ⁿ [erfc((2n+x)/2√T) + erfc((2n+2−x)/2√T)], the first term taken as erf so that
    /// the pressure keeps its digits near the drained end.
    fn from_images(x: f64, time_factor: f64) -> Self {
        let reach = 2.0 * time_factor.sqrt();
        let mut pressure = erf(x / reach);
        let mut beyond = 1.0 - x;
        let mut sign = 1.0;
        for pair in 0..IMAGE_PAIRS {
            let start = f64::from(2 * pair);
            let (near, far) = ((start + x) / reach, (start + 2.0 - x) / reach);
            if pair > 0 {
                pressure -= sign * erfc(near);
            }
            pressure -= sign * erfc(far);
            beyond -= sign * reach * (integrated_erfc(near) - integrated_erfc(far));
            sign = -sign;
        }
        Self { pressure, beyond }
    }
}

/// Argument from which the continued fraction of erfc is used.
const FRACTION_FROM: f64 = 1.5;

/// Error function erf(x) = (2/√π) ∫₀ˣ e^(−t²) dt, to about 1e-15 of its value.
fn erf(x: f64) -> f64 {
    if x.abs() < FRACTION_FROM {
        erf_series(x)
    } else {
        x.signum() * (1.0 - erfc_fraction(x.abs()))
    }
}

/// Complementary error function 1 − erf(x), to about 3e-14 of its value.
pub(super) fn erfc(x: f64) -> f64 {
    if x >= FRACTION_FROM {
        erfc_fraction(x)
    } else {
        1.0 - erf(x)
    }
}

/// ∫ₓ^∞ erfc(t) dt (DLMF 7.18.1), to about 1e-16 absolute.
fn integrated_erfc(x: f64) -> f64 {
    (-x * x).exp() * (FRAC_2_SQRT_PI / 2.0) - x * erfc(x)
}

/// (2/√π) e^(−x²) Σ 2ⁿ x²ⁿ⁺¹/(1·3···(2n+1)) (DLMF 7.6.2): terms of one sign, so no cancellation.
fn erf_series(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for n in 1..=60 {
        term *= 2.0 * x * x / f64::from(2 * n + 1);
        sum += term;
        if term.abs() <= 1e-17 * sum.abs() {
            break;
        }
    }
    FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

/// e^(−x²)/√π · 1/(x + ½/(x + 1/(x + 3⁄2/(x + …)))) (DLMF 7.9.1), from the inside out.
///
/// The depth needed for a given precision falls as 1/x²; the one taken leaves less than 1e-17.
fn erfc_fraction(x: f64) -> f64 {
    let depth = (20.0 + 200.0 / (x * x)) as u32;
    let tail = (1..=depth)
        .rev()
        .fold(0.0, |tail, n| f64::from(n) / 2.0 / (x + tail));
    FRAC_2_SQRT_PI / 2.0 * (-x * x).exp() / (x + tail)
}

#[cfg(test)]
#[path = "terzaghi_tests.rs"]
mod tests;
