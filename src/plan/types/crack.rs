//! What a plan says about cracks.

use super::Load;
pub use crate::scene::CrackKind;

/// A crack that is there from the start.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackPlan {
    /// Name in the scene.
    pub name: String,
    /// How it is made.
    pub kind: CrackKind,
    /// Where it is.
    pub place: CrackPlace,
    /// Pressure in the crack, Pa: on both faces without flow, of the fluid in it with flow.
    pub pressure: Option<Load>,
    /// Fluid that is pumped into it; only with flow.
    pub injection: Option<InjectionPlan>,
}

impl CrackPlan {
    /// Chain of segments from one tip over the corners to the other, m; empty in space.
    pub fn points(&self) -> &[[f64; 2]] {
        match &self.place {
            CrackPlace::Chain(points) => points,
            CrackPlace::Disc { .. } => &[],
        }
    }
}

/// Where a crack is.
#[derive(Debug, Clone, PartialEq)]
pub enum CrackPlace {
    /// Chain of segments in a plane, m.
    Chain(Vec<[f64; 2]>),
    /// Disc in space; only damaged.
    Disc {
        /// Centre, m.
        centre: [f64; 3],
        /// Normal, of length one.
        normal: [f64; 3],
        /// Radius, m.
        radius: f64,
    },
}

/// Fluid that is pumped into a crack.
#[derive(Debug, Clone, PartialEq)]
pub struct InjectionPlan {
    /// Where, m.
    pub at: Vec<f64>,
    /// Full-plane rate, m³/s (per metre of thickness in 2-D).
    pub rate: Load,
}
