//! `[reference]`: an exact solution to compare with.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Length, values};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// An exact solution to compare with.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The solution.
    #[serde(rename = "type")]
    pub kind: Spanned<ReferenceKind>,
    /// Points nearer to a well than this, m, are left out of the error norms.
    pub exclude: Option<Length>,
}

/// The exact solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceKind {
    /// Confined five-spot: a square with an injector and a producer in opposite corners.
    FiveSpot,
    /// Two layers in series.
    TwoLayer,
    /// A well in an unbounded plane.
    Theis,
    /// A smooth solution with the source it needs.
    Manufactured,
    /// Consolidation of a drained column under a sudden load.
    Terzaghi,
    /// Consolidation of a slab between rigid plates, drained at its ends.
    Mandel,
    /// Opening of a straight pressurised crack in an unbounded plane; half of it if one tip lies on a
    /// side.
    Sneddon,
}

impl Section for Reference {
    const NAME: &'static str = "reference";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        if self.kind.value == ReferenceKind::Sneddon {
            if !scene.has(&scene.draft.cracks) {
                let fault = Diagnostic::new("this reference needs [cracks]").at(self.kind.span);
                report.add(fault.help("add one straight crack with a `pressure`"));
            }
        } else if self.is_coupled() {
            if !scene.has(&scene.draft.coupling) {
                let fault = Diagnostic::new("this reference needs [coupling]");
                let fault = fault.at(self.kind.span);
                report.add(fault.help("add [flow], [mechanics] and [coupling]"));
            }
        } else if !scene.has(&scene.draft.flow) {
            report.add(Diagnostic::new("[reference] needs [flow]").at(place));
        }
        self.exclude
            .into_iter()
            .for_each(|exclude| report.positive("exclude", exclude));
        match self.kind.value {
            ReferenceKind::FiveSpot => {
                self.check_square(scene, report);
                self.check_wells(2, scene, report);
            }
            ReferenceKind::Theis => self.check_wells(1, scene, report),
            ReferenceKind::TwoLayer => {
                let materials = scene.sound(&scene.draft.materials).map(|m| m.len());
                self.check_count("materials", 2, materials, report);
            }
            ReferenceKind::Manufactured
            | ReferenceKind::Terzaghi
            | ReferenceKind::Mandel
            | ReferenceKind::Sneddon => {}
        }
    }
}

impl Reference {
    /// Whether the solution is one of flow and deformation together.
    fn is_coupled(&self) -> bool {
        matches!(
            self.kind.value,
            ReferenceKind::Terzaghi | ReferenceKind::Mandel
        )
    }

    fn check_square(&self, scene: &Context<'_>, report: &mut Report) {
        let Some(bounds) = scene.bounds() else { return };
        let size: Vec<f64> = bounds
            .min
            .iter()
            .zip(&bounds.max)
            .map(|(low, high)| high - low)
            .collect();
        let square = matches!(size[..], [x, y] if (x - y).abs() <= 1e-9 * x);
        if !square {
            let fault = Diagnostic::new("the five-spot needs a square domain").at(self.kind.span);
            report.add(fault.help(format!("the domain is {bounds}")));
        }
        self.check_corners(scene, report);
    }

    fn check_corners(&self, scene: &Context<'_>, report: &mut Report) {
        let wells = scene.sound(&scene.draft.wells);
        let known = scene
            .sound(&scene.draft.geometry)
            .is_some_and(|g| g.path().is_none());
        let (Some(wells), Some(bounds), true) = (wells, scene.bounds(), known) else {
            return;
        };
        for well in wells {
            let at = values(&well.value.at);
            let corner =
                at.iter()
                    .zip(bounds.min.iter().zip(&bounds.max))
                    .all(|(x, (low, high))| {
                        let slack = 1e-9 * (high - low);
                        (x - low).abs() <= slack || (x - high).abs() <= slack
                    });
            if !corner {
                let fault = Diagnostic::new("a five-spot has its wells in corners of the domain");
                report.add(
                    fault
                        .at(well.value.at.span)
                        .also(self.kind.span, "asked for here"),
                );
            }
        }
    }

    fn check_wells(&self, needed: usize, scene: &Context<'_>, report: &mut Report) {
        let wells = match scene.has(&scene.draft.wells) {
            true => scene.sound(&scene.draft.wells).map(|wells| wells.len()),
            false => Some(0),
        };
        self.check_count("wells", needed, wells, report);
    }

    fn check_count(&self, what: &str, needed: usize, found: Option<usize>, report: &mut Report) {
        if let Some(found) = found
            && found != needed
        {
            let message =
                format!("this reference needs [{what}] with {needed} of them, found {found}");
            report.add(Diagnostic::new(message).at(self.kind.span));
        }
    }
}
