//! Influence functions ω(ξ): how strongly a neighbour counts.

/// Influence function of the distance; only ratios matter, units cancel in every operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Influence {
    /// 1/|ξ|², the default of published dual-horizon codes.
    #[default]
    InverseSquare,
    /// 1/|ξ|.
    Inverse,
    /// 1.
    Constant,
    /// exp(−(2|ξ|/δ)²).
    Gaussian,
}

impl Influence {
    /// Weight of a bond of length `distance` in a family of the given `horizon`, both in metres.
    pub fn weight(self, distance: f64, horizon: f64) -> f64 {
        match self {
            Influence::InverseSquare => 1.0 / (distance * distance),
            Influence::Inverse => 1.0 / distance,
            Influence::Constant => 1.0,
            Influence::Gaussian => (-(2.0 * distance / horizon).powi(2)).exp(),
        }
    }
}
