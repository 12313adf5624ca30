//! `[time]`: how long, and in which steps.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Number, Time};
use crate::scene::range::{Range, within};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// How long, and in which steps.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TimeControl {
    /// In time, or only the state of rest.
    pub mode: Spanned<Mode>,
    /// End of the run, s. Needed unless steady.
    pub end: Option<Time>,
    /// Fixed step, s, cut to `end`. If absent: adaptive (implicit), or the stability limit times
    /// `safety` (explicit).
    pub step: Option<Time>,
    /// First of the adaptive steps, s; cut to `max_step` and `end`.
    pub first_step: Option<Time>,
    /// Longest of the adaptive steps, s; cut to `end`.
    pub max_step: Option<Time>,
    /// Error allowed in an adaptive step, over the range of the pressure in the run: 1e-5 if absent, 1e-2 with
    /// `[fracture_flow]`, where steps are of first order.
    #[schemars(transform = within(&TOLERANCE))]
    pub tolerance: Option<Number>,
    /// Method of the implicit scheme; `backward-euler` where there is `[fracture_flow]` or inertia.
    pub integrator: Spanned<Integrator>,
    /// Part of the stability limit that an explicit step uses.
    #[schemars(transform = within(&SAFETY))]
    pub safety: Number,
    /// The run fails beyond this many steps.
    #[schemars(transform = within(&MAX_STEPS))]
    pub max_steps: Spanned<u64>,
}

/// Mandel's slab: error of the pressure 2.1e-4, that of the cloud, up to 1e-6, 7.8e-3 at 1e-2, 2.2e-2 at
/// 0.1; at 1e-10 it takes 14,000 steps.
const TOLERANCE: Range = Range {
    key: "tolerance",
    low: 1e-12,
    high: 0.1,
    why: "rounding hides smaller errors of a step, and larger ones are no solution",
};
/// A coarse five-spot has the same error from 1e-3 to 1, in 892,000 to 900 steps.
const SAFETY: Range = Range {
    key: "safety",
    low: 1e-3,
    high: 1.0,
    why: "above 1 explicit steps go beyond the stability limit, and far below it they only cost",
};
const MAX_STEPS: Range = Range {
    key: "max_steps",
    low: 1.0,
    high: 1e12,
    why: "a run needs a step, and no run lives to see more",
};

impl Default for TimeControl {
    fn default() -> Self {
        Self {
            mode: Spanned::default(),
            end: None,
            step: None,
            first_step: None,
            max_step: None,
            tolerance: None,
            integrator: Spanned::default(),
            safety: Number::si(0.9),
            max_steps: Spanned::nowhere(1_000_000),
        }
    }
}

/// Whether time passes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// From the initial state to `end`.
    #[default]
    Transient,
    /// Only the state in which nothing changes any more.
    Steady,
}

/// Methods of the implicit scheme.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// Second order, with an error estimate.
    #[default]
    TrBdf2,
    /// First order.
    BackwardEuler,
}

impl Integrator {
    /// Name as typed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::TrBdf2 => "tr-bdf2",
            Self::BackwardEuler => "backward-euler",
        }
    }
}

impl TimeControl {
    /// Whether only the state of rest is wanted.
    pub fn is_steady(&self) -> bool {
        self.mode.value == Mode::Steady
    }
}

impl Section for TimeControl {
    const NAME: &'static str = "time";

    fn check(&self, place: Span, _: &Context<'_>, report: &mut Report) {
        if !self.is_steady() && self.end.is_none() {
            let fault = Diagnostic::new("a transient run needs `end`").at(place);
            report.add(fault.help("write end = \"1 h\", or mode = \"steady\""));
        }
        let durations = [
            ("end", self.end),
            ("step", self.step),
            ("first_step", self.first_step),
            ("max_step", self.max_step),
        ];
        for (name, duration) in durations {
            duration
                .into_iter()
                .for_each(|duration| report.positive(name, duration));
        }
        self.check_adaptive(report);
        if let Some(tolerance) = self.tolerance {
            TOLERANCE.check(tolerance, report);
        }
        SAFETY.check(self.safety, report);
        MAX_STEPS.check_count(self.max_steps, report);
    }
}

impl TimeControl {
    fn check_adaptive(&self, report: &mut Report) {
        let step = self.step.map(|step| step.span());
        for (name, other) in [("first_step", self.first_step), ("max_step", self.max_step)] {
            report.at_most_one(&[("step", step), (name, other.map(|other| other.span()))]);
        }
    }
}
