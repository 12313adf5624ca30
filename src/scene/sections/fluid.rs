//! `[fluid]`: what fills the pores.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::quantity::{Density, Pressure, Viscosity};
use crate::scene::span::Span;
use crate::scene::validate::{Context, Report, Section};

/// What fills the pores.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Dynamic viscosity μ, Pa s.
    pub viscosity: Viscosity,
    /// Density ρ, kg/m³.
    #[serde(default = "water")]
    pub density: Density,
    /// Bulk modulus, Pa; needed where storage follows from porosity (Eq. 38).
    pub bulk_modulus: Option<Pressure>,
}

fn water() -> Density {
    Density::si(1000.0)
}

impl Section for Fluid {
    const NAME: &'static str = "fluid";

    fn check(&self, _: Span, _: &Context<'_>, report: &mut Report) {
        report.positive("viscosity", self.viscosity);
        report.positive("density", self.density);
        if let Some(modulus) = self.bulk_modulus {
            report.positive("bulk_modulus", modulus);
        }
    }
}
