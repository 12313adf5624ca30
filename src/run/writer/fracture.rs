//! Pictures of what breaks: damage over time as panels and as an animation, and the crack path.

use std::path::Path;

use super::super::fracture::CrackTracker;
use super::pictures::{damage_of, shown_points};
use crate::model::Model;
use crate::output::{
    Multiples, OutputError, PathPlot, Scale, animation_png, multiples_png, paths_svg,
};
use crate::plan::{CrackKind, Plan};
use crate::schemes::State;

/// Panels of the picture over time.
const PANELS: usize = 12;
const WIDTH: u32 = 1400;
const SECONDS_PER_FRAME: f64 = 0.6;

/// Damage at the outputs so far.
#[derive(Debug, Default)]
pub(super) struct Animation {
    pub(super) frames: Vec<(f64, Vec<f64>)>,
}

impl Animation {
    /// Keeps the damage of an output.
    pub(super) fn record<const D: usize>(&mut self, model: &Model<D>, state: &State) {
        let damage = damage_of(model, state);
        if damage.is_empty() {
            return;
        }
        let shown = shown_points(model).into_iter();
        self.frames
            .push((state.time, shown.map(|point| damage[point]).collect()));
    }

    /// Draws what was kept, and where rock broke when.
    ///
    /// # Errors
    /// Those of the pictures.
    pub(super) fn draw<const D: usize>(
        &self,
        folder: &Path,
        plan: &Plan,
        model: &Model<D>,
        tracker: &CrackTracker,
    ) -> Result<(), OutputError> {
        if self.frames.is_empty() {
            return Ok(());
        }
        let cloud = &model.cloud;
        let shown = shown_points(model);
        let place = |point: &usize| [cloud.position[*point][0], cloud.position[*point][1]];
        let positions: Vec<f64> = shown.iter().flat_map(place).collect();
        let size = |point: &usize| cloud.cell[*point].fixed_rows::<2>(0).max();
        let sizes: Vec<f64> = shown.iter().map(size).collect();
        let panels = self.thinned();
        let film = Multiples {
            title: &format!("{}: damage", plan.title),
            unit: "1",
            positions: &positions,
            sizes: &sizes,
            frames: &panels,
            scale: Scale::Linear,
            range: Some([0.0, 1.0]),
            width_px: WIDTH,
        };
        multiples_png(folder.join("damage-over-time.png"), &film)?;
        if self.frames.len() > 1 {
            let film = Multiples {
                frames: &self.frames,
                width_px: WIDTH / 2,
                ..film
            };
            animation_png(
                folder.join("damage-animation.png"),
                &film,
                SECONDS_PER_FRAME,
            )?;
        }
        if D == 2 {
            draw_path(folder, plan, model, tracker)
        } else {
            Ok(())
        }
    }

    /// As many frames as there are panels, the first and the last among them.
    fn thinned(&self) -> Vec<(f64, Vec<f64>)> {
        let (all, most) = (self.frames.len(), PANELS.min(self.frames.len()));
        let pick = |k: usize| self.frames[k * (all - 1) / (most - 1).max(1)].clone();
        (0..most).map(pick).collect()
    }
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
