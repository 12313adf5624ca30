//! Two layers in series, with any contrast of mobility and storage.
//!
//! S ∂p/∂t = ∂/∂x(κ ∂p/∂x) on 0 < x < L₁ + L₂, κ and S constant in each layer, pressure and flux
//! continuous at x = L₁, both ends held at a pressure, one initial pressure throughout. With the
//! effusivity e = √(κS) and the square root of the diffusion time a = L√(S/κ) of each layer, the
//! transient is a sum of eigenfunctions ([`modes`]); at times so early that the sum would need more
//! of them than are kept, the Laplace transform is inverted instead ([`laplace`]).

mod laplace;
mod modes;

use self::modes::Mode;
use super::error::{finite, positive};
use super::{ExactPressure, ReferenceError, coordinate};

/// Number of eigenfunctions kept.
const MODES: u32 = 200;

/// Decay exponent from which an eigenfunction is below rounding error: e⁻⁴⁵ ≈ 3e-20.
const FORGOTTEN: f64 = 45.0;

/// One layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Thickness L, m.
    pub thickness: f64,
    /// Mobility κ = K/μ_f, m²/(Pa·s).
    pub mobility: f64,
    /// Storage S, 1/Pa.
    pub storage: f64,
}

impl Layer {
    /// Effusivity √(κS), m/(Pa·√s).
    fn effusivity(&self) -> f64 {
        self.mobility.sqrt() * self.storage.sqrt()
    }

    /// Square root of the diffusion time, L√(S/κ), √s.
    fn root_time(&self) -> f64 {
        self.thickness * (self.storage.sqrt() / self.mobility.sqrt())
    }

    /// Resistance to flow L/κ, Pa·s/m.
    fn resistance(&self) -> f64 {
        self.thickness / self.mobility
    }

    fn check(&self) -> Result<(), ReferenceError> {
        positive("thickness of a layer (m)", self.thickness)?;
        positive("mobility of a layer (m²/(Pa·s))", self.mobility)?;
        positive("storage of a layer (1/Pa)", self.storage)?;
        Ok(())
    }
}

/// What describes a problem of two layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoLayerParameters {
    /// The layer next to the origin and the one beyond it.
    pub layers: [Layer; 2],
    /// Pressures held at the near and the far end, Pa.
    pub end_pressures: [f64; 2],
    /// Pressure throughout at t = 0, Pa.
    pub initial_pressure: f64,
    /// Coordinate of the near end, m.
    pub origin: f64,
    /// Axis across the layers: 0, 1 or 2.
    pub axis: usize,
}

impl TwoLayerParameters {
    /// Two halves of `length` (m) along x from 0, with initial pressure zero; `mobilities` in
    /// m²/(Pa·s), `storages` in 1/Pa, `end_pressures` in Pa.
    #[must_use]
    pub fn halves(
        length: f64,
        mobilities: [f64; 2],
        storages: [f64; 2],
        end_pressures: [f64; 2],
    ) -> Self {
        let half = |index: usize| Layer {
            thickness: 0.5 * length,
            mobility: mobilities[index],
            storage: storages[index],
        };
        let layers = [half(0), half(1)];
        Self {
            layers,
            end_pressures,
            initial_pressure: 0.0,
            origin: 0.0,
            axis: 0,
        }
    }
}

/// Place in the layered column: the layer, and the distance from that layer's outer end over its
/// thickness (0 at the end of the column, 1 at the interface).
#[derive(Clone, Copy, Debug)]
struct Place {
    layer: usize,
    depth: f64,
}

/// Pressure in two layers in series.
#[derive(Clone, Debug)]
pub struct TwoLayer {
    parameters: TwoLayerParameters,
    modes: Vec<Mode>,
}

impl TwoLayer {
    /// The solution for `parameters`.
    ///
    /// # Errors
    /// [`ReferenceError`] where a layer's property is not above zero, a pressure or the origin is
    /// not finite, or the axis is not 0, 1 or 2.
    pub fn new(parameters: TwoLayerParameters) -> Result<Self, ReferenceError> {
        let TwoLayerParameters {
            layers,
            end_pressures,
            initial_pressure,
            origin,
            axis,
        } = parameters;
        layers[0].check()?;
        layers[1].check()?;
        finite("pressure at the near end (Pa)", end_pressures[0])?;
        finite("pressure at the far end (Pa)", end_pressures[1])?;
        finite("initial pressure (Pa)", initial_pressure)?;
        finite("origin of the layers (m)", origin)?;
        if axis > 2 {
            let (subject, found) = ("layered column (its axis + 1)", axis + 1);
            return Err(ReferenceError::WrongDimension {
                subject,
                found,
                least: 1,
                most: 3,
            });
        }
        let excess = end_pressures.map(|pressure| initial_pressure - pressure);
        Ok(Self {
            parameters,
            modes: modes::modes(&layers, excess, MODES),
        })
    }

    /// The parameters it was made from.
    #[must_use]
    pub fn parameters(&self) -> &TwoLayerParameters {
        &self.parameters
    }

    /// Steady Darcy flux along the axis, m/s: (p_near − p_far)/(L₁/κ₁ + L₂/κ₂).
    #[must_use]
    pub fn steady_flux(&self) -> f64 {
        let TwoLayerParameters {
            layers: [near, far],
            end_pressures: [first, last],
            ..
        } = &self.parameters;
        (first - last) / (near.resistance() + far.resistance())
    }

    /// Steady pressure in Pa at `x` (m) along the axis.
    #[must_use]
    pub fn steady_pressure(&self, x: f64) -> f64 {
        self.steady_at(self.place(x))
    }

    /// Steady pressure at the interface, Pa.
    #[must_use]
    pub fn interface_pressure(&self) -> f64 {
        self.steady_at(Place {
            layer: 0,
            depth: 1.0,
        })
    }

    /// Coordinate of the interface along the axis, m.
    #[must_use]
    pub fn interface(&self) -> f64 {
        self.parameters.origin + self.parameters.layers[0].thickness
    }

    /// Where `x` lies; a place outside the column counts as its nearer end.
    fn place(&self, x: f64) -> Place {
        let [near, far] = &self.parameters.layers;
        let distance = x - self.parameters.origin;
        if distance <= near.thickness {
            Place {
                layer: 0,
                depth: (distance / near.thickness).max(0.0),
            }
        } else {
            let left = near.thickness + far.thickness - distance;
            Place {
                layer: 1,
                depth: (left / far.thickness).clamp(0.0, 1.0),
            }
        }
    }

    /// Steady pressure as a mean of the end pressures, each weighted by the resistance from the
    /// place to the other end: a difference of the two would lose small interface pressures.
    fn steady_at(&self, place: Place) -> f64 {
        let resistances = self.parameters.layers.map(|layer| layer.resistance());
        let pressures = self.parameters.end_pressures;
        let (own, other) = (place.layer, 1 - place.layer);
        let to_own = resistances[own] * place.depth;
        let to_other = resistances[own] * (1.0 - place.depth) + resistances[other];
        (pressures[own] * to_other + pressures[other] * to_own) / (to_own + to_other)
    }

    /// Pressure at a place and a positive time.
    fn transient_at(&self, place: Place, time: f64) -> f64 {
        let parameters = &self.parameters;
        let last_rate = self.modes.last().map_or(0.0, |mode| mode.decay_rate());
        if last_rate * time >= FORGOTTEN {
            return self.steady_at(place) + modes::sum(&self.modes, place, time);
        }
        let rises = parameters
            .end_pressures
            .map(|end| end - parameters.initial_pressure);
        parameters.initial_pressure + laplace::rise(&parameters.layers, rises, place, time)
    }
}

impl ExactPressure for TwoLayer {
    fn name(&self) -> &'static str {
        "two_layer"
    }

    /// The initial pressure up to t = 0, the steady state at an infinite time. Places outside the
    /// column have the pressure of its nearer end.
    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let x = coordinate(position, self.parameters.axis);
        if x.is_nan() || time.is_nan() {
            f64::NAN
        } else if time <= f64::MIN_POSITIVE {
            self.parameters.initial_pressure
        } else {
            self.transient_at(self.place(x), time)
        }
    }
}

#[cfg(test)]
mod tests;
