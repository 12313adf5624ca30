//! `[gravity]`: its presence makes the effect exist.

use schemars::JsonSchema;
use serde::Deserialize;

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

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        report.vector("acceleration", &self.acceleration, scene.dimension());
    }
}
