//! `[start]`: the run that this one goes on from.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// The state that another run ended with, or stood at, in place of the initial one.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Folder of that run, or one of its checkpoints, relative to the scene file. Its points must be those of
    /// this scene.
    pub from: Spanned<String>,
    /// Whether time goes on from there or begins at 0.
    #[serde(default)]
    pub clock: Spanned<StartClock>,
    /// Whether the displacement counts from where it did, or from the state taken over: its stress then is the
    /// initial one.
    #[serde(default)]
    pub displacement: Spanned<StartDisplacement>,
}

/// Time at the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartClock {
    /// 0.
    #[default]
    Reset,
    /// That of the state taken over.
    Keep,
}

/// Displacement at the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartDisplacement {
    /// That of the state taken over.
    #[default]
    Keep,
    /// 0, with the stress of that state.
    Reset,
}

impl Section for Start {
    const NAME: &'static str = "start";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        if self.from.trim().is_empty() {
            let fault = Diagnostic::new("`from` is empty").at(self.from.span);
            report.add(fault.help("name the folder of a run, such as from = \"out/consolidated\""));
        }
        let time = scene.draft.time.as_ref();
        if time.is_some_and(|time| time.is_steady()) {
            let fault = Diagnostic::new("a steady state has no start").at(self.from.span);
            report.add(fault.help("leave [start] out, or let time pass"));
        }
    }
}
