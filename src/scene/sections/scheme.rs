//! `[scheme]`: how the step is taken.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::quantity::Number;
use crate::scene::range::{Range, within};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// How the step is taken.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scheme {
    /// The scheme.
    pub name: Spanned<SchemeName>,
    /// Factor of the fixed-stress term of the staggered scheme; 0 is the form of the paper.
    #[schemars(transform = within(&RELAXATION))]
    pub relaxation: Number,
    /// How the iterations between flow and mechanics are sped up.
    pub acceleration: Acceleration,
    /// Relative change at which the iterations between flow and mechanics end.
    #[schemars(transform = within(&COUPLING_TOLERANCE))]
    pub coupling_tolerance: Number,
    /// The step fails beyond this many iterations between flow and mechanics.
    #[schemars(transform = within(&COUPLING_ITERATIONS))]
    pub coupling_iterations: Spanned<u64>,
    /// The semi-implicit scheme takes the strain that lags behind once a step, as printed, whatever flow
    /// and mechanics disagree by: for studies of where it holds.
    pub single_pass: bool,
    /// How the explicit and the semi-implicit scheme move the solid.
    pub solid: SolidMethod,
    /// How the explicit and the semi-implicit scheme with `[coupling]` find the equilibrium they start from: `assembled` if
    /// absent, in three dimensions `relaxed`.
    pub start: Option<SchemeStart>,
    /// Relative imbalance of forces at which dynamic relaxation ends. If absent, 1e-6; in the steps of the explicit
    /// scheme with `[coupling]` it ends as well when little is left of what the step itself threw out of balance.
    #[schemars(transform = within(&ADR_TOLERANCE))]
    pub adr_tolerance: Option<Number>,
    /// The step fails beyond this many iterations of dynamic relaxation.
    #[schemars(transform = within(&ADR_ITERATIONS))]
    pub adr_iterations: Spanned<u64>,
    /// What damps dynamic relaxation.
    pub adr_damping: AdrDamping,
    /// Weight of the newest damping in dynamic relaxation with `adr_damping = "local"`.
    #[schemars(transform = within(&ADR_SMOOTHING))]
    pub adr_smoothing: Number,
}

/// Terzaghi's column, semi-implicit: error of the pressure 5.8e-4 at 1, 7.7e-4 at 10, 1.3e-2 at 100, and
/// 0.5 with half of the fluid lost at 1e6; staggered passes no longer settle in 100 from 10 on.
const RELAXATION: Range = Range {
    key: "relaxation",
    low: 0.0,
    high: 10.0,
    why: "1 is the fixed-stress split, and more holds the pressure back until nothing moves",
};
/// Terzaghi's column, staggered: mass balance 2.8e-5 and the error of tight passes at 1e-3, but 5.7e-3
/// and three times that error at 1e-2, 1.6e-2 at 0.1; at 1e-14 rounding stops the passes.
const COUPLING_TOLERANCE: Range = Range {
    key: "coupling_tolerance",
    low: 1e-14,
    high: 1e-3,
    why: "rounding stops the passes at less, and with more they end before flow and mechanics agree, so \
          that fluid is lost",
};
const COUPLING_ITERATIONS: Range = Range {
    key: "coupling_iterations",
    low: 1.0,
    high: 1e6,
    why: "passes that have not agreed by then never do",
};
/// Mandel's slab, explicit: error of the pressure 4.1e-3 at 1e-6 and 1e-5, but 1.2e-2 at 1e-4, 0.12 at
/// 1e-3 and 0.62 at 1e-2; Terzaghi's column with 0.5 leaves 75 % of the forces out of balance.
const ADR_TOLERANCE: Range = Range {
    key: "adr_tolerance",
    low: 1e-14,
    high: 1e-5,
    why: "rounding stops relaxation at less, and with more it ends before forces balance, step after \
          step",
};
const ADR_ITERATIONS: Range = Range {
    key: "adr_iterations",
    low: 1.0,
    high: 1e9,
    why: "relaxation that has not settled by then never does",
};
/// The column settles to the same state from 1e-6 to 1, in 290 to 610 ms.
const ADR_SMOOTHING: Range = Range {
    key: "adr_smoothing",
    low: 1e-3,
    high: 1.0,
    why: "1 takes the newest damping alone, and with hardly any weight damping never follows the motion",
};

impl Default for Scheme {
    fn default() -> Self {
        Self {
            name: Spanned::default(),
            relaxation: Number::si(1.0),
            acceleration: Acceleration::default(),
            coupling_tolerance: Number::si(1e-8),
            coupling_iterations: Spanned::nowhere(100),
            single_pass: false,
            solid: SolidMethod::default(),
            start: None,
            adr_tolerance: None,
            adr_iterations: Spanned::nowhere(100_000),
            adr_damping: AdrDamping::default(),
            adr_smoothing: Number::si(0.5),
        }
    }
}

/// The schemes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeName {
    /// A linear system in each step.
    #[default]
    Implicit,
    /// No linear system; steps below the stability limit.
    Explicit,
    /// A linear system for the pressure, none for the displacement.
    SemiImplicit,
    /// A linear system for each field, in turns until they agree.
    Staggered,
    /// One linear system for all fields.
    Monolithic,
}

impl SchemeName {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Implicit,
        Self::Explicit,
        Self::SemiImplicit,
        Self::Staggered,
        Self::Monolithic,
    ];

    /// Name as typed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Implicit => "implicit",
            Self::Explicit => "explicit",
            Self::SemiImplicit => "semi-implicit",
            Self::Staggered => "staggered",
            Self::Monolithic => "monolithic",
        }
    }
}

/// Accelerations of the iterations between flow and mechanics.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Acceleration {
    /// Combines the last few iterates.
    #[default]
    Anderson,
    /// Scales the last change.
    Aitken,
    /// Takes the iterates as they are.
    None,
}

/// Ways to move the solid without a linear system.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SolidMethod {
    /// Dynamic relaxation where forces are out of balance, a single step where they are not
    /// (Algorithm 3).
    #[default]
    Switched,
    /// Adaptive dynamic relaxation.
    Adr,
    /// A single step of velocity Verlet, whatever the balance of forces: in explicit steps with `[coupling]` with the
    /// velocities of the last one and the mass that makes it stable (Algorithm 1), elsewhere from rest.
    Verlet,
}

/// Ways to the equilibrium that an explicit run starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeStart {
    /// By a matrix that is assembled and factored once, and then forgotten.
    Assembled,
    /// Without any matrix, by dynamic relaxation.
    Relaxed,
}

/// What damps dynamic relaxation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AdrDamping {
    /// Critical for the mode that moves, by the Rayleigh quotient of the last step, at all points alike.
    #[default]
    Global,
    /// Critical for the stiffness that the last step showed at each point (Eqs. 65 to 68), as printed.
    Local,
}

impl Section for Scheme {
    const NAME: &'static str = "scheme";

    fn check(&self, _: Span, _: &Context<'_>, report: &mut Report) {
        RELAXATION.check(self.relaxation, report);
        COUPLING_TOLERANCE.check(self.coupling_tolerance, report);
        COUPLING_ITERATIONS.check_count(self.coupling_iterations, report);
        if let Some(tolerance) = self.adr_tolerance {
            ADR_TOLERANCE.check(tolerance, report);
        }
        ADR_ITERATIONS.check_count(self.adr_iterations, report);
        ADR_SMOOTHING.check(self.adr_smoothing, report);
    }
}
