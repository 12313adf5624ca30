//! `[audit]`: how well balances must close.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::quantity::Number;
use crate::scene::span::Span;
use crate::scene::validate::{Context, Report, Section};

/// Limits of the balances, checked after every step. A step that misses one is cut; where it cannot be cut
/// the run ends, and what was written until then is kept.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Audit {
    /// Fluid that may be lost or made, over all that was moved or taken up, from 1e-10 to 1.
    pub mass: Number,
    /// Forces that may be left out of balance, over all forces, from 1e-10 to 1.
    pub momentum: Number,
    /// Energy that may come from nowhere, over all that was supplied or stored, from 1e-10 to 1.
    pub energy: Number,
}

impl Default for Audit {
    fn default() -> Self {
        Self {
            mass: Number::si(1e-2),
            momentum: Number::si(1e-2),
            energy: Number::si(1e-2),
        }
    }
}

impl Section for Audit {
    const NAME: &'static str = "audit";

    fn check(&self, _: Span, _: &Context<'_>, report: &mut Report) {
        // Below 1e-10 sums over many points are rounding; at 1 nothing is checked.
        report.within("mass", self.mass, 1e-10, 1.0);
        report.within("momentum", self.momentum, 1e-10, 1.0);
        report.within("energy", self.energy, 1e-10, 1.0);
    }
}
