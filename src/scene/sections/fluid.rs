//! `[fluid]`: what fills the pores.

use schemars::JsonSchema;
use serde::Deserialize;

use super::damage::DamageModel;
use crate::scene::diagnostics::Diagnostic;
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
    /// Pressure at which it boils, Pa: in cracks of the split model the pressure falls no further, and where they open
    /// faster than fluid follows they hold voids. 0 if absent, or none at all with `flow.suction`.
    pub cavitation_pressure: Option<Pressure>,
}

fn water() -> Density {
    Density::si(1000.0)
}

impl Section for Fluid {
    const NAME: &'static str = "fluid";

    fn check(&self, _: Span, context: &Context<'_>, report: &mut Report) {
        report.positive("viscosity", self.viscosity);
        report.positive("density", self.density);
        if let Some(modulus) = self.bulk_modulus {
            report.positive("bulk_modulus", modulus);
        }
        if let Some(pressure) = self.cavitation_pressure
            && !boils(context)
        {
            let fault = "`cavitation_pressure` holds in cracks of the split model";
            let remedy = "leave it out, or add [fracture_flow] and [damage] with model = \"split\"";
            report.add(Diagnostic::new(fault).at(pressure.span()).help(remedy));
        }
    }
}

/// Whether fluid is in cracks that hold what they open by.
fn boils(context: &Context<'_>) -> bool {
    let damage = context.sound(&context.draft.damage);
    let splits = damage.is_none_or(|damage| damage.model == DamageModel::Split);
    context.has(&context.draft.fracture_flow) && splits
}
