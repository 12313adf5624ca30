//! Pictures of a model: points by material, conditions, wells, probes and cracks.

use std::path::Path;

use plotters_backend::DrawingBackend;
use plotters_bitmap::BitMapBackend;

use super::axes::{Axis, Frame};
use super::canvas::{Anchor, BLACK, Canvas, Colour, Text, WHITE};
use super::colours::{ColourScale, PALETTE};
use super::field::{WIDTHS, cells};
use super::layout::{Content, Layout};
use super::overlay::{draw_lines, draw_outlines};
use super::page::Page;
use super::raster::{Cell, Picture, Window, paint_cells, write_png};
use super::units::engineering;
use super::{About, Drawn, FieldPlot, Place, Scale, SetupMark, SetupPlot, SideSign, Sign};
use crate::output::OutputError;

/// Pale colours, on which points, signs and lines stand out.
const PALE: [Colour; 6] = [
    [232, 232, 228],
    [244, 221, 178],
    [205, 226, 243],
    [213, 236, 214],
    [242, 212, 228],
    [222, 214, 240],
];

/// Colour of the points.
const POINT: Colour = [130, 130, 130];

/// Most points that are drawn as dots.
const MOST_DOTS: usize = 20_000;

/// Draws a model as a PNG picture, written atomically.
///
/// # Errors
/// [`OutputError::Shape`] for arrays that do not fit together, [`OutputError::Drawing`] if the picture fails, else
/// those of [`write_atomically`](crate::output::write_atomically).
pub fn setup_png(path: impl AsRef<Path>, plot: &SetupPlot<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    let points = plot.group.len();
    OutputError::check_length(path, "positions", 2 * points, plot.positions.len())?;
    OutputError::check_length(path, "cell sizes", points, plot.sizes.len())?;
    write_png(path, draw(plot))
}

/// A place in the plane, m, as one on the picture.
struct View<'a> {
    frame: &'a Frame,
    x: Axis,
    y: Axis,
    /// Size of the numbers, px.
    size: f64,
}

fn draw(plot: &SetupPlot<'_>) -> Drawn<Picture> {
    let seen = painted(plot);
    let window = &seen.1;
    let (x, y) = window.axes();
    let ends = [x.low, x.high, y.low, y.high];
    let metres = engineering(
        "m",
        ends.iter().fold(0.0, |most: f64, end| most.max(end.abs())),
    );
    let names = plot.groups.iter().map(|name| format!("■ {name}"));
    let notes: Vec<String> = names.chain(plot.notes.iter().cloned()).collect();
    let content = Content {
        width: f64::from(plot.width_px.clamp(WIDTHS.0, WIDTHS.1)),
        title: plot.title,
        time: "",
        unit: "",
        notes: &notes,
        x: x.divided(metres.divisor),
        y: y.divided(metres.divisor),
        bar: Axis::covering(std::iter::empty(), false).0,
    };
    let layout = Layout::fit(&content)?;
    let mut picture = Picture::white(content.width as usize, layout.height as usize);
    if plot.outlines.is_empty() {
        paint_cells(&mut picture, &layout.frame, window, &seen.0);
    }
    let size = (picture.width as u32, picture.height as u32);
    let mut canvas = Canvas::bitmap(BitMapBackend::with_buffer(&mut picture.pixels, size));
    model(&mut canvas, plot, &layout, &seen)?;
    let page = Page {
        content: &content,
        layout: &layout,
        metres: &metres,
        axes: plot.axes,
    };
    page.texts(&mut canvas)?;
    swatches(&mut canvas, &layout)?;
    page.axes(&mut canvas)?;
    canvas.finish()?;
    Ok(picture)
}

/// Draws what stands in the frame.
fn model<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    plot: &SetupPlot<'_>,
    layout: &Layout,
    (painted, window): &(Vec<Cell>, Window),
) -> Drawn<()> {
    let (x, y) = window.axes();
    let view = View {
        frame: &layout.frame,
        x,
        y,
        size: layout.size,
    };
    draw_outlines(canvas, (plot.outlines, painted), &layout.frame, window)?;
    view.points(canvas, plot)?;
    draw_lines(canvas, plot.lines, &layout.frame, window)?;
    let mut sides = plot.sides.iter();
    sides.try_for_each(|side| view.side(canvas, side))?;
    let mut marks = plot.marks.iter();
    marks.try_for_each(|mark| view.mark(canvas, mark))
}

/// Cells in the colours of their groups.
fn painted(plot: &SetupPlot<'_>) -> (Vec<Cell>, Window) {
    let values: Vec<f64> = plot.group.iter().map(|group| *group as f64).collect();
    let field = FieldPlot {
        title: plot.title,
        unit: "",
        positions: plot.positions,
        dimension: 2,
        sizes: plot.sizes,
        values: &values,
        time: None,
        scale: Scale::Linear,
        range: None,
        width_px: plot.width_px,
        axes: plot.axes,
        lines: plot.lines,
        outlines: plot.outlines,
        source: None,
    };
    let (mut painted, window) = cells(&field, &ColourScale::new(&values, None, false));
    let places = plot.positions.chunks_exact(2).zip(plot.group);
    let shown = places.filter(|(place, _)| place.iter().all(|own| own.is_finite()));
    for (cell, (_, group)) in painted.iter_mut().zip(shown) {
        cell.colour = PALE[group % PALE.len()];
    }
    (painted, window)
}

/// Puts the colours of groups on the squares before their names.
fn swatches<B: DrawingBackend>(canvas: &mut Canvas<B>, layout: &Layout) -> Drawn<()> {
    let mut group = 0;
    for (index, line) in layout.notes.iter().enumerate() {
        if !line.starts_with('■') {
            continue;
        }
        let y = layout.notes_top + 1.5 * layout.size * index as f64;
        let text = Text {
            colour: PALE[group % PALE.len()],
            ..Text::new(layout.size, Anchor::Left)
        };
        canvas.text("■", (layout.left, y), text)?;
        group += 1;
    }
    Ok(())
}

impl About {
    fn colour(self) -> Colour {
        match self {
            About::Support => BLACK,
            About::Motion => PALETTE[1],
            About::Load => PALETTE[2],
            About::Fluid => PALETTE[0],
        }
    }
}

impl View<'_> {
    fn place(&self, [x, y]: [f64; 2]) -> Place {
        self.frame.place((self.x.fraction(x), self.y.fraction(y)))
    }

    fn points<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, plot: &SetupPlot<'_>) -> Drawn<()> {
        if plot.group.len() > MOST_DOTS {
            return Ok(());
        }
        let pixels = self.frame.width / (self.x.high - self.x.low);
        for (place, size) in plot.positions.chunks_exact(2).zip(plot.sizes) {
            let radius = (0.12 * size * pixels).min(2.0);
            if radius > 0.6 && place.iter().all(|own| own.is_finite()) {
                canvas.disc(self.place([place[0], place[1]]), radius, POINT)?;
            }
        }
        Ok(())
    }

    /// A place on the way along a side, from 0 to 1, as far within the frame as its signs stand: those of the fluid
    /// farther, so that both are seen.
    fn along(&self, side: &SideSign, share: f64) -> Place {
        let inset = match side.about {
            About::Fluid => 0.75 * self.size,
            _ => 0.25 * self.size,
        };
        let axis = [self.x, self.y][side.axis];
        let mut place = [if side.upper { axis.high } else { axis.low }; 2];
        place[1 - side.axis] = side.span[0] + share * (side.span[1] - side.span[0]);
        let (x, y) = self.place(place);
        match (side.axis, side.upper) {
            (0, false) => (x + inset, y),
            (0, true) => (x - inset, y),
            (_, false) => (x, y - inset),
            (_, true) => (x, y + inset),
        }
    }

    /// Draws the sign of a side.
    fn side<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, side: &SideSign) -> Drawn<()> {
        let colour = side.about.colour();
        let at = |share: f64| self.along(side, share);
        let (from, to) = (at(0.0), at(1.0));
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        match side.sign {
            Sign::Bar => canvas.rule(from, to, 0.4 * self.size, colour),
            Sign::Circles => {
                let count = (length / (1.8 * self.size)).floor().max(1.0);
                (0..count as usize).try_for_each(|k| {
                    let place = at((k as f64 + 0.5) / count);
                    canvas.disc(place, 0.34 * self.size, colour)?;
                    canvas.disc(place, 0.2 * self.size, WHITE)
                })
            }
            Sign::Arrows(direction) => {
                let count = (length / (4.0 * self.size)).floor().clamp(1.0, 12.0);
                let outwards = (direction[side.axis] > 0.0) == side.upper;
                (0..count as usize).try_for_each(|k| {
                    self.arrow(
                        canvas,
                        at((k as f64 + 0.5) / count),
                        (direction, outwards),
                        colour,
                    )
                })
            }
        }
    }

    /// An arrow that ends at a place, or begins there where it points out of the frame: it stays in the frame.
    fn arrow<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        at: Place,
        (direction, outwards): ([f64; 2], bool),
        colour: Colour,
    ) -> Drawn<()> {
        let length = direction[0].hypot(direction[1]);
        if !(length > 0.0 && length.is_finite()) {
            return Ok(());
        }
        let unit = (direction[0] / length, -direction[1] / length);
        let reach = 2.4 * self.size;
        let by = |from: Place, along: f64, across: f64| {
            (
                from.0 + along * unit.0 - across * unit.1,
                from.1 + along * unit.1 + across * unit.0,
            )
        };
        let tail = if outwards { by(at, -reach, 0.0) } else { at };
        let tip = by(tail, reach, 0.0);
        let head = 0.75 * self.size;
        canvas.polyline(&[tail, by(tip, -head, 0.0)], 0.22 * self.size, colour)?;
        canvas.polygon(
            &[
                tip,
                by(tip, -head, 0.45 * head),
                by(tip, -head, -0.45 * head),
            ],
            colour,
        )
    }

    fn mark<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, mark: &SetupMark) -> Drawn<()> {
        let (x, y) = self.place(mark.at);
        let (size, colour) = (self.size, mark.about.colour());
        canvas.disc((x, y), 0.5 * size, WHITE)?;
        canvas.disc((x, y), 0.42 * size, colour)?;
        canvas.disc((x, y), 0.18 * size, WHITE)?;
        let right = x < self.frame.left + 0.6 * self.frame.width;
        let (anchor, shift) = match right {
            true => (Anchor::Left, 0.8 * size),
            false => (Anchor::Right, -0.8 * size),
        };
        // Names stand above their marks, where cracks do not run through them, and within the frame.
        let y = y - 1.1 * size;
        let (top, bottom) = (
            self.frame.top + 1.8 * size,
            self.frame.bottom() - 1.8 * size,
        );
        let y = if top < bottom {
            y.clamp(top, bottom)
        } else {
            0.5 * (top + bottom)
        };
        let text = Text {
            colour,
            ..Text::new(size, anchor)
        };
        canvas.text(&mark.label, (x + shift, y), text)
    }
}

#[cfg(test)]
#[path = "setup_tests.rs"]
mod tests;
