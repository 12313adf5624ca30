//! `[audit]`: how well balances must close.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::quantity::Number;
use crate::scene::range::{Range, within};
use crate::scene::span::Span;
use crate::scene::validate::{Context, Report, Section};

/// Limits of the balances, checked after every step. A step that misses one is cut; where it cannot be cut
/// the run ends, and what was written until then is kept. A limit of 1 is none.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Audit {
    /// Fluid that may be lost or made, over all that was moved or taken up: 0.01 if absent, 0.1 for the
    /// explicit scheme with `[coupling]`, whose strain lags by a step: there it holds in outputs, and ten times
    /// as much may be owed between them.
    #[schemars(transform = within(&MASS))]
    pub mass: Option<Number>,
    /// Forces that may be left out of balance, over all forces.
    #[schemars(transform = within(&MOMENTUM))]
    pub momentum: Number,
    /// Energy that may come from nowhere, over all that was supplied or stored.
    #[schemars(transform = within(&ENERGY))]
    pub energy: Number,
    /// Pressure that strain which lags behind it may leave unsettled in an output, over the range of the
    /// pressure, in the root mean square; of the explicit scheme with `[coupling]`.
    #[schemars(transform = within(&LAG))]
    pub lag: Number,
}

const MASS: Range = limit("mass");
const MOMENTUM: Range = limit("momentum");
const ENERGY: Range = limit("energy");

const LAG: Range = limit("lag");

const fn limit(key: &'static str) -> Range {
    Range {
        key,
        low: 1e-10,
        high: 1.0,
        why: "sums over many points round off less, and at 1 nothing is checked",
    }
}

impl Default for Audit {
    fn default() -> Self {
        Self {
            mass: None,
            momentum: Number::si(1e-2),
            energy: Number::si(1e-2),
            // In 36 columns of Terzaghi's it was a quarter to 1.3 times the root mean square error of the pressure
            // where that was above 1 %; at 0.5 m an output with 1.4e-2 is 2.3 % off, one with 3.1e-2 4.4 %.
            lag: Number::si(1.5e-2),
        }
    }
}

impl Section for Audit {
    const NAME: &'static str = "audit";

    fn check(&self, _: Span, _: &Context<'_>, report: &mut Report) {
        if let Some(mass) = self.mass {
            MASS.check(mass, report);
        }
        MOMENTUM.check(self.momentum, report);
        ENERGY.check(self.energy, report);
        LAG.check(self.lag, report);
    }
}
