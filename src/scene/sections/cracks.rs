//! `[cracks.NAME]`: cracks that are there from the start.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{Length, dimension};
use crate::scene::span::{Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// A crack along a chain of straight segments in a plane: bonds across it are cut, so that its faces
/// are free.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Crack {
    /// Places from one tip over the corners to the other tip, m, `[x, y]` each.
    pub points: Spanned<Vec<[Length; 2]>>,
    /// Pressure on both faces, Pa; positive opens the crack.
    pub pressure: Option<Load<dimension::Pressure>>,
}

impl Crack {
    /// The places in SI numbers.
    pub fn resolved(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|x| x.map(|x| x.value())).collect()
    }

    fn check_points(&self, scene: &Context<'_>, report: &mut Report) {
        let places = self.resolved();
        if places.len() < 2 {
            let fault = Diagnostic::new("a crack needs at least two `points`");
            report.add(fault.at(self.points.span));
        }
        let same =
            |pair: &[[f64; 2]]| (0..2).all(|axis| pair[0][axis].total_cmp(&pair[1][axis]).is_eq());
        if places.windows(2).any(same) {
            let fault = Diagnostic::new("two `points` of a crack in a row are the same");
            report.add(fault.at(self.points.span).help("remove one"));
        }
        if let Some(bounds) = scene.bounds()
            && !places.iter().all(|place| bounds.contain(place))
        {
            let fault = Diagnostic::new("the crack leaves the domain").at(self.points.span);
            report.add(fault.help(format!("the domain is {bounds}")));
        }
    }
}

impl Section for Named<Crack> {
    const NAME: &'static str = "cracks";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        let draft = scene.draft;
        if !scene.has(&draft.mechanics) {
            let fault = Diagnostic::new("[cracks] need [mechanics]").at(place);
            report.add(fault.help("add [mechanics], or leave [cracks] out"));
        }
        if scene.has(&draft.flow) {
            let fault = Diagnostic::new("[cracks] and [flow] do not go together yet").at(place);
            report.add(fault.help("leave [flow] out, and give the crack's `pressure`"));
        }
        if scene.dimension() == Some(3) {
            let fault = Diagnostic::new("[cracks] are for planes").at(place);
            report.add(fault.help("in three dimensions there are none yet"));
        }
        report.names(self);
        for entry in self {
            entry.value.check_points(scene, report);
            if let Some(pressure) = &entry.value.pressure {
                report.load(pressure, scene);
            }
        }
    }
}
