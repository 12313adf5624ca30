//! `[wells.NAME]`: sources and sinks at a point.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{Length, dimension};
use crate::scene::span::{Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// A source or sink at a point.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Well {
    /// Position, m.
    pub at: Spanned<Vec<Length>>,
    /// Volume rate into the rock, m³/s, or m²/s per metre of `geometry.thickness` in a plane, for the whole
    /// plane: a well on a corner of the domain puts a quarter into it.
    pub rate: Load<dimension::FlowRate>,
    /// Radius over which the source is spread, m; chosen from the horizon if absent.
    pub radius: Option<Length>,
}

impl Section for Named<Well> {
    const NAME: &'static str = "wells";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        report.names(self);
        for entry in self {
            report.position("at", &entry.value.at, scene);
            report.load(&entry.value.rate, scene);
            check_rate_unit(&entry.value.rate, scene, report);
            entry
                .value
                .radius
                .into_iter()
                .for_each(|radius| report.positive("radius", radius));
        }
    }
}

/// A rate per metre of thickness belongs to a plane.
pub(super) fn check_rate_unit(
    rate: &Load<dimension::FlowRate>,
    scene: &Context<'_>,
    report: &mut Report,
) {
    let per_metre = rate.values().iter().find(|value| value.accepted() == 1);
    if let (Some(value), Some(3)) = (per_metre, scene.dimension()) {
        let fault =
            Diagnostic::new("a rate per metre of thickness has no meaning in three dimensions");
        report.add(fault.at(value.span()).help("give the whole rate, in m^3/s"));
    }
}
