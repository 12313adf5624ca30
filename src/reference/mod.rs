//! Exact solutions for flow and poroelasticity, and the norms that compare a computed field with them.
//!
//! A solution is anything that gives a pressure at a place and a time ([`ExactPressure`]). Most are
//! solutions of the homogeneous equation `S ∂p/∂t = ∇·(κ∇p)`, κ = K/μ_f; a manufactured one also
//! states the source it needs. Where a solution has a singular point (a well), it says so, and the
//! comparison leaves a disc around it out.
//!
//! | solution | problem |
//! |---|---|
//! | [`FiveSpot`] | steady flow from an injector to a producer in a sealed square |
//! | [`FiveSpotTransient`] | the way there from a uniform pressure |
//! | [`TwoLayer`] | two layers in series, any contrast, steady and transient |
//! | [`Theis`] | a line source in an unbounded plane |
//! | [`TheisSeries`] | the same with a rate that changes over time |
//! | [`Terzaghi`] | consolidation of a column under a load |
//! | [`Mandel`] | a strip squeezed between rigid plates |
//! | [`Manufactured`] | a smooth field in a box, with its source |
//!
//! [`two_point_flow`] is no exact solution, but what any rock of square cells is measured by.

mod cylinders;
mod error;
mod exponential_integral;
mod five_spot;
mod mandel;
mod manufactured;
mod norms;
mod sneddon;
mod terzaghi;
mod theis;
mod theis_series;
mod two_layer;
mod two_point;

pub use cylinders::square_array_of_cylinders;
pub use error::ReferenceError;
pub use exponential_integral::exponential_integral;
pub use five_spot::{FiveSpot, FiveSpotTransient, InjectorCorner};
pub use mandel::{Mandel, MandelParameters};
pub use manufactured::{Axis, Ends, Manufactured, TimeFactor};
pub use norms::{ErrorNorms, Sample};
pub use sneddon::Sneddon;
pub use terzaghi::{Terzaghi, TerzaghiParameters};
pub use theis::{Theis, TheisParameters};
pub use theis_series::TheisSeries;
pub use two_layer::{Layer, TwoLayer, TwoLayerParameters};
pub use two_point::two_point_flow;

/// A ball in which a solution is not to be compared, because it is singular at the centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Exclusion {
    /// Centre, m. Its length may be less than the dimension of the points asked about: the ball is
    /// then a cylinder along the missing axes.
    pub centre: Vec<f64>,
    /// Radius, m.
    pub radius: f64,
}

impl Exclusion {
    /// Whether `position` (m) lies within the radius, the rim included.
    #[must_use]
    pub fn contains(&self, position: &[f64]) -> bool {
        squared_distance(&self.centre, position) <= self.radius * self.radius
    }
}

/// A pressure field known exactly.
pub trait ExactPressure: Send + Sync {
    /// Short name for reports, such as `five_spot`.
    fn name(&self) -> &'static str;

    /// Pressure in Pa at `position` (m) and `time` (s).
    ///
    /// Infinite at a singular point; NaN where `position` has fewer coordinates than needed.
    fn pressure(&self, position: &[f64], time: f64) -> f64;

    /// Whether the solution exists only as a steady state; `time` is then ignored.
    fn steady_only(&self) -> bool {
        false
    }

    /// Neighbourhoods of singular points, to be left out of a comparison.
    fn excluded(&self) -> Vec<Exclusion> {
        Vec::new()
    }

    /// Volumetric source in 1/s that the field needs, or `None` where it needs none.
    fn source(&self, _position: &[f64], _time: f64) -> Option<f64> {
        None
    }
}

/// A displacement field known exactly.
pub trait ExactDisplacement: Send + Sync {
    /// Displacement in m at `position` (m) and `time` (s), one component per coordinate.
    fn displacement(&self, position: &[f64], time: f64) -> Vec<f64>;
}

/// Coordinate along `axis`, NaN where the position does not have that axis.
fn coordinate(position: &[f64], axis: usize) -> f64 {
    position.get(axis).copied().unwrap_or(f64::NAN)
}

/// Squared distance over the axes of `centre`, in m².
fn squared_distance(centre: &[f64], position: &[f64]) -> f64 {
    centre
        .iter()
        .enumerate()
        .map(|(axis, c)| (coordinate(position, axis) - c).powi(2))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exclusion_is_a_cylinder_along_axes_it_does_not_name() {
        let well = Exclusion {
            centre: vec![1.0, 2.0],
            radius: 0.5,
        };
        assert!(well.contains(&[1.3, 2.4]));
        assert!(well.contains(&[1.3, 2.4, 77.0]));
        assert!(!well.contains(&[1.4, 2.4, 0.0]));
        assert!(
            !well.contains(&[1.0]),
            "a point without the axis is nowhere near"
        );
    }
}
