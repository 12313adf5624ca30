//! One field at several times, panel by panel.

use std::path::Path;

use plotters_backend::DrawingBackend;
use plotters_bitmap::BitMapBackend;

use super::axes::{Axes, Axis};
use super::bar::Bar;
use super::canvas::{Anchor, Canvas, DIM, Text};
use super::colours::ColourScale;
use super::field::{WIDTHS, cells, of_lines, units};
use super::grid::{Contents, Grid, Panel};
use super::overlay::{draw_lines, draw_outlines};
use super::raster::{Picture, paint_cells, write_png};
use super::units::{axis_label, readable_time};
use super::{Drawn, FieldPlot, Multiples, Scale};
use crate::output::OutputError;

/// Most panels of one picture.
const MOST_PANELS: usize = 12;

/// Draws up to 12 frames side by side as a PNG picture with one colour bar, written atomically. The
/// caller chooses which frames to show.
///
/// # Errors
/// [`OutputError::Shape`] for arrays that do not fit together, [`OutputError::Unsupported`] without
/// points, for no frames or more than 12 and for times that are not finite,
/// [`OutputError::Drawing`] if the picture fails, else those of [`write_atomically`](crate::output::write_atomically).
pub fn multiples_png(path: impl AsRef<Path>, plot: &Multiples<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    plot.check(path)?;
    if plot.frames.len() > MOST_PANELS {
        let count = plot.frames.len().to_string();
        return Err(unsupported(path, "the number of frames", count, "1 to 12"));
    }
    write_png(path, draw(plot))
}

/// The error for an argument that is out of bounds.
pub(super) fn unsupported(
    path: &Path,
    what: impl Into<String>,
    found: impl Into<String>,
    allowed: &'static str,
) -> OutputError {
    OutputError::Unsupported {
        path: path.to_path_buf(),
        what: what.into(),
        found: found.into(),
        allowed,
    }
}

impl<'a> Multiples<'a> {
    /// Refuses what cannot be drawn, whatever the number of frames.
    pub(super) fn check(&self, path: &Path) -> Result<(), OutputError> {
        let points = self.sizes.len();
        OutputError::check_length(path, "positions", 2 * points, self.positions.len())?;
        for (number, (time, values)) in (1..).zip(self.frames) {
            OutputError::check_length(path, &format!("frame {number}"), points, values.len())?;
            if !time.is_finite() {
                let what = format!("the time of frame {number}");
                return Err(unsupported(path, what, time.to_string(), "finite"));
            }
        }
        for (what, count) in [("frames", self.frames.len()), ("points", points)] {
            if count == 0 {
                let what = format!("the number of {what}");
                return Err(unsupported(path, what, "0", "1 or more"));
            }
        }
        Ok(())
    }

    /// The values of all frames, one after the other.
    pub(super) fn all(&self) -> impl Iterator<Item = f64> {
        self.frames
            .iter()
            .flat_map(|(_, values)| values.iter().copied())
    }

    /// Colours that suit all frames.
    pub(super) fn colours(&self) -> ColourScale {
        let range = self.range.map(|[low, high]| (low, high));
        ColourScale::over(self.all(), range, self.scale == Scale::Log10)
    }

    /// What a reader must know besides the colours.
    pub(super) fn notes(&self, colours: &ColourScale) -> Vec<String> {
        let mut notes = colours.remarks(self.all());
        notes.extend(of_lines(self.lines));
        notes
    }

    /// One frame as a picture of its own.
    pub(super) fn field(&self, (time, values): &'a (f64, Vec<f64>)) -> FieldPlot<'a> {
        FieldPlot {
            title: self.title,
            unit: self.unit,
            positions: self.positions,
            dimension: 2,
            sizes: self.sizes,
            values,
            time: Some(*time),
            scale: self.scale,
            range: self.range.map(|[low, high]| (low, high)),
            width_px: self.width_px,
            axes: self.axes,
            lines: self.lines,
            outlines: self.outlines,
            source: None,
        }
    }
}

fn draw(plot: &Multiples<'_>) -> Drawn<Picture> {
    let colours = plot.colours();
    let (painted, windows): (Vec<_>, Vec<_>) = plot
        .frames
        .iter()
        .map(|frame| cells(&plot.field(frame), &colours))
        .unzip();
    let window = windows.first().ok_or("there are no frames")?;
    let (bar, metres) = units(plot.unit, &colours, window);
    let (x, y) = window.axes();
    let time = |(time, _): &(f64, _)| format!("t = {}", readable_time(*time));
    let contents = Contents {
        width: f64::from(plot.width_px.clamp(WIDTHS.0, WIDTHS.1)),
        title: &axis_label(plot.title, &bar.unit),
        times: &plot.frames.iter().map(time).collect::<Vec<_>>(),
        notes: &plot.notes(&colours),
        x: x.divided(metres.divisor),
        y: y.divided(metres.divisor),
        bar: colours.axis.divided(bar.divisor),
    };
    let grid = Grid::fit(&contents)?;
    let mut picture = Picture::white(contents.width as usize, grid.height as usize);
    let squares = grid
        .panels
        .iter()
        .zip(&painted)
        .filter(|_| plot.outlines.is_empty());
    for (panel, cells) in squares {
        paint_cells(&mut picture, &panel.frame, window, cells);
    }
    let size = (picture.width as u32, picture.height as u32);
    let mut canvas = Canvas::bitmap(BitMapBackend::with_buffer(&mut picture.pixels, size));
    texts(
        &mut canvas,
        &grid,
        plot.axes.map(|name| axis_label(name, &metres.unit)),
    )?;
    for (panel, cells) in grid.panels.iter().zip(&painted) {
        draw_outlines(&mut canvas, (plot.outlines, cells), &panel.frame, window)?;
        draw_lines(&mut canvas, plot.lines, &panel.frame, window)?;
    }
    for (panel, time) in grid.panels.iter().zip(contents.times) {
        draw_panel(&mut canvas, &grid, panel, (contents.x, contents.y), time)?;
    }
    bar_beside(&grid, &colours, contents.bar).draw(&mut canvas)?;
    canvas.finish()?;
    Ok(picture)
}

/// Title, notes and the labels that all panels share.
fn texts<B: DrawingBackend>(canvas: &mut Canvas<B>, grid: &Grid, [x, y]: [String; 2]) -> Drawn<()> {
    let size = grid.size;
    let title = Text {
        bold: true,
        ..Text::new(grid.title_size(), Anchor::Left)
    };
    for (index, line) in grid.title.iter().enumerate() {
        let y = size * (1.75 + 1.9 * index as f64);
        canvas.text(line, (grid.left, y), title)?;
    }
    let dim = Text {
        colour: DIM,
        ..Text::new(size, Anchor::Left)
    };
    for (index, line) in grid.notes.iter().enumerate() {
        let y = grid.notes_top + 1.5 * size * index as f64;
        canvas.text(line, (grid.left, y), dim)?;
    }
    let label = Text::new(1.08 * size, Anchor::Middle);
    canvas.text(&x, grid.x_label, label)?;
    let upwards = Text {
        upwards: true,
        ..label
    };
    canvas.text(&y, grid.y_label, upwards)
}

fn draw_panel<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    grid: &Grid,
    panel: &Panel,
    (x, y): (Axis, Axis),
    time: &str,
) -> Drawn<()> {
    let (frame, size) = (panel.frame, grid.size);
    let axes = Axes {
        frame,
        x,
        y,
        x_label: "",
        y_label: "",
        size,
        y_label_at: frame.left,
        grid: false,
    };
    if panel.lowest {
        axes.draw_x(canvas)?;
    }
    if panel.leftmost {
        axes.draw_y(canvas)?;
    }
    frame.outline(canvas, (size / 14.0).round().max(1.0))?;
    let place = (frame.left + 0.5 * frame.width, frame.top - 0.9 * size);
    canvas.text(time, place, Text::new(size, Anchor::Middle))
}

/// The bar of all panels; its unit stands in the title.
fn bar_beside<'a>(grid: &'a Grid, colours: &'a ColourScale, axis: Axis) -> Bar<'a> {
    Bar {
        frame: grid.bar,
        below: false,
        colours,
        axis,
        size: grid.size,
        unit: "",
        unit_at: (grid.bar.left, grid.bar.top),
    }
}

#[cfg(test)]
#[path = "multiples_tests.rs"]
mod tests;
