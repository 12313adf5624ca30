//! `[gravity]`: its presence makes the effect exist.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::Acceleration;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// A uniform field of gravity.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration vector, m/s²: `[0, -9.81]`.
    pub acceleration: Spanned<Vec<Acceleration>>,
}

impl Section for Gravity {
    const NAME: &'static str = "gravity";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        report.vector("acceleration", &self.acceleration, scene.dimension());
        if !scene.has(&scene.draft.flow) && !scene.has(&scene.draft.mechanics) {
            let fault = Diagnostic::new("[gravity] has nothing to act on").at(place);
            report.add(fault.help("add [flow] or [mechanics], or leave [gravity] out"));
        }
    }
}
