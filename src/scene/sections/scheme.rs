//! `[scheme]`: how the step is taken.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// How the step is taken.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scheme {
    /// The scheme.
    pub name: Spanned<SchemeName>,
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
}

impl Section for Scheme {
    const NAME: &'static str = "scheme";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        let steady = scene
            .sound(&scene.draft.time)
            .filter(|time| time.is_steady());
        if let Some(time) = steady
            && self.name.value == SchemeName::Explicit
        {
            let fault = Diagnostic::new("a steady run has no explicit scheme").at(self.name.span);
            report.add(
                fault
                    .also(time.mode.span, "steady here")
                    .help("use name = \"implicit\", or a transient run to a late `end`"),
            );
        }
    }
}
