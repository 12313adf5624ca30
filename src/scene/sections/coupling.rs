//! `[coupling]`: the pressure strains the rock, and the strain stores fluid (Biot).

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::quantity::Number;
use crate::scene::span::Span;
use crate::scene::validate::{Context, Report, Section};

/// The two ways between pressure and strain (Biot). Needs `[flow]` and `[mechanics]`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Coupling {
    /// Starts from the answer to the first loads before any fluid has moved.
    pub undrained_start: bool,
    /// Storage that only rough pressures feel, in units of α²/(λ + 2μ): 0.1 to 1 calms nearly undrained
    /// rock in small steps.
    pub stabilisation: Number,
}

impl Default for Coupling {
    fn default() -> Self {
        Self {
            undrained_start: true,
            stabilisation: Number::si(0.0),
        }
    }
}

impl Section for Coupling {
    const NAME: &'static str = "coupling";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        report.not_negative("stabilisation", self.stabilisation);
        let needed = [
            ("[flow]", scene.has(&scene.draft.flow)),
            ("[mechanics]", scene.has(&scene.draft.mechanics)),
        ];
        report.needs("[coupling]", place, &needed);
    }
}
