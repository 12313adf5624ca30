//! Pictures of a field over the plane.

use std::path::Path;

use plotters_backend::DrawingBackend;
use plotters_bitmap::BitMapBackend;

use super::axes::{Axes, Axis};
use super::canvas::{Anchor, BLACK, Canvas, DIM, Text};
use super::colours::ColourScale;
use super::layout::{Content, Layout};
use super::raster::{Cell, Picture, Window, paint_cells};
use super::units::{Shown, axis_label, engineering, readable_time};
use super::{Drawn, Place};
use crate::output::{OutputError, write_atomically};

/// Limits of the width of a picture, px.
const WIDTHS: (u32, u32) = (400, 8000);

/// How values are spread over the colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their decimal logarithm; values that are not positive are grey.
    Log10,
}

/// A field over the plane, drawn as one coloured cell per point.
#[derive(Debug, Clone, Copy)]
pub struct FieldPlot<'a> {
    /// Title, such as `pressure`.
    pub title: &'a str,
    /// SI unit of the values, such as `Pa`; empty for pure numbers.
    pub unit: &'a str,
    /// Coordinates point by point, m. Shape `(points · dimension,)`.
    pub positions: &'a [f64],
    /// Coordinates per point, 2 or 3; only the first two are drawn, so that points in space should be
    /// those of one slice.
    pub dimension: usize,
    /// Edge of the square cell of each point, m. Shape `(points,)`.
    pub sizes: &'a [f64],
    /// Values. Shape `(points,)`. Those that are not finite are drawn in grey.
    pub values: &'a [f64],
    /// Simulated time, s.
    pub time: Option<f64>,
    /// Linear or logarithmic colours.
    pub scale: Scale,
    /// Values at the ends of the colour bar, in `unit`; by default the extremes of the values.
    pub range: Option<(f64, f64)>,
    /// Width of the picture, px; 400 to 8000, the height follows.
    pub width_px: u32,
}

/// Draws a field as a PNG picture with axes in metres and a colour bar, written atomically.
///
/// # Errors
/// [`OutputError::Shape`] for arrays that do not fit together, [`OutputError::Unsupported`] for
/// another dimension, [`OutputError::Drawing`] if the picture fails, else those of
/// [`write_atomically`].
pub fn field_png(path: impl AsRef<Path>, plot: &FieldPlot<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    check(path, plot)?;
    let bytes = draw(plot)
        .and_then(|picture| picture.encode())
        .map_err(|reason| OutputError::Drawing {
            path: path.to_path_buf(),
            reason,
        })?;
    write_atomically(path, |writer| writer.write_all(&bytes))
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
    OutputError::check_length(path, "cell sizes", points, plot.sizes.len())
}

fn draw(plot: &FieldPlot<'_>) -> Drawn<Picture> {
    let colours = ColourScale::new(plot.values, plot.range, plot.scale == Scale::Log10);
    let (cells, window) = cells(plot, &colours);
    let (bar, metres) = units(plot, &colours, &window);
    let time = plot
        .time
        .map_or(String::new(), |time| format!("t = {}", readable_time(time)));
    let (x, y) = window.axes();
    let content = Content {
        width: f64::from(plot.width_px.clamp(WIDTHS.0, WIDTHS.1)),
        title: plot.title,
        time: &time,
        unit: &bar.unit,
        notes: &notes(plot, &colours),
        x: x.divided(metres.divisor),
        y: y.divided(metres.divisor),
        bar: colours.axis.divided(bar.divisor),
    };
    let layout = Layout::fit(&content)?;
    let mut picture = Picture::white(content.width as usize, layout.height as usize);
    paint_cells(&mut picture, &layout.frame, &window, &cells);
    let size = (picture.width as u32, picture.height as u32);
    let mut canvas = Canvas::bitmap(BitMapBackend::with_buffer(&mut picture.pixels, size));
    let page = Page {
        content: &content,
        layout: &layout,
        colours: &colours,
        metres: &metres,
    };
    page.draw(&mut canvas)?;
    canvas.finish()?;
    Ok(picture)
}

/// Units of the colour bar and of the axes.
fn units(plot: &FieldPlot<'_>, colours: &ColourScale, window: &Window) -> (Shown, Shown) {
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
    (engineering(plot.unit, largest), engineering("m", farthest))
}

/// Cells of all points with a finite position, and the window that holds them all.
fn cells(plot: &FieldPlot<'_>, colours: &ColourScale) -> (Vec<Cell>, Window) {
    let usable = |size: &f64| size.is_finite() && *size > 0.0;
    let mut known: Vec<f64> = plot.sizes.iter().copied().filter(usable).collect();
    known.sort_by(f64::total_cmp);
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
    let span = |centre: fn(&Cell) -> f64| {
        let ends = cells
            .iter()
            .flat_map(|c| [centre(c) - 0.5 * c.size, centre(c) + 0.5 * c.size]);
        Axis::covering(ends, false).0
    };
    let (x, y) = (span(|cell| cell.x), span(|cell| cell.y));
    let window = Window {
        left: x.low,
        right: x.high,
        bottom: y.low,
        top: y.high,
    };
    (cells, window)
}

fn notes(plot: &FieldPlot<'_>, colours: &ColourScale) -> Vec<String> {
    let mut notes = Vec::new();
    let axis = colours.axis;
    let total = plot.values.len();
    let grey = plot
        .values
        .iter()
        .filter(|&&value| !axis.shows(value))
        .count();
    let beyond = |value: &&f64| axis.shows(**value) && !(axis.low..=axis.high).contains(*value);
    let beyond = plot.values.iter().filter(beyond).count();
    if total == 0 {
        notes.push("no points".to_owned());
    }
    if grey > 0 {
        let kind = if axis.logarithmic {
            "not finite or not positive"
        } else {
            "not finite"
        };
        notes.push(format!("grey: {grey} of {total} values are {kind}"));
    }
    if beyond > 0 {
        notes.push(format!(
            "{beyond} of {total} values lie beyond the ends of the colour bar"
        ));
    }
    if colours.constant {
        notes.push("all values are equal".to_owned());
    }
    notes
}

/// Everything but the cells.
struct Page<'a> {
    content: &'a Content<'a>,
    layout: &'a Layout,
    colours: &'a ColourScale,
    metres: &'a Shown,
}

impl Page<'_> {
    fn draw<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let Layout { size, frame, .. } = *self.layout;
        let line = (size / 14.0).round().max(1.0);
        self.texts(canvas)?;
        self.bar(canvas, line)?;
        let (x_label, y_label) = (
            axis_label("x", &self.metres.unit),
            axis_label("y", &self.metres.unit),
        );
        let widest = super::axes::widest(&self.content.y.ticks_up(frame.height, size), size)?;
        let axes = Axes {
            frame,
            x: self.content.x,
            y: self.content.y,
            x_label: &x_label,
            y_label: &y_label,
            size,
            y_label_at: frame.left - 0.65 * size - widest - 1.2 * size,
            grid: false,
        };
        axes.draw(canvas)?;
        frame.outline(canvas, line)
    }

    fn texts<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let layout = self.layout;
        let title = Text {
            bold: true,
            ..Text::new(layout.title_size(), Anchor::Left)
        };
        for (index, line) in layout.title.iter().enumerate() {
            let y = layout.size * (1.75 + 1.9 * index as f64);
            canvas.text(line, (layout.left, y), title)?;
        }
        let dim = Text {
            colour: DIM,
            ..Text::new(layout.size, Anchor::Left)
        };
        canvas.text(self.content.time, (layout.left, layout.heading), dim)?;
        for (index, line) in layout.notes.iter().enumerate() {
            let y = layout.notes_top + 1.5 * layout.size * index as f64;
            canvas.text(line, (layout.left, y), dim)?;
        }
        Ok(())
    }

    fn bar<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, line: f64) -> Drawn<()> {
        let (bar, axis) = (self.layout.bar, self.colours.axis);
        let below = self.layout.bar_below;
        let steps = if below { bar.width } else { bar.height } as usize;
        for step in 0..steps {
            let colour = self
                .colours
                .colour(axis.value((step as f64 + 0.5) / steps as f64));
            let at = step as f64;
            let (from, to) = if below {
                (
                    (bar.left + at, bar.top),
                    (bar.left + at + 1.0, bar.bottom()),
                )
            } else {
                (
                    (bar.left, bar.bottom() - at - 1.0),
                    (bar.right(), bar.bottom() - at),
                )
            };
            canvas.rectangle(from, to, colour)?;
        }
        bar.outline(canvas, line)?;
        self.bar_marks(canvas, line)
    }

    /// The place beside the bar at a value, `by` pixels away from it: below or to the right.
    fn beside_bar(&self, at: f64, by: f64) -> Place {
        let (bar, fraction) = (self.layout.bar, self.content.bar.fraction(at));
        if self.layout.bar_below {
            let (x, y) = bar.place((fraction, 0.0));
            return (x, y + by);
        }
        let (x, y) = bar.place((1.0, fraction));
        (x + by, y)
    }

    fn bar_marks<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, line: f64) -> Drawn<()> {
        let (bar, size, axis) = (self.layout.bar, self.layout.size, self.content.bar);
        for at in axis.minor_ticks() {
            let to = self.beside_bar(at, 0.2 * size);
            canvas.rule(self.beside_bar(at, 0.0), to, line, BLACK)?;
        }
        let (ticks, anchor, gap, unit_at) = if self.layout.bar_below {
            let unit_at = (bar.left + bar.width / 2.0, bar.bottom() + 2.75 * size);
            let ticks = axis.ticks_across(bar.width, size)?;
            (ticks, Anchor::Middle, 1.15, unit_at)
        } else {
            let unit_at = (bar.left, self.layout.heading);
            (axis.ticks_up(bar.height, size), Anchor::Left, 0.65, unit_at)
        };
        let text = Text::new(size, anchor);
        for tick in ticks {
            let to = self.beside_bar(tick.at, 0.35 * size);
            canvas.rule(self.beside_bar(tick.at, 0.0), to, line, BLACK)?;
            canvas.text(&tick.label, self.beside_bar(tick.at, gap * size), text)?;
        }
        canvas.text(self.content.unit, unit_at, text)
    }
}

#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
