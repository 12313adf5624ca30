//! Pictures of a field over the plane.

use std::path::Path;

use plotters_bitmap::BitMapBackend;

use super::axes::Axis;
use super::canvas::Canvas;
use super::colours::ColourScale;
use super::layout::{Content, Layout};
use super::overlay::{draw_lines, draw_outlines};
use super::page::Page;
use super::raster::{Cell, Picture, Window, paint_cells, write_png};
use super::units::{Shown, engineering, readable_time};
use super::{Drawn, FieldPlot, PictureFacts, Scale};
use crate::output::OutputError;

/// Limits of the width of a picture, px.
pub(super) const WIDTHS: (u32, u32) = (400, 8000);

/// Draws a field as a PNG picture with axes in metres and a colour bar, written atomically.
///
/// # Errors
/// [`OutputError::Shape`] for arrays that do not fit together, [`OutputError::Unsupported`] for
/// another dimension, [`OutputError::Drawing`] if the picture fails, else those of
/// [`write_atomically`](crate::output::write_atomically).
pub fn field_png(path: impl AsRef<Path>, plot: &FieldPlot<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    check(path, plot)?;
    write_png(path, draw(plot))
}

fn check(path: &Path, plot: &FieldPlot<'_>) -> Result<(), OutputError> {
    if !matches!(plot.dimension, 2 | 3) {
        return Err(OutputError::Unsupported {
            path: path.to_path_buf(),
            what: "the dimension".to_owned(),
            found: plot.dimension.to_string(),
            allowed: "2 or 3",
        });
    }
    let points = plot.values.len();
    OutputError::check_length(
        path,
        "positions",
        points * plot.dimension,
        plot.positions.len(),
    )?;
    if !plot.outlines.is_empty() {
        OutputError::check_length(path, "outlines of cells", points, plot.outlines.len())?;
    }
    OutputError::check_length(path, "cell sizes", points, plot.sizes.len())
}

fn draw(plot: &FieldPlot<'_>) -> Drawn<Picture> {
    let colours = ColourScale::new(plot.values, plot.range, plot.scale == Scale::Log10);
    let mut notes = colours.remarks(plot.values.iter().copied());
    notes.extend(of_lines(plot.lines));
    draw_in(plot, &colours, &notes)
}

/// What lines over a field are.
pub(super) fn of_lines(lines: &[Vec<[f64; 2]>]) -> Option<String> {
    (!lines.is_empty()).then(|| "dark lines: cracks from the start".to_owned())
}

/// Draws the field in given colours with given notes, whatever the plot says of its range. Pictures
/// that differ only in values and time have the same size.
pub(super) fn draw_in(
    plot: &FieldPlot<'_>,
    colours: &ColourScale,
    notes: &[String],
) -> Drawn<Picture> {
    let (cells, window) = cells(plot, colours);
    let (bar, metres) = units(plot.unit, colours, &window);
    let time = plot
        .time
        .map_or(String::new(), |time| format!("t = {}", readable_time(time)));
    let (x, y) = window.axes();
    let content = Content {
        width: f64::from(plot.width_px.clamp(WIDTHS.0, WIDTHS.1)),
        title: plot.title,
        time: &time,
        unit: &bar.unit,
        notes,
        x: x.divided(metres.divisor),
        y: y.divided(metres.divisor),
        bar: colours.axis.divided(bar.divisor),
    };
    let layout = Layout::fit(&content)?;
    let mut picture = Picture::white(content.width as usize, layout.height as usize);
    picture.facts = facts(plot, colours, (&layout, &window));
    if plot.outlines.is_empty() {
        paint_cells(&mut picture, &layout.frame, &window, &cells);
    }
    let size = (picture.width as u32, picture.height as u32);
    let mut canvas = Canvas::bitmap(BitMapBackend::with_buffer(&mut picture.pixels, size));
    let page = Page {
        content: &content,
        layout: &layout,
        metres: &metres,
        axes: plot.axes,
    };
    draw_outlines(&mut canvas, (plot.outlines, &cells), &layout.frame, &window)?;
    draw_lines(&mut canvas, plot.lines, &layout.frame, &window)?;
    page.texts(&mut canvas)?;
    page.bar(colours).draw(&mut canvas)?;
    page.axes(&mut canvas)?;
    canvas.finish()?;
    Ok(picture)
}

/// Where the field stands in the picture, if there is a file that has its values.
fn facts(
    plot: &FieldPlot<'_>,
    colours: &ColourScale,
    (layout, window): (&Layout, &Window),
) -> Option<PictureFacts> {
    let frame = &layout.frame;
    Some(PictureFacts {
        title: plot.title.to_owned(),
        unit: plot.unit.to_owned(),
        time: plot.time,
        axes: plot.axes.map(str::to_owned),
        size: [
            f64::from(plot.width_px.clamp(WIDTHS.0, WIDTHS.1)),
            layout.height,
        ],
        frame: [frame.left, frame.top, frame.width, frame.height],
        window: [window.left, window.right, window.bottom, window.top],
        range: [colours.axis.low, colours.axis.high],
        lines: plot.lines.to_vec(),
        source: plot.source?.to_owned(),
    })
}

/// Units of the colour bar and of the axes.
pub(super) fn units(unit: &str, colours: &ColourScale, window: &Window) -> (Shown, Shown) {
    let Axis {
        low,
        high,
        logarithmic,
    } = colours.axis;
    // Powers of ten stand at the marks of a logarithmic bar already.
    let largest = if logarithmic {
        1.0
    } else {
        high.abs().max(low.abs())
    };
    let ends = [window.left, window.right, window.bottom, window.top];
    let farthest = ends.iter().fold(0.0, |most: f64, end| most.max(end.abs()));
    (engineering(unit, largest), engineering("m", farthest))
}

/// Cells of all points with a finite position, and the window that holds them all.
pub(super) fn cells(plot: &FieldPlot<'_>, colours: &ColourScale) -> (Vec<Cell>, Window) {
    let usable = |size: &f64| size.is_finite() && *size > 0.0;
    let mut known: Vec<f64> = plot.sizes.iter().copied().filter(usable).collect();
    known.sort_unstable_by(f64::total_cmp);
    let usual = known.get(known.len() / 2).copied().unwrap_or(1.0);
    let points = plot
        .positions
        .chunks_exact(plot.dimension)
        .zip(plot.sizes)
        .zip(plot.values);
    let cells: Vec<Cell> = points
        .filter(|((position, _), _)| position[0].is_finite() && position[1].is_finite())
        .map(|((position, size), &value)| Cell {
            x: position[0],
            y: position[1],
            size: if usable(size) { *size } else { usual },
            colour: colours.colour(value),
        })
        .collect();
    let span = |centre: fn(&Cell) -> f64, axis: usize| {
        let corners = plot.outlines.iter().flatten().map(|corner| corner[axis]);
        let ends = cells
            .iter()
            .filter(|_| plot.outlines.is_empty())
            .flat_map(|c| [centre(c) - 0.5 * c.size, centre(c) + 0.5 * c.size]);
        Axis::covering(ends.chain(corners), false).0
    };
    let (x, y) = (span(|cell| cell.x, 0), span(|cell| cell.y, 1));
    let window = Window {
        left: x.low,
        right: x.high,
        bottom: y.low,
        top: y.high,
    };
    (cells, window)
}

#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
