//! The Mandel solution: a poroelastic strip squeezed between rigid plates, in plane strain.

use std::f64::consts::PI;

use super::error::{finite, positive};
use super::terzaghi::erfc;
use super::{ExactDisplacement, ExactPressure, ReferenceError, coordinate};

/// Time factor ct/a² below which the early-time form is used: it leaves out erfc(1/√T) < 4e-19.
const SWITCH: f64 = 0.025;

/// Number of eigenfunctions: from [`SWITCH`] on, the first one left out is below e⁻⁴⁸.
const MODES: usize = 14;

/// Most Newton steps for a root; six are usual.
const NEWTON_STEPS: u32 = 60;

/// What describes a Mandel problem. The other axis of the plane than `drained_axis` is loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct MandelParameters {
    /// Half-width a of the strip along the drained axis, m.
    pub half_width: f64,
    /// Height of the modelled half, from the plane of symmetry to the plate, m.
    pub height: f64,
    /// Centre of symmetry in the plane, m.
    pub origin: [f64; 2],
    /// Axis along which the fluid leaves: 0 (the plates press along y) or 1 (along x).
    pub drained_axis: usize,
    /// Force F on half a plate from t = 0 on, per metre of depth, N/m; compression positive.
    pub force: f64,
    /// First Lamé parameter λ of the drained rock, Pa.
    pub lame_lambda: f64,
    /// Shear modulus μ, Pa.
    pub shear_modulus: f64,
    /// Biot coefficient α.
    pub biot_coefficient: f64,
    /// Storage S, 1/Pa.
    pub storage: f64,
    /// Mobility κ = K/μ_f, m²/(Pa·s).
    pub mobility: f64,
}

/// A strip |x| ≤ a, drained and free at its sides, under rigid smooth sealed plates.
///
/// With the roots A of tan A = A(1−ν)/(ν_u−ν), D = A − sin A cos A and E = e^(−A²ct/a²),
/// p = (2FB(1+ν_u)/3a) Σ sin A/D (cos(Ax/a) − cos A) E,
/// u_y = (F/μa) [−(1−ν)/2 + (1−ν_u) G] y,  G = Σ sin A cos A/D E,
/// u_x = (F/μa) [ν/2 − ν_u G] x + (F/μ) Σ cos A/D sin(Ax/a) E
/// (J. Mandel, Géotechnique 3, 1953; A. H.-D. Cheng and E. Detournay, Int. J. Numer. Anal. Methods
/// Geomech. 12, 1988). At early times the Laplace transform is inverted in closed form instead, so
/// the result is accurate to rounding error at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct Mandel {
    parameters: MandelParameters,
    /// (ν_u−ν)/(1−ν), above 0 and at most ¾.
    coupling: f64,
    modes: [Mode; MODES],
}

impl Mandel {
    /// The solution for `parameters`.
    ///
    /// # Errors
    /// [`ReferenceError`] where the drained axis is not in the plane, a size, the shear modulus, the
    /// bulk modulus λ + 2μ/3, the Biot coefficient, the storage or the mobility is not above zero,
    /// or a number is not finite.
    pub fn new(parameters: MandelParameters) -> Result<Self, ReferenceError> {
        check(&parameters)?;
        let coupling = coupling(&parameters);
        positive("(ν_u−ν)/(1−ν) of the Mandel problem", coupling)?;
        Ok(Self {
            parameters,
            coupling,
            modes: std::array::from_fn(|index| Mode::new(index, coupling)),
        })
    }

    /// The parameters it was made from.
    #[must_use]
    pub fn parameters(&self) -> &MandelParameters {
        &self.parameters
    }

    /// Drained Poisson ratio ν = λ/2(λ+μ).
    #[must_use]
    pub fn poisson_ratio(&self) -> f64 {
        let MandelParameters {
            lame_lambda,
            shear_modulus,
            ..
        } = self.parameters;
        lame_lambda / (2.0 * (lame_lambda + shear_modulus))
    }

    /// Undrained Poisson ratio ν_u = λ_u/2(λ_u+μ), with λ_u = λ + α²/S.
    #[must_use]
    pub fn undrained_poisson_ratio(&self) -> f64 {
        let lambda = self.parameters.lame_lambda + stiffening(&self.parameters);
        lambda / (2.0 * (lambda + self.parameters.shear_modulus))
    }

    /// Skempton coefficient B = α/(S K_u), with the undrained bulk modulus K_u = λ + 2μ/3 + α²/S.
    #[must_use]
    pub fn skempton_coefficient(&self) -> f64 {
        let undrained_bulk = bulk_modulus(&self.parameters) + stiffening(&self.parameters);
        self.parameters.biot_coefficient / self.parameters.storage / undrained_bulk
    }

    /// Consolidation coefficient c = κ/(S + α²/(λ+2μ)), m²/s.
    #[must_use]
    pub fn consolidation_coefficient(&self) -> f64 {
        let p = &self.parameters;
        let oedometer = p.lame_lambda + 2.0 * p.shear_modulus;
        p.mobility / (p.storage + p.biot_coefficient.powi(2) / oedometer)
    }

    /// Pressure FB(1+ν_u)/3a just after loading, Pa.
    #[must_use]
    pub fn undrained_pressure(&self) -> f64 {
        self.parameters.force / self.parameters.half_width
            * self.skempton_coefficient()
            * (1.0 + self.undrained_poisson_ratio())
            / 3.0
    }

    /// Displacement of the plate away from the plane of symmetry at `time` (s), m: below zero for a
    /// compressive force.
    #[must_use]
    pub fn plate_displacement(&self, time: f64) -> f64 {
        self.plate_strain(self.relaxation(self.time_factor(time))) * self.parameters.height
    }

    /// u_y/y for the sum G.
    fn plate_strain(&self, relaxation: f64) -> f64 {
        self.unit_strain()
            * ((1.0 - self.undrained_poisson_ratio()) * relaxation
                - (1.0 - self.poisson_ratio()) / 2.0)
    }

    /// F/μa.
    fn unit_strain(&self) -> f64 {
        self.parameters.force / self.parameters.shear_modulus / self.parameters.half_width
    }

    /// Time factor ct/a².
    fn time_factor(&self, time: f64) -> f64 {
        self.consolidation_coefficient() * time / self.parameters.half_width.powi(2)
    }

    /// Coordinates from the centre in the plane, m: along the drained and along the loaded axis.
    fn local(&self, position: &[f64]) -> (f64, f64) {
        let origin = &self.parameters.origin;
        let [x, y] = [0, 1].map(|axis| coordinate(position, axis) - origin[axis]);
        if self.parameters.drained_axis == 0 {
            (x, y)
        } else {
            (y, x)
        }
    }

    /// State at `x` half-widths from the centre.
    fn profile(&self, x: f64, time_factor: f64) -> Profile {
        if time_factor <= 0.0 {
            Profile {
                // Zero times x lets a missing coordinate through as NaN.
                pressure: 0.5 + 0.0 * x,
                expelled: 0.5 * self.coupling * x,
            }
        } else if time_factor < SWITCH {
            Profile::early(x, time_factor, self.coupling)
        } else {
            Profile::late(x, time_factor, self.coupling, &self.modes)
        }
    }

    /// The sum G = Σ sin A cos A/D E: by tan A = A/b it is the integral of the pressure sum over
    /// the half-width, times b/(1−b).
    fn relaxation(&self, time_factor: f64) -> f64 {
        self.profile(1.0, time_factor).expelled / (1.0 - self.coupling)
    }
}

impl ExactPressure for Mandel {
    fn name(&self) -> &'static str {
        "mandel"
    }

    /// The undrained pressure everywhere up to t = 0, the drained sides included.
    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let (x, _) = self.local(position);
        let profile = self.profile(x / self.parameters.half_width, self.time_factor(time));
        2.0 * self.undrained_pressure() * profile.pressure
    }
}

impl ExactDisplacement for Mandel {
    /// The centre of symmetry stays in place; zero across the plane. The undrained state up to
    /// t = 0. NaN where `position` has fewer than two coordinates.
    fn displacement(&self, position: &[f64], time: f64) -> Vec<f64> {
        let (x, y) = self.local(position);
        let a = self.parameters.half_width;
        let time_factor = self.time_factor(time);
        let relaxation = self.relaxation(time_factor);
        let expelled = self.profile(x / a, time_factor).expelled;
        let swelling = expelled + self.coupling * relaxation * x / a;
        let bulging = self.poisson_ratio() / 2.0 - self.undrained_poisson_ratio() * relaxation;
        let drained = self.unit_strain() * (bulging * x + swelling * a);
        let loaded = self.plate_strain(relaxation) * y;
        let axis_of_drainage = self.parameters.drained_axis;
        (0..position.len())
            .map(|axis| match axis {
                _ if position.len() < 2 => f64::NAN,
                _ if axis == axis_of_drainage => drained,
                0 | 1 => loaded,
                _ => 0.0,
            })
            .collect()
    }
}

/// Fails on the first parameter that makes no Mandel problem.
fn check(parameters: &MandelParameters) -> Result<(), ReferenceError> {
    if parameters.drained_axis > 1 {
        return Err(ReferenceError::WrongDimension {
            subject: "the Mandel plane, counted up to the drained axis",
            found: parameters.drained_axis.saturating_add(1),
            least: 1,
            most: 2,
        });
    }
    for (name, value) in [
        (
            "first coordinate of the Mandel origin (m)",
            parameters.origin[0],
        ),
        (
            "second coordinate of the Mandel origin (m)",
            parameters.origin[1],
        ),
        ("force on half a plate (N/m)", parameters.force),
        ("first Lamé parameter (Pa)", parameters.lame_lambda),
    ] {
        finite(name, value)?;
    }
    for (name, value) in [
        ("half-width of the strip (m)", parameters.half_width),
        ("height of the strip (m)", parameters.height),
        ("shear modulus (Pa)", parameters.shear_modulus),
        ("bulk modulus λ + 2μ/3 (Pa)", bulk_modulus(parameters)),
        ("Biot coefficient", parameters.biot_coefficient),
        ("storage (1/Pa)", parameters.storage),
        ("mobility (m²/(Pa·s))", parameters.mobility),
    ] {
        positive(name, value)?;
    }
    Ok(())
}

/// Drained bulk modulus K = λ + 2μ/3, Pa.
fn bulk_modulus(parameters: &MandelParameters) -> f64 {
    parameters.lame_lambda + 2.0 / 3.0 * parameters.shear_modulus
}

/// Undrained less drained bulk modulus, α²/S, Pa.
fn stiffening(parameters: &MandelParameters) -> f64 {
    parameters.biot_coefficient.powi(2) / parameters.storage
}

/// (ν_u−ν)/(1−ν) in moduli, where nothing cancels: μ(α²/S)/((λ+2μ)(λ_u+μ)).
fn coupling(parameters: &MandelParameters) -> f64 {
    let (lambda, mu) = (parameters.lame_lambda, parameters.shear_modulus);
    let stiffening = stiffening(parameters);
    mu / (lambda + 2.0 * mu) * (stiffening / (lambda + stiffening + mu))
}

/// One term of the sums.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mode {
    /// Root A of tan A = A/b.
    root: f64,
    /// sin A/D.
    weight: f64,
    /// cos A.
    cosine: f64,
}

impl Mode {
    /// The term of the root in (nπ, nπ + π/2), n = `index`.
    ///
    /// It is the root of g(A) = A − (n+½)π + arctan(b/A). With 0 < b < 1, g is convex for A > 0, not
    /// above zero at nπ and above zero at (n+½)π: Newton's method from there falls monotonically
    /// onto the root and needs no safeguard.
    fn new(index: usize, coupling: f64) -> Self {
        let end = (index as f64 + 0.5) * PI;
        let mut root = end;
        for _ in 0..NEWTON_STEPS {
            let slope = 1.0 - coupling / (root * root + coupling * coupling);
            let step = (root - end + (coupling / root).atan()) / slope;
            root -= step;
            if step.abs() <= 1e-16 * root {
                break;
            }
        }
        // From the distance to (n+½)π the small cosine keeps its digits.
        let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let (offset_sine, offset_cosine) = (coupling / root).atan().sin_cos();
        Self {
            root,
            weight: sign * offset_cosine / (root - offset_sine * offset_cosine),
            cosine: sign * offset_sine,
        }
    }
}

/// The pressure over the strip, without dimension; b = (ν_u−ν)/(1−ν), x in half-widths.
#[derive(Clone, Copy, Debug)]
struct Profile {
    /// P = Σ sin A/D (cos Ax − cos A) E.
    pressure: f64,
    /// b ∫₀ˣ P dx.
    expelled: f64,
}

impl Profile {
    /// The sums themselves.
    fn late(x: f64, time_factor: f64, coupling: f64, modes: &[Mode]) -> Self {
        let (mut pressure, mut expelled) = (0.0, 0.0);
        for mode in modes {
            let factor = mode.weight * (-mode.root.powi(2) * time_factor).exp();
            let (sine, cosine) = (mode.root * x).sin_cos();
            pressure += factor * (cosine - mode.cosine);
            expelled += factor * coupling * (sine / mode.root - x * mode.cosine);
        }
        Self { pressure, expelled }
    }

    /// The transform of 2P is (1 − cosh qx/cosh q)/(q² (1 − b tanh(q)/q)), q² the variable. Without
    /// terms of e^(−2q) it is (1 − e^(−q(1−x)) − e^(−q(1+x)))/(q(q−b)), and e^(−qz)/(q(q−b)) is the
    /// transform of W(z) = e^(b²T−bz) erfc(z/2√T − b√T) (H. S. Carslaw and J. C. Jaeger, Conduction
    /// of Heat in Solids, 1959, appendix V). Then b∫W dz = −V, V = W − erfc(z/2√T).
    fn early(x: f64, time_factor: f64, coupling: f64) -> Self {
        let root = time_factor.sqrt();
        let shifted = |z: f64| {
            (coupling * (coupling * time_factor - z)).exp()
                * erfc(z / (2.0 * root) - coupling * root)
        };
        let layer = |z: f64| shifted(z) - erfc(z / (2.0 * root));
        let (left, right) = (1.0 + x, 1.0 - x);
        let pressure = shifted(0.0) - shifted(left) - shifted(right);
        let expelled = coupling * x * shifted(0.0) + layer(left) - layer(right);
        Self {
            pressure: 0.5 * pressure,
            expelled: 0.5 * expelled,
        }
    }
}

#[cfg(test)]
#[path = "mandel_tests.rs"]
mod tests;
