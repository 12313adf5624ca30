//! The properties of rock that files may hold.

use super::Allowed;

/// What is read from a file, and which values make sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Property {
    /// Name, which is that of the key in the scene.
    pub key: &'static str,
    /// SI unit as names of columns have it, `m2`; `None` for plain numbers.
    pub unit: Option<&'static str>,
    /// The values that make sense.
    pub allowed: Allowed,
}

/// Largest Poisson's ratio that is read: at 0.5 there are no Lamé constants.
const MOST_RATIO: f64 = 0.499_999;

impl Property {
    /// Intrinsic permeability, m².
    pub(crate) const PERMEABILITY: Self = Self::positive("permeability", "m2");
    /// Storage, 1/Pa.
    pub(crate) const STORAGE: Self = Self::positive("storage", "1/Pa");
    /// Bulk modulus of the rock, Pa.
    pub(crate) const BULK_MODULUS: Self = Self::positive("bulk_modulus", "Pa");
    /// Young's modulus, Pa.
    pub(crate) const YOUNGS_MODULUS: Self = Self::positive("youngs_modulus", "Pa");
    /// Density, kg/m³.
    pub(crate) const DENSITY: Self = Self::positive("density", "kg/m3");
    /// Fracture energy, J/m².
    pub(crate) const FRACTURE_ENERGY: Self = Self::positive("fracture_energy", "J/m2");
    /// Porosity.
    pub(crate) const POROSITY: Self = Self {
        key: "porosity",
        unit: None,
        allowed: Allowed::Share {
            most: 1.0,
            why: "it is a share of the volume",
        },
    };
    /// Biot's coefficient.
    pub(crate) const BIOT_COEFFICIENT: Self = Self {
        key: "biot_coefficient",
        unit: None,
        allowed: Allowed::UpTo {
            most: 1.0,
            why: "the pressure of the fluid acts on the rock by no more than all of itself",
        },
    };
    /// Poisson's ratio.
    pub(crate) const POISSONS_RATIO: Self = Self {
        key: "poissons_ratio",
        unit: None,
        allowed: Allowed::UpTo {
            most: MOST_RATIO,
            why: "at 0.5 rock keeps its volume; 0.49 is near enough",
        },
    };

    const fn positive(key: &'static str, unit: &'static str) -> Self {
        Self {
            key,
            unit: Some(unit),
            allowed: Allowed::Positive,
        }
    }
}
