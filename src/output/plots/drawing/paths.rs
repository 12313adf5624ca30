//! Paths of cracks through a plane domain, as SVG drawings.

use std::collections::BTreeSet;
use std::path::Path;

use plotters_backend::DrawingBackend;

use super::canvas::{BLACK, Canvas};
use super::clip::clipped;
use super::colours::ColourScale;
use super::layout::{Content, Layout};
use super::lines::render;
use super::multiples::unsupported;
use super::page::Page;
use super::raster::Window;
use super::units::{Shown, axis_label, engineering};
use super::{Drawn, PathPlot, Place};
use crate::output::{OutputError, write_atomically};

/// Width of the drawing, px.
const WIDTH: f64 = 900.0;

/// Width of cracks that are there from the start, px.
const STROKE: f64 = 4.0;

/// Radius of the mark of a broken place and width of its dark rim, px. Without the rim the late ones
/// would be too pale on white.
const MARK: f64 = 2.4;
const RIM: f64 = 0.7;

/// Broken places nearer to each other than this are drawn as one, px.
const NEAR: f64 = 0.5;

/// Draws crack paths coloured by time as an SVG drawing, written atomically.
///
/// # Errors
/// [`OutputError::Unsupported`] for a domain without area and for numbers that are not finite,
/// [`OutputError::Drawing`] if the drawing fails, else those of [`write_atomically`].
pub fn paths_svg(path: impl AsRef<Path>, plot: &PathPlot<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    check(path, plot)?;
    let text = draw(plot).map_err(|reason| OutputError::Drawing {
        path: path.to_path_buf(),
        reason,
    })?;
    write_atomically(path, |writer| writer.write_all(text.as_bytes()))
}

fn check(path: &Path, plot: &PathPlot<'_>) -> Result<(), OutputError> {
    let [low, high] = plot.bounds;
    let extent = [high[0] - low[0], high[1] - low[1]];
    if !extent.iter().all(|&edge| edge.is_finite() && edge > 0.0) {
        let (found, allowed) = (
            format!("{low:?} to {high:?}"),
            "finite, from the lower left to the upper right corner",
        );
        return Err(unsupported(path, "the domain", found, allowed));
    }
    for (number, line) in (1..).zip(plot.initial) {
        if let Some(corner) = line.iter().find(|c| !c.iter().all(|v| v.is_finite())) {
            let what = format!("a corner of crack {number}");
            return Err(unsupported(path, what, format!("{corner:?}"), "finite"));
        }
    }
    for (number, point) in (1..).zip(plot.points) {
        if !point.iter().all(|value| value.is_finite()) {
            let what = format!("broken place {number}");
            return Err(unsupported(path, what, format!("{point:?}"), "finite"));
        }
    }
    Ok(())
}

fn draw(plot: &PathPlot<'_>) -> Drawn<String> {
    let [low, high] = plot.bounds;
    let window = Window {
        left: low[0],
        right: high[0],
        bottom: low[1],
        top: high[1],
    };
    let times = plot.points.iter().map(|point| point[2]);
    let colours = ColourScale::over(times, None, false);
    let (seconds, metres) = handy_units(&colours, plot.bounds);
    let (x, y) = window.axes();
    let unit = match plot.points {
        [] => String::new(),
        _ => axis_label("time", &seconds.unit),
    };
    let content = Content {
        width: WIDTH,
        title: plot.title,
        time: "",
        unit: &unit,
        notes: &notes(plot, &colours),
        x: x.divided(metres.divisor),
        y: y.divided(metres.divisor),
        bar: colours.axis.divided(seconds.divisor),
    };
    let layout = Layout::fit(&content)?;
    let page = Page {
        content: &content,
        layout: &layout,
        metres: &metres,
        axes: ["x", "y"],
    };
    let place = |[px, py]: [f64; 2]| layout.frame.place((x.fraction(px), y.fraction(py)));
    render((plot.title, None), (WIDTH, layout.height), |canvas| {
        page.texts(canvas)?;
        if !plot.points.is_empty() {
            page.bar(&colours).draw(canvas)?;
        }
        page.axes(canvas)?;
        draw_initial(canvas, plot, place)?;
        draw_points(canvas, &visible(plot, place), &colours)
    })
}

/// Units of the times and of the axes.
fn handy_units(colours: &ColourScale, [low, high]: [[f64; 2]; 2]) -> (Shown, Shown) {
    let latest = colours.axis.high.abs().max(colours.axis.low.abs());
    let ends = [low, high].concat();
    let farthest = ends.iter().fold(0.0, |most: f64, end| most.max(end.abs()));
    // Halved, so that a domain of 10 cm is told in millimetres.
    (engineering("s", latest), engineering("m", 0.5 * farthest))
}

fn draw_initial<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    plot: &PathPlot<'_>,
    place: impl Fn([f64; 2]) -> Place,
) -> Drawn<()> {
    for line in plot.initial {
        for piece in clipped(line, plot.bounds) {
            let places: Vec<Place> = piece.into_iter().map(&place).collect();
            canvas.polyline(&places, STROKE, BLACK)?;
        }
    }
    Ok(())
}

fn notes(plot: &PathPlot<'_>, colours: &ColourScale) -> Vec<String> {
    let mut notes: Vec<String> = plot.note.into_iter().map(str::to_owned).collect();
    if !plot.initial.is_empty() {
        notes.push("dark lines: cracks from the start".to_owned());
    }
    if plot.points.is_empty() {
        notes.push("nothing broke".to_owned());
    } else if colours.constant {
        notes.push("everything broke at the same time".to_owned());
    }
    let total = plot.points.len();
    let outside = plot.points.iter().filter(|point| !inside(plot, point));
    match outside.count() {
        0 => {}
        count => notes.push(format!(
            "{count} of {total} broken places lie outside the domain"
        )),
    }
    notes
}

fn inside(plot: &PathPlot<'_>, point: &[f64; 3]) -> bool {
    let [low, high] = plot.bounds;
    (0..2).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]))
}

/// Broken places in the domain with their times, in the order of time. Of those that would hide each
/// other only the earliest stays, which bounds the size of the drawing.
fn visible(plot: &PathPlot<'_>, place: impl Fn([f64; 2]) -> Place) -> Vec<(Place, f64)> {
    let mut points: Vec<&[f64; 3]> = plot.points.iter().filter(|p| inside(plot, p)).collect();
    points.sort_by(|a, b| a[2].total_cmp(&b[2]));
    let mut taken = BTreeSet::new();
    let placed = points.iter().map(|&&[x, y, time]| (place([x, y]), time));
    placed
        .filter(|((x, y), _)| taken.insert(((x / NEAR) as i64, (y / NEAR) as i64)))
        .collect()
}

/// Draws all rims before the marks, so that the marks of a dense path join.
fn draw_points<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    points: &[(Place, f64)],
    colours: &ColourScale,
) -> Drawn<()> {
    for (place, _) in points {
        canvas.disc(*place, MARK + RIM, BLACK)?;
    }
    for (place, time) in points {
        canvas.disc(*place, MARK, colours.colour(*time))?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "paths_tests.rs"]
mod tests;
