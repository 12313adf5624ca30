//! `[scheme]`: how the step is taken.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::Number;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// How the step is taken.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scheme {
    /// The scheme.
    pub name: Spanned<SchemeName>,
    /// Factor of the fixed-stress term of the staggered scheme; 0 is the form of the paper.
    pub relaxation: Number,
    /// How the iterations between flow and mechanics are sped up.
    pub acceleration: Acceleration,
    /// Relative change at which the iterations between flow and mechanics end.
    pub coupling_tolerance: Number,
    /// The step fails beyond this many iterations between flow and mechanics.
    pub coupling_iterations: Spanned<u64>,
    /// How the explicit and the semi-implicit scheme move the solid.
    pub solid: SolidMethod,
    /// Relative imbalance of forces at which dynamic relaxation ends.
    pub adr_tolerance: Number,
    /// The step fails beyond this many iterations of dynamic relaxation.
    pub adr_iterations: Spanned<u64>,
    /// Weight of the newest damping in dynamic relaxation, above 0, up to 1.
    pub adr_smoothing: Number,
}

impl Default for Scheme {
    fn default() -> Self {
        Self {
            name: Spanned::default(),
            relaxation: Number::si(1.0),
            acceleration: Acceleration::default(),
            coupling_tolerance: Number::si(1e-8),
            coupling_iterations: Spanned::nowhere(100),
            solid: SolidMethod::default(),
            adr_tolerance: Number::si(1e-6),
            adr_iterations: Spanned::nowhere(100_000),
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
    /// A single step of velocity Verlet from rest, whatever the balance of forces.
    Verlet,
}

impl Section for Scheme {
    const NAME: &'static str = "scheme";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        self.check_steady(scene, report);
        report.not_negative("relaxation", self.relaxation);
        report.positive("coupling_tolerance", self.coupling_tolerance);
        report.at_least("coupling_iterations", self.coupling_iterations, 1);
        report.positive("adr_tolerance", self.adr_tolerance);
        report.at_least("adr_iterations", self.adr_iterations, 1);
        report.share("adr_smoothing", self.adr_smoothing);
    }
}

impl Scheme {
    fn check_steady(&self, scene: &Context<'_>, report: &mut Report) {
        let steady = scene
            .sound(&scene.draft.time)
            .filter(|time| time.is_steady());
        if let Some(time) = steady
            && matches!(
                self.name.value,
                SchemeName::Explicit | SchemeName::SemiImplicit
            )
        {
            let message = format!("a steady run has no {} scheme", self.name.name());
            let fault = Diagnostic::new(message).at(self.name.span);
            report.add(
                fault
                    .also(time.mode.span, "steady here")
                    .help("use name = \"implicit\", or a transient run to a late `end`"),
            );
        }
    }
}
