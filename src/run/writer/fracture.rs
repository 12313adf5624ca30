//! Pictures of what breaks: damage over time as panels and as an animation, and the crack path.

use std::path::Path;

use super::super::fracture::CrackTracker;
use super::pictures::{Frame, Pictures};
use crate::model::Model;
use crate::output::{
    Multiples, OutputError, PathPlot, Scale, animation_png, multiples_png, paths_svg,
};
use crate::plan::{CrackKind, Plan};
use crate::run::quantities::drawn;

/// Panels of the picture over time.
const PANELS: usize = 12;
const WIDTH: u32 = 1400;
const SECONDS_PER_FRAME: f64 = 0.6;

/// Draws damage at all outputs, and in a plane where rock broke when; nothing without damage.
///
/// # Errors
/// Those of the pictures.
pub(super) fn draw<const D: usize>(
    pictures: &Pictures<'_, D>,
    outputs: usize,
    tracker: &CrackTracker,
) -> Result<(), OutputError> {
    if film(pictures, outputs)? && D == 2 {
        draw_path(pictures.folder, pictures.plan, pictures.model, tracker)?;
    }
    Ok(())
}

/// Draws damage at all outputs as panels and as an animation; whether there is any.
fn film<const D: usize>(pictures: &Pictures<'_, D>, outputs: usize) -> Result<bool, OutputError> {
    let Pictures {
        folder,
        plan,
        model,
        sections,
    } = *pictures;
    let [.., damage] = drawn(D);
    let Some(section) = sections.all.first().filter(|_| plan.damage.is_some()) else {
        return Ok(false);
    };
    let frames = pictures.frames(&damage, outputs)?;
    if frames.is_empty() {
        return Ok(false);
    }
    let panels = thinned(&frames);
    let film = Multiples {
        title: &format!("{}: damage{}", plan.title, section.name()),
        unit: "1",
        positions: &section.positions(model),
        sizes: &section.sizes(model),
        frames: &panels,
        scale: Scale::Linear,
        range: damage.range,
        width_px: WIDTH,
        axes: section.axes(),
        lines: &section.cracks(plan),
        outlines: section.outlines(plan),
    };
    multiples_png(folder.join("damage-over-time.png"), &film)?;
    if frames.len() > 1 {
        let film = Multiples {
            frames: &frames,
            width_px: WIDTH / 2,
            ..film
        };
        animation_png(
            folder.join("damage-animation.png"),
            &film,
            SECONDS_PER_FRAME,
        )?;
    }
    Ok(true)
}

/// As many frames as there are panels, the first and the last among them.
fn thinned(frames: &[Frame]) -> Vec<Frame> {
    let (all, most) = (frames.len(), PANELS.min(frames.len()));
    let pick = |k: usize| frames[k * (all - 1) / (most - 1).max(1)].clone();
    (0..most).map(pick).collect()
}

fn draw_path<const D: usize>(
    folder: &Path,
    plan: &Plan,
    model: &Model<D>,
    tracker: &CrackTracker,
) -> Result<(), OutputError> {
    let domain = &model.cloud.domain;
    let corner = |x: &crate::geometry::Vector<D>| [x[0], x[1]];
    let initial: Vec<Vec<[f64; 2]>> = plan
        .cracks
        .iter()
        .map(|crack| crack.points().to_vec())
        .collect();
    let from_start = |point: &usize| {
        let banded = |band: &Vec<u32>| band.binary_search(&(*point as u32)).is_ok();
        model.bands.points.iter().any(banded)
    };
    let broken = (0..tracker.broken_at.len())
        .filter(|point| tracker.broken_at[*point].is_finite() && !from_start(point));
    let points: Vec<[f64; 3]> = broken
        .map(|point| {
            let at = corner(&model.cloud.position[point]);
            [at[0], at[1], tracker.broken_at[point]]
        })
        .collect();
    let cut = plan
        .cracks
        .iter()
        .any(|crack| crack.kind == CrackKind::Damaged);
    let plot = PathPlot {
        title: &format!("{}: crack path", plan.title),
        bounds: [corner(&domain.lower), corner(&domain.upper)],
        initial: &initial,
        points: &points,
        note: cut.then_some("points of cracks from the start are left out"),
    };
    paths_svg(folder.join("crack-path.svg"), &plot)
}
