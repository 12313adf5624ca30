//! Pictures of fields: the whole plane in 2-D, the middle layer of points in 3-D.

use std::path::Path;

use crate::model::Model;
use crate::output::{FieldPlot, OutputError, Scale, field_png};
use crate::plan::{Plan, TimeMode};
use crate::schemes::State;

const PICTURE_WIDTH: u32 = 900;

/// What a picture shows.
struct Picture<'a> {
    file: &'a str,
    title: &'a str,
    unit: &'a str,
    values: &'a [f64],
    time: Option<f64>,
    scale: Scale,
}

/// Draws the fields of output `number`: pressure, and how far every point has moved.
///
/// # Errors
/// Those of [`field_png`].
pub(super) fn of_output<const D: usize>(
    folder: &Path,
    number: usize,
    plan: &Plan,
    model: &Model<D>,
    state: &State,
) -> Result<(), OutputError> {
    let damage = damage_of(model, state);
    let moved: Vec<f64> = state.shown_displacement().chunks(D).map(length).collect();
    let all = [
        ("pressure", "Pa", &state.pressure),
        ("displacement", "m", &moved),
        ("damage", "1", &damage),
    ];
    for (title, unit, values) in all.into_iter().filter(|(_, _, v)| !v.is_empty()) {
        let picture = Picture {
            file: &format!("{title}-{number:04}.png"),
            title,
            unit,
            values,
            time: (plan.time.mode == TimeMode::Transient).then_some(state.time),
            scale: Scale::Linear,
        };
        draw(folder, model, &picture)?;
    }
    Ok(())
}

/// Damage per point; empty without damage.
pub(super) fn damage_of<const D: usize>(model: &Model<D>, state: &State) -> Vec<f64> {
    let damage = model.solid.as_ref().and_then(|solid| solid.damage.as_ref());
    damage.map_or_else(Vec::new, |damage| damage.of(&state.history))
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Draws the permeability where it varies.
///
/// # Errors
/// Those of [`field_png`].
pub(super) fn of_permeability<const D: usize>(
    folder: &Path,
    model: &Model<D>,
) -> Result<(), OutputError> {
    let values = &model.permeability;
    let extremes = |(low, high): (f64, f64), &k: &f64| (low.min(k), high.max(k));
    let (low, high) = values.iter().fold((f64::INFINITY, 0.0), extremes);
    if model.flow.is_none() || high <= low * (1.0 + 1e-12) {
        return Ok(());
    }
    let scale = match high > 30.0 * low {
        true => Scale::Log10,
        false => Scale::Linear,
    };
    let picture = Picture {
        file: "permeability.png",
        title: "permeability",
        unit: "m²",
        values,
        time: None,
        scale,
    };
    draw(folder, model, &picture)
}

fn draw<const D: usize>(
    folder: &Path,
    model: &Model<D>,
    picture: &Picture<'_>,
) -> Result<(), OutputError> {
    let cloud = &model.cloud;
    let shown = shown_points(model);
    let positions: Vec<f64> = shown
        .iter()
        .flat_map(|&i| [cloud.position[i][0], cloud.position[i][1]])
        .collect();
    // Squares as large as the longer edge: narrow cells of tensor grids leave no gaps.
    let sizes: Vec<f64> = shown
        .iter()
        .map(|&i| cloud.cell[i].fixed_rows::<2>(0).max())
        .collect();
    let values: Vec<f64> = shown.iter().map(|&i| picture.values[i]).collect();
    let layer = if D == 3 { ", middle layer" } else { "" };
    let plot = FieldPlot {
        title: &format!("{}{layer}", picture.title),
        unit: picture.unit,
        positions: &positions,
        dimension: 2,
        sizes: &sizes,
        values: &values,
        time: picture.time,
        scale: picture.scale,
        range: None,
        width_px: PICTURE_WIDTH,
    };
    field_png(folder.join(picture.file), &plot)
}

/// All points in 2-D; in 3-D those of the layer nearest to the middle of the domain.
pub(super) fn shown_points<const D: usize>(model: &Model<D>) -> Vec<usize> {
    let cloud = &model.cloud;
    if D == 2 {
        return (0..cloud.len()).collect();
    }
    let middle = 0.5 * (cloud.domain.lower[2] + cloud.domain.upper[2]);
    let within = |&i: &usize| (cloud.position[i][2] - middle).abs() <= 0.5001 * cloud.cell[i][2];
    let near: Vec<usize> = (0..cloud.len()).filter(within).collect();
    // An even number of layers has two beside the middle; one is enough.
    let lowest = near
        .iter()
        .map(|&i| cloud.position[i][2])
        .fold(f64::INFINITY, f64::min);
    near.into_iter()
        .filter(|&i| cloud.position[i][2] < lowest + 0.25 * cloud.cell[i][2])
        .collect()
}
