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
        let lame = |value: &dyn Fn(&Lame) -> f64| {
            let values = || points.lame.iter().map(value);
            varies(values()).then(|| values().collect())
        };
        let own = |values: &[f64]| varies(values.iter().copied()).then(|| values.to_vec());
        let values = [
            ("1/Pa", own(&points.storage).filter(|_| flows)),
            ("Pa", lame(&modulus)),
            ("", lame(&ratio)),
            ("", own(&points.biot_coefficient)),
            ("kg/m^3", own(&points.density)),
            ("J/m^2", own(&points.fracture_energy)),
        ];
        let all = Self::NAMES.into_iter().zip(values);
        let varying = |(name, (unit, values)): (_, (_, Option<Vec<f64>>))| {
            Some(VaryingProperty {
                name,
                unit,
                values: values?,
            })
        };
        all.filter_map(varying).collect()
    }
}

fn varies(values: impl Iterator<Item = f64>) -> bool {
    let bounds = |[low, high]: [f64; 2], own: f64| [low.min(own), high.max(own)];
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], bounds);
    high - low > SAME * high.abs().max(low.abs())
}
