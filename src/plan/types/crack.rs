//! What a plan says about cracks.

use super::Load;

/// A crack in a plane that is there from the start.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackPlan {
    /// Name in the scene.
    pub name: String,
    /// From one tip over the corners to the other, m.
    pub points: Vec<[f64; 2]>,
    /// Pressure on both faces, Pa.
    pub pressure: Option<Load>,
}
