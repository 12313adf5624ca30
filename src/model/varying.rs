//! Properties of the rock that vary from point to point, for files and pictures.

use super::properties::Properties;
use crate::operators::Lame;

/// Difference between values, relative to them, that is rounding.
const SAME: f64 = 1e-12;

/// A property that is not the same at all points.
#[derive(Debug, Clone, PartialEq)]
pub struct VaryingProperty {
    /// As in scenes.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// A value per point, shape `(n,)`.
    pub values: Vec<f64>,
}

impl VaryingProperty {
    /// Names of all that may vary.
    pub(crate) const NAMES: [&str; 6] = [
        "storage",
        "youngs_modulus",
        "poissons_ratio",
        "biot_coefficient",
        "density",
        "fracture_energy",
    ];

    /// Those of a rock that vary, without its permeability. `flows` tells whether its storage is used.
    pub(super) fn of(points: &Properties, flows: bool) -> Vec<Self> {
        let sum = |own: &Lame| own.lambda + own.mu;
        let modulus = |own: &Lame| own.mu * (3.0 * own.lambda + 2.0 * own.mu) / sum(own);
        let ratio = |own: &Lame| 0.5 * own.lambda / sum(own);
        let storage = points.storage.iter().filter(|_| flows);
        let values = [
            ("1/Pa", storage.copied().collect()),
            ("Pa", points.lame.iter().map(modulus).collect()),
            ("", points.lame.iter().map(ratio).collect()),
            ("", points.biot_coefficient.clone()),
            ("kg/m^3", points.density.clone()),
            ("J/m^2", points.fracture_energy.clone()),
        ];
        let all = Self::NAMES.into_iter().zip(values);
        let all = all.map(|(name, (unit, values))| VaryingProperty { name, unit, values });
        all.filter(|own| varies(&own.values)).collect()
    }
}

fn varies(values: &[f64]) -> bool {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - low > SAME * high.abs().max(low.abs())
}
