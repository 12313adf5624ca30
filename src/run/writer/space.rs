//! Pictures of space: the three sections together, and where rock broke when.

use super::super::fracture::CrackTracker;
use super::pictures::Pictures;
use crate::geometry::Vector;
use crate::model::Disc;
use crate::output::{IsometricPlot, OutputError, Tile, isometric_png};
use crate::plan::TimeMode;
use crate::run::quantities::{Quantity, drawn};

const WIDTH: u32 = 900;

/// Damage from which on it is shown.
const NOTABLE: f64 = 0.1;

/// Quantities in the order in which one of them is shown: damage where there is some, pressure, displacement.
const FIRST: [usize; 3] = [3, 0, 1];

/// Draws the sections at the outputs, and in rock that can break the broken points; nothing in a plane.
///
/// # Errors
/// Those of [`isometric_png`].
pub(super) fn draw<const D: usize>(
    pictures: &Pictures<'_, D>,
    outputs: usize,
    tracker: &CrackTracker,
) -> Result<(), OutputError> {
    if D < 3 {
        return Ok(());
    }
    let all = drawn(D);
    for quantity in FIRST.map(|k| &all[k]) {
        if sections(pictures, quantity, outputs)? {
            break;
        }
    }
    surface(pictures, tracker)
}

/// Number, time, s, and pieces of the sections at an output.
type Frame = (usize, Option<f64>, Vec<Tile>);

/// The sections at all outputs in the colours of a quantity; empty where the scene does not name it.
fn frames<const D: usize>(
    pictures: &Pictures<'_, D>,
    quantity: &Quantity,
    outputs: usize,
) -> Result<Vec<Frame>, OutputError> {
    let Pictures {
        folder,
        model,
        sections,
        ..
    } = *pictures;
    let mut frames = Vec::new();
    for number in 0..outputs {
        let (mut tiles, mut time) = (Vec::new(), None);
        for section in &sections.all {
            let fields = sections.read(folder, section, number)?.unwrap_or_default();
            let Some(values) = quantity.of(&fields) else {
                continue;
            };
            time = fields.time;
            let points = section.points.iter().zip(section.sizes(model)).zip(values);
            tiles.extend(points.map(|((point, size), value)| Tile {
                at: of_three(&model.cloud.position[*point as usize]),
                normal: section.normal,
                size,
                value,
            }));
        }
        if !tiles.is_empty() {
            frames.push((number, time, tiles));
        }
    }
    Ok(frames)
}

/// Draws a quantity on all sections at all outputs; whether the scene names it.
fn sections<const D: usize>(
    pictures: &Pictures<'_, D>,
    quantity: &Quantity,
    outputs: usize,
) -> Result<bool, OutputError> {
    let Pictures { folder, plan, .. } = *pictures;
    let frames = frames(pictures, quantity, outputs)?;
    let values = || {
        frames
            .iter()
            .flat_map(|frame| frame.2.iter().map(|tile| tile.value))
    };
    // Rock that does not break says nothing.
    if quantity.file == "damage" && !values().any(|value| value > NOTABLE) {
        return Ok(false);
    }
    let range = quantity.spread(values());
    for (number, time, tiles) in &frames {
        let plot = IsometricPlot {
            title: &format!("{}: {}, three sections", plan.title, quantity.title),
            unit: quantity.unit,
            bounds: bounds(pictures),
            tiles,
            places: &[],
            size: 0.0,
            lines: &[],
            time: time.filter(|_| plan.time.mode == TimeMode::Transient),
            range,
            notes: &[],
            width_px: WIDTH,
        };
        isometric_png(folder.join(format!("sections-{number:04}.png")), &plot)?;
    }
    Ok(!frames.is_empty())
}

/// Places, m, of the points that broke after the start, with the time, s.
fn broken<const D: usize>(pictures: &Pictures<'_, D>, tracker: &CrackTracker) -> Vec<[f64; 4]> {
    let model = pictures.model;
    let cloud = &model.cloud;
    let banded = |point: usize| {
        let own = |band: &Vec<u32>| band.binary_search(&(point as u32)).is_ok();
        model.bands.points.iter().any(own)
    };
    let broken = tracker.broken_at.iter().enumerate();
    broken
        .filter(|(point, at)| at.is_finite() && !banded(*point))
        .map(|(point, at)| {
            let [x, y, z] = of_three(&cloud.position[point]);
            [x, y, z, *at]
        })
        .collect()
}

/// Draws rims of the cracks from the start and the points that broke since, by time.
fn surface<const D: usize>(
    pictures: &Pictures<'_, D>,
    tracker: &CrackTracker,
) -> Result<(), OutputError> {
    let Pictures {
        folder,
        plan,
        model,
        ..
    } = *pictures;
    if plan.damage.is_none() {
        return Ok(());
    }
    let places = broken(pictures, tracker);
    let discs = plan
        .cracks
        .iter()
        .filter_map(|own| Disc::<D>::of(&own.place));
    let rims: Vec<Vec<[f64; 3]>> = discs
        .map(|disc| disc.rim().iter().map(of_three).collect())
        .collect();
    let (colours, note) = match places.is_empty() {
        true => ("", "nothing broke after the start"),
        false => (
            ", colours: time at which a point broke",
            "a disc at each point that broke after the start",
        ),
    };
    let mut notes = vec![note.to_owned()];
    notes
        .extend((!rims.is_empty()).then(|| "dark lines: rims of cracks from the start".to_owned()));
    let edges = model.cloud.cell.iter().map(|cell| cell.min());
    let size = edges.fold(f64::INFINITY, f64::min);
    let plot = IsometricPlot {
        title: &format!("{}: crack surface{colours}", plan.title),
        unit: "s",
        bounds: bounds(pictures),
        tiles: &[],
        places: &places,
        size: 0.6 * size,
        lines: &rims,
        time: None,
        range: None,
        notes: &notes,
        width_px: WIDTH,
    };
    isometric_png(folder.join("crack-surface.png"), &plot)
}

fn of_three<const D: usize>(x: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|k| x.as_slice().get(k).copied().unwrap_or(0.0))
}

fn bounds<const D: usize>(pictures: &Pictures<'_, D>) -> [[f64; 3]; 2] {
    let domain = &pictures.model.cloud.domain;
    [of_three(&domain.lower), of_three(&domain.upper)]
}
