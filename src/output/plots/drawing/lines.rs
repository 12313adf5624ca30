//! Curves over a common axis, as SVG drawings.

use std::path::Path;

use plotters_backend::DrawingBackend;
use plotters_svg::SVGBackend;

use super::axes::{Axes, Frame, widest};
use super::canvas::{Anchor, Canvas, DIM, SVG_UNITS, Text, WHITE};
use super::curves::{Curve, Shown, curves, dense, draw_curve, drawable, pairs, shown_x, shown_y};
use super::font::wrap;
use super::legend::{Legend, Look};
use super::numbers::numbers;
use super::{Drawn, LinePlot, LineStyle, Place, Series, WIDE};
use crate::output::{OutputError, write_atomically};

/// Height of the frame without title, notes and outer legend, px.
const FRAME_HEIGHT: f64 = 430.0;

/// Font size of the numbers, px.
const SIZE: f64 = 15.0;

/// Draws curves with axes and legend as an SVG drawing, written atomically.
///
/// # Errors
/// [`OutputError::Shape`] if a series has different numbers of `x` and `y`,
/// [`OutputError::Drawing`] if the drawing fails, else those of [`write_atomically`].
pub fn lines_svg(path: impl AsRef<Path>, plot: &LinePlot<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    for series in plot.series {
        let what = format!("y of the series {:?}", series.label);
        OutputError::check_length(path, &what, series.x.len(), series.y.len())?;
    }
    let text = draw(plot, WIDE).map_err(|reason| OutputError::Drawing {
        path: path.to_path_buf(),
        reason,
    })?;
    write_atomically(path, |writer| writer.write_all(text.as_bytes()))
}

/// Draws curves with axes and legend as the text of an SVG drawing of a width such as [`WIDE`] or
/// [`NARROW`](crate::output::NARROW).
///
/// # Errors
/// The reason, as in [`OutputError::Drawing`].
pub fn lines_text(plot: &LinePlot<'_>, width: f64) -> Result<String, String> {
    for series in plot.series {
        if series.x.len() != series.y.len() {
            return Err(format!(
                "the series {:?} has {} x and {} y",
                series.label,
                series.x.len(),
                series.y.len()
            ));
        }
    }
    draw(plot, width)
}

/// Where the parts of the drawing go, in pixels.
struct Layout {
    title: Vec<String>,
    notes: Vec<String>,
    frame: Frame,
    y_label_at: f64,
    legend: Place,
    notes_top: f64,
    height: f64,
}

fn looks(plot: &LinePlot<'_>) -> Vec<Look> {
    let solid = plot
        .series
        .iter()
        .filter(|s| s.style == LineStyle::Line)
        .count();
    let mut next = 0;
    let look = |series: &Series<'_>| {
        next += usize::from(next == 0 || !series.label.is_empty());
        Look {
            index: next - 1,
            style: series.style,
            marked: solid > 1 && series.style == LineStyle::Line,
        }
    };
    plot.series.iter().map(look).collect()
}

fn draw(plot: &LinePlot<'_>, width: f64) -> Drawn<String> {
    let (x, y, looks) = (shown_x(plot), shown_y(plot), looks(plot));
    let labels = plot
        .series
        .iter()
        .map(|s| s.label)
        .zip(looks.iter().copied())
        .collect();
    let legend = Legend::within(labels, SIZE, width - SIZE)?;
    let layout = arrange(plot, width, &legend, &y, |frame| {
        curves(plot, &looks, frame, &x, &y)
    })?;
    let frame = layout.frame;
    let curves = curves(plot, &looks, &frame, &x, &y);
    // Drawings for narrow screens stand beside a wide one, which has the numbers.
    let data = (width >= WIDE).then(|| numbers(plot, &looks, (&x, &y)));
    render((plot.title, data), (width, layout.height), |canvas| {
        texts(canvas, &layout)?;
        let axes = Axes {
            frame,
            x: x.axis,
            y: y.axis,
            x_label: &x.label,
            y_label: &y.label,
            size: SIZE,
            y_label_at: layout.y_label_at,
            grid: true,
        };
        axes.draw(canvas)?;
        frame.outline(canvas, 1.0)?;
        curves
            .iter()
            .try_for_each(|curve| draw_curve(canvas, curve, curves.len()))?;
        if legend.is_empty() {
            Ok(())
        } else {
            legend.draw(canvas, layout.legend)
        }
    })
}

/// Finds places for everything; the legend goes into a free corner, else beside the frame, else
/// below it.
fn arrange(
    plot: &LinePlot<'_>,
    width: f64,
    legend: &Legend<'_>,
    y: &Shown,
    curves_in: impl Fn(&Frame) -> Vec<Curve>,
) -> Drawn<Layout> {
    let title = wrap(plot.title, 1.3 * SIZE, true, width - 2.0 * SIZE)?;
    let top = SIZE * (1.4 + 1.9 * title.len() as f64);
    let numbers = widest(&y.axis.ticks_up(FRAME_HEIGHT, SIZE), SIZE)?;
    let left = (4.3 * SIZE + numbers).round();
    let mut frame = Frame {
        left,
        top,
        width: width - left - 2.0 * SIZE,
        height: FRAME_HEIGHT,
    };
    let mut below = frame.bottom() + 4.0 * SIZE;
    let mut place = (left, below);
    if let Some(corner) = legend.free_corner(&frame, &dense(&curves_in(&frame))) {
        place = corner;
    } else if legend.width < 0.4 * width && legend.height < FRAME_HEIGHT {
        frame.width -= legend.width + SIZE;
        place = (frame.right() + SIZE, frame.top);
    } else if !legend.is_empty() {
        // Long labels may need more than the width of the frame.
        place.0 = left.min(width - legend.width - SIZE).max(0.3 * SIZE);
        below += legend.height + SIZE;
    }
    let mut notes = Vec::new();
    for note in remarks(plot) {
        notes.extend(wrap(&note, SIZE, false, width - 2.0 * SIZE)?);
    }
    let height = (below + 1.5 * SIZE * notes.len() as f64 + 0.3 * SIZE).ceil();
    let (y_label_at, notes_top) = (left - 2.0 * SIZE - numbers, below + 0.5 * SIZE);
    Ok(Layout {
        title,
        notes,
        frame,
        y_label_at,
        legend: place,
        notes_top,
        height,
    })
}

fn remarks(plot: &LinePlot<'_>) -> Vec<String> {
    let mut remarks: Vec<String> = plot.note.into_iter().map(str::to_owned).collect();
    if pairs(plot).next().is_none() {
        remarks.push("no values to draw".to_owned());
    }
    let all = plot.series.iter().flat_map(|s| s.x.iter().zip(s.y));
    let hidden = all.filter(|&(&x, &y)| x.is_finite() && y.is_finite() && !drawable(plot, x, y));
    match hidden.count() {
        0 => {}
        1 => remarks.push("1 value ≤ 0 has no place on the logarithmic axis".to_owned()),
        n => remarks.push(format!(
            "{n} values ≤ 0 have no place on the logarithmic axis"
        )),
    }
    remarks
}

fn texts<B: DrawingBackend>(canvas: &mut Canvas<B>, layout: &Layout) -> Drawn<()> {
    let bold = Text {
        bold: true,
        ..Text::new(1.3 * SIZE, Anchor::Left)
    };
    for (index, line) in layout.title.iter().enumerate() {
        canvas.text(line, (SIZE, SIZE * (1.75 + 1.9 * index as f64)), bold)?;
    }
    let dim = Text {
        colour: DIM,
        ..Text::new(SIZE, Anchor::Left)
    };
    for (index, line) in layout.notes.iter().enumerate() {
        canvas.text(
            line,
            (SIZE, layout.notes_top + 1.5 * SIZE * index as f64),
            dim,
        )?;
    }
    Ok(())
}

/// Draws in fine units and gives the drawing its size in pixels, a title, and data in JSON that it carries.
pub(super) fn render(
    (title, data): (&str, Option<String>),
    (width, height): (f64, f64),
    paint: impl FnOnce(&mut Canvas<SVGBackend<'_>>) -> Drawn<()>,
) -> Drawn<String> {
    let fine = ((width as u32) * SVG_UNITS, (height as u32) * SVG_UNITS);
    let mut body = String::new();
    let mut canvas = Canvas::vector(SVGBackend::with_string(&mut body, fine));
    canvas.rectangle((0.0, 0.0), (width, height), WHITE)?;
    paint(&mut canvas)?;
    canvas.finish()?;
    let (_, content) = body.split_once('\n').ok_or("the drawing is empty")?;
    let title = crate::output::vtk::escape(title);
    let data = data.map_or_else(String::new, |json| {
        format!(
            "<metadata>{}</metadata>\n",
            crate::output::vtk::escape(&json)
        )
    });
    Ok(format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" \
         stroke-linejoin=\"round\" xmlns=\"http://www.w3.org/2000/svg\">\n\
         <title>{title}</title>\n{data}{content}",
        fine.0, fine.1
    ))
}

#[cfg(test)]
#[path = "lines_tests.rs"]
mod tests;
