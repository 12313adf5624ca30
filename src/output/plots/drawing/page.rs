//! The parts of a picture of the plane that do not depend on what it shows there.

use plotters_backend::DrawingBackend;

use super::Drawn;
use super::axes::{Axes, widest};
use super::bar::Bar;
use super::canvas::{Anchor, Canvas, DIM, Text};
use super::colours::ColourScale;
use super::layout::{Content, Layout};
use super::units::{Shown, axis_label};

/// Title, notes, colour bar and axes of one frame.
pub(super) struct Page<'a> {
    pub content: &'a Content<'a>,
    pub layout: &'a Layout,
    /// Unit of both axes.
    pub metres: &'a Shown,
    /// Names of the axes.
    pub axes: [&'a str; 2],
}

impl Page<'_> {
    /// Draws title, time and notes.
    pub(super) fn texts<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
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

    /// The colour bar at its place.
    pub(super) fn bar<'b>(&'b self, colours: &'b ColourScale) -> Bar<'b> {
        let Layout { bar, size, .. } = *self.layout;
        let unit_at = if self.layout.bar_below {
            (bar.left + bar.width / 2.0, bar.bottom() + 2.75 * size)
        } else {
            (bar.left, self.layout.heading)
        };
        Bar {
            frame: bar,
            below: self.layout.bar_below,
            colours,
            axis: self.content.bar,
            size,
            unit: self.content.unit,
            unit_at,
        }
    }

    /// Draws both axes in metres and the outline of the frame.
    pub(super) fn axes<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let Layout { size, frame, .. } = *self.layout;
        let (x_label, y_label) = (
            axis_label(self.axes[0], &self.metres.unit),
            axis_label(self.axes[1], &self.metres.unit),
        );
        let numbers = widest(&self.content.y.ticks_up(frame.height, size), size)?;
        let axes = Axes {
            frame,
            x: self.content.x,
            y: self.content.y,
            x_label: &x_label,
            y_label: &y_label,
            size,
            y_label_at: frame.left - 0.65 * size - numbers - 1.2 * size,
            grid: false,
        };
        axes.draw(canvas)?;
        frame.outline(canvas, (size / 14.0).round().max(1.0))
    }
}
