//! The colour bar that tells which colour means which value.

use plotters_backend::DrawingBackend;

use super::axes::{Axis, Frame};
use super::canvas::{Anchor, BLACK, Canvas, Text};
use super::colours::ColourScale;
use super::{Drawn, Place};

/// A colour bar, upright beside the plot or lying below it.
pub(super) struct Bar<'a> {
    pub frame: Frame,
    /// Whether the bar lies below the plot.
    pub below: bool,
    pub colours: &'a ColourScale,
    /// The range of the colours in the unit shown.
    pub axis: Axis,
    /// Size of the numbers, px.
    pub size: f64,
    /// Unit shown, empty for none.
    pub unit: &'a str,
    /// Place of the unit: of its middle below the plot, else of its left end.
    pub unit_at: Place,
}

impl Bar<'_> {
    /// Draws colours, marks, numbers and unit.
    pub(super) fn draw<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let line = (self.size / 14.0).round().max(1.0);
        self.ramp(canvas)?;
        self.frame.outline(canvas, line)?;
        self.marks(canvas, line)?;
        let text = Text::new(self.size, self.anchor());
        canvas.text(self.unit, self.unit_at, text)
    }

    fn anchor(&self) -> Anchor {
        if self.below {
            Anchor::Middle
        } else {
            Anchor::Left
        }
    }

    fn ramp<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let (bar, range) = (self.frame, self.colours.axis);
        let length = if self.below { bar.width } else { bar.height };
        let steps = length as usize;
        for step in 0..steps {
            let value = range.value((step as f64 + 0.5) / steps as f64);
            // Each step reaches into the next one, which covers it: enlarged drawings would show
            // the background between steps that only touch.
            let (at, end) = (step as f64, (step as f64 + 2.0).min(length));
            let (from, to) = if self.below {
                ((bar.left + at, bar.top), (bar.left + end, bar.bottom()))
            } else {
                (
                    (bar.left, bar.bottom() - end),
                    (bar.right(), bar.bottom() - at),
                )
            };
            canvas.rectangle(from, to, self.colours.colour(value))?;
        }
        Ok(())
    }

    /// The place beside the bar at a value, `by` pixels away from it: below or to the right.
    fn beside(&self, at: f64, by: f64) -> Place {
        let fraction = self.axis.fraction(at);
        if self.below {
            let (x, y) = self.frame.place((fraction, 0.0));
            return (x, y + by);
        }
        let (x, y) = self.frame.place((1.0, fraction));
        (x + by, y)
    }

    fn marks<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, line: f64) -> Drawn<()> {
        let (size, axis) = (self.size, self.axis);
        for at in axis.minor_ticks() {
            let to = self.beside(at, 0.2 * size);
            canvas.rule(self.beside(at, 0.0), to, line, BLACK)?;
        }
        let (ticks, gap) = if self.below {
            (axis.ticks_across(self.frame.width, size)?, 1.15)
        } else {
            (axis.ticks_up(self.frame.height, size), 0.65)
        };
        let text = Text::new(size, self.anchor());
        for tick in ticks {
            let to = self.beside(tick.at, 0.35 * size);
            canvas.rule(self.beside(tick.at, 0.0), to, line, BLACK)?;
            canvas.text(&tick.label, self.beside(tick.at, gap * size), text)?;
        }
        Ok(())
    }
}
