//! `[coupling]`: the pressure strains the rock, and the strain stores fluid (Biot).

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::quantity::Number;
use crate::scene::range::{Range, within};
use crate::scene::span::Span;
use crate::scene::validate::{Context, Report, Section};

/// The two ways between pressure and strain (Biot). Needs `[flow]` and `[mechanics]`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Coupling {
    /// Starts from the answer to the first loads before any fluid has moved; else from the equilibrium of the
    /// rock under these loads at the initial pressure.
    pub undrained_start: bool,
    /// Storage that only rough pressures feel, in units of α²/(λ + 2μ): 0.1 to 1 calms nearly undrained
    /// rock in small steps.
    #[schemars(transform = within(&STABILISATION))]
    pub stabilisation: Number,
}

/// Terzaghi's column at a spacing of 0.5 m: error of the pressure 6.8e-4 at 0, 9.5e-4 at 10, but
/// 2.7e-3 at 30, 3.9e-2 at 1000 and 0.72 at 1e6.
const STABILISATION: Range = Range {
    key: "stabilisation",
    low: 0.0,
    high: 10.0,
    why: "0.1 to 1 calms the pressure of nearly undrained rock, more stores fluid that is not there",
};

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

    fn check(&self, _: Span, _: &Context<'_>, report: &mut Report) {
        STABILISATION.check(self.stabilisation, report);
    }
}
