//! `[fracture_flow]`: fluid moves in what is broken; its presence makes the effect exist.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::damage::DamageModel;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{InversePressure, Length, Number, Permeability, Viscosity};
use crate::scene::range::{Range, within};
use crate::scene::span::Span;
use crate::scene::validate::{Context, Report, Section};

/// Flow in what is broken (Eqs. 40 to 46). Needs `[damage]`, `[flow]` and `[coupling]`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FractureFlow {
    /// Hydraulic aperture of a fracture that is closed, m: open ones conduct (w³ + this³)/12; split model only.
    pub residual_aperture: Length,
    /// How the aperture (opening) of a fracture is found from the bonds across it; model of the paper only.
    pub aperture: Aperture,
    /// What the permeability of a fracture stands for.
    pub transmissivity: Transmissivity,
    /// Damage c₁ up to which rock is intact.
    #[schemars(transform = within(&LOWER_THRESHOLD))]
    pub lower_threshold: Number,
    /// Damage c₂ from which rock is a fracture, above c₁.
    #[schemars(transform = within(&UPPER_THRESHOLD))]
    pub upper_threshold: Number,
    /// Storage in fractures, 1/Pa; that of the rock if absent.
    pub storage: Option<InversePressure>,
    /// Biot coefficient in fractures.
    #[schemars(transform = within(&BIOT_COEFFICIENT))]
    pub biot_coefficient: Number,
    /// Viscosity in fractures, Pa s; that of the fluid if absent.
    pub viscosity: Option<Viscosity>,
    /// Permeability of fractures, m²; from their aperture if absent.
    pub permeability: Option<Permeability>,
}

/// The pumped crack: pressure lower by 0.5 % at 0.01 and 0.4 % at 0.1, the same from 0.3 to 0.99.
const LOWER_THRESHOLD: Range = Range {
    key: "lower_threshold",
    low: 0.01,
    high: 0.99,
    why: "rock that is hardly damaged is no fracture, and broken rock is no intact one",
};
const UPPER_THRESHOLD: Range = Range {
    key: "upper_threshold",
    low: 0.02,
    high: 1.0,
    why: "damage ends at 1, and rock that is hardly damaged is no fracture",
};
const BIOT_COEFFICIENT: Range = Range {
    key: "biot_coefficient",
    low: 0.0,
    high: 1.0,
    why: "the pressure of the fluid acts on the rock by no more than all of itself",
};

impl Default for FractureFlow {
    fn default() -> Self {
        Self {
            residual_aperture: Length::si(1e-5),
            aperture: Aperture::default(),
            transmissivity: Transmissivity::default(),
            lower_threshold: Number::si(0.5),
            upper_threshold: Number::si(1.0),
            storage: None,
            biot_coefficient: Number::si(1.0),
            viscosity: None,
            permeability: None,
        }
    }
}

/// Ways to find the aperture of a fracture from bonds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Aperture {
    /// Opening along each bond divided by the cosine to the normal of the fracture.
    #[default]
    Normal,
    /// Plain mean over the bonds, Eq. 42 as printed.
    Mean,
}

/// What the permeability of a fracture stands for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Transmissivity {
    /// w²/12 scaled by w/2δ, so that the broken band conducts w³/12 (cubic law).
    #[default]
    Cubic,
    /// w²/12 in the whole band, as printed.
    Paper,
}

impl Section for FractureFlow {
    const NAME: &'static str = "fracture_flow";

    fn check(&self, place: Span, context: &Context<'_>, report: &mut Report) {
        let damage = context.sound(&context.draft.damage);
        if damage.is_some_and(|damage| damage.model == DamageModel::Split) {
            self.check_split(place, report);
        }
        self.check_thresholds(report);
        BIOT_COEFFICIENT.check(self.biot_coefficient, report);
        report.positive("residual_aperture", self.residual_aperture);
        self.storage
            .into_iter()
            .for_each(|storage| report.positive("storage", storage));
        self.viscosity
            .into_iter()
            .for_each(|viscosity| report.positive("viscosity", viscosity));
        self.permeability
            .into_iter()
            .for_each(|value| report.positive("permeability", value));
    }
}

impl FractureFlow {
    /// Refuses what the split model does not know.
    fn check_split(&self, place: Span, report: &mut Report) {
        let typed = |number: &Number| number.span().is_somewhere().then(|| number.span());
        let keys = [
            ("lower_threshold", typed(&self.lower_threshold)),
            ("upper_threshold", typed(&self.upper_threshold)),
            ("biot_coefficient", typed(&self.biot_coefficient)),
            ("storage", self.storage.map(|storage| storage.span())),
            (
                "aperture",
                (self.aperture != Aperture::default()).then_some(place),
            ),
            (
                "transmissivity",
                (self.transmissivity != Transmissivity::default()).then_some(place),
            ),
        ];
        for (key, span) in keys {
            let Some(span) = span else { continue };
            let fault = format!(
                "`{key}` belongs to damage.model = \"paper\": in the split model a crack holds what it opens by, and \
                 conducts by that; leave it out, or set damage.model = \"paper\""
            );
            report.add(Diagnostic::new(fault).at(span));
        }
    }

    fn check_thresholds(&self, report: &mut Report) {
        let (lower, upper) = (self.lower_threshold, self.upper_threshold);
        LOWER_THRESHOLD.check(lower, report);
        UPPER_THRESHOLD.check(upper, report);
        if lower.value() >= upper.value() && upper.value() > 0.0 {
            let fault = Diagnostic::new("`lower_threshold` must be below `upper_threshold`");
            let typed = [lower.span(), upper.span()];
            let place = typed.into_iter().find(|span| span.is_somewhere());
            report.add(fault.at(place.unwrap_or_default()));
        }
    }
}
