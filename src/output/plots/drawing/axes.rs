//! Axes: the range of values, the frame around the plot and its marks.

use plotters_backend::DrawingBackend;

use super::canvas::{Anchor, BLACK, Canvas, GRID, Text};
use super::font::text_width;
use super::ticks::{self, Tick};
use super::{Drawn, Place};

/// Relative spread below which values count as constant: less than rounding errors of a solver.
const CONSTANT: f64 = 1e-10;

/// A range of values, linear or logarithmic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    pub low: f64,
    pub high: f64,
    pub logarithmic: bool,
}

impl Axis {
    /// The range of all values the axis can show, and whether they all agree. A constant gets some
    /// room on both sides; without any value the range is 0 to 1, or 1 to 10 if logarithmic.
    pub(super) fn covering(values: impl Iterator<Item = f64>, logarithmic: bool) -> (Self, bool) {
        let shown = |value: &f64| value.is_finite() && (!logarithmic || *value > 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(shown) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = if logarithmic { (1.0, 10.0) } else { (0.0, 1.0) };
            return (
                Self {
                    low,
                    high,
                    logarithmic,
                },
                false,
            );
        }
        // Differences of huge numbers may overflow; such ranges are cut.
        let most = f64::MAX / 4.0;
        (low, high) = (low.clamp(-most, most), high.clamp(-most, most));
        let largest = high.abs().max(low.abs());
        let constant = high - low <= CONSTANT * largest;
        if constant {
            let room = if largest > 0.0 { 0.05 * largest } else { 1.0 };
            (low, high) = (low - room, high + room);
        }
        (
            Self {
                low,
                high,
                logarithmic,
            },
            constant,
        )
    }

    /// Whether the axis has a place for this value (which may still be beyond its ends).
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.logarithmic || value > 0.0)
    }

    /// 0 at the lower end, 1 at the upper.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The value at a fraction of the range.
    pub(super) fn value(&self, fraction: f64) -> f64 {
        if self.logarithmic {
            self.low * (self.high / self.low).powf(fraction)
        } else {
            self.low + fraction * (self.high - self.low)
        }
    }

    /// The same axis in other units.
    pub(super) fn divided(&self, divisor: f64) -> Self {
        Self {
            low: self.low / divisor,
            high: self.high / divisor,
            ..*self
        }
    }

    /// About `most` labelled marks, and at least those at the ends.
    pub(super) fn ticks(&self, most: usize) -> Vec<Tick> {
        let ticks = if self.logarithmic {
            ticks::logarithmic(self.low, self.high, most)
        } else {
            ticks::linear(self.low, self.high, most)
        };
        if ticks.len() < 2 {
            ticks::ends(self.low, self.high)
        } else {
            ticks
        }
    }

    /// The unlabelled marks between those of a logarithmic axis.
    pub(super) fn minor_ticks(&self) -> Vec<f64> {
        if self.logarithmic {
            ticks::logarithmic_minor(self.low, self.high)
        } else {
            Vec::new()
        }
    }

    /// As many labelled marks as fit side by side into `length` pixels.
    pub(super) fn ticks_across(&self, length: f64, size: f64) -> Drawn<Vec<Tick>> {
        let mut most = ((length / (4.0 * size)) as usize).clamp(1, 10);
        loop {
            let ticks = self.ticks(most);
            let needed = widest(&ticks, size)? + size;
            if most == 1 || needed * (ticks.len().max(2) - 1) as f64 <= length {
                return Ok(ticks);
            }
            most -= 1;
        }
    }

    /// As many labelled marks as fit above each other into `length` pixels.
    pub(super) fn ticks_up(&self, length: f64, size: f64) -> Vec<Tick> {
        self.ticks(((length / (2.2 * size)) as usize).clamp(1, 8))
    }
}

/// Width of the widest label in pixels.
pub(super) fn widest(ticks: &[Tick], size: f64) -> Drawn<f64> {
    let mut most: f64 = 0.0;
    for tick in ticks {
        most = most.max(text_width(&tick.label, size, false)?);
    }
    Ok(most)
}

/// A rectangle on the picture, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// The place of two fractions, counted from the lower left corner.
    pub(super) fn place(&self, (across, up): (f64, f64)) -> Place {
        (
            self.left + across * self.width,
            self.bottom() - up * self.height,
        )
    }

    /// Draws the outline.
    pub(super) fn outline<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        width: f64,
    ) -> Drawn<()> {
        let (left, right, top, bottom) = (self.left, self.right(), self.top, self.bottom());
        canvas.rule((left, top), (right, top), width, BLACK)?;
        canvas.rule((left, bottom), (right, bottom), width, BLACK)?;
        canvas.rule((left, top), (left, bottom), width, BLACK)?;
        canvas.rule((right, top), (right, bottom), width, BLACK)
    }
}

/// The two axes of a plot with the sizes of their marks.
pub(super) struct Axes<'a> {
    pub frame: Frame,
    /// Axes in the units shown.
    pub x: Axis,
    pub y: Axis,
    pub x_label: &'a str,
    pub y_label: &'a str,
    /// Size of the numbers, px; labels are a little larger.
    pub size: f64,
    /// Place of the middle of the vertical label, px from the left.
    pub y_label_at: f64,
    pub grid: bool,
}

impl Axes<'_> {
    /// Draws grid, marks, numbers and labels, but not the outline.
    pub(super) fn draw<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        self.draw_x(canvas)?;
        self.draw_y(canvas)?;
        let frame = self.frame;
        let text = Text::new(1.08 * self.size, Anchor::Middle);
        let middle = frame.left + frame.width / 2.0;
        canvas.text(
            self.x_label,
            (middle, frame.bottom() + 2.95 * self.size),
            text,
        )?;
        let place = (self.y_label_at, frame.top + frame.height / 2.0);
        canvas.text(
            self.y_label,
            place,
            Text {
                upwards: true,
                ..text
            },
        )
    }

    fn line(&self) -> f64 {
        (self.size / 14.0).round().max(1.0)
    }

    /// Draws marks and numbers below the frame.
    pub(super) fn draw_x<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let (frame, size, line) = (self.frame, self.size, self.line());
        for at in self.x.minor_ticks() {
            let (x, bottom) = frame.place((self.x.fraction(at), 0.0));
            canvas.rule((x, bottom), (x, bottom + 0.2 * size), line, BLACK)?;
        }
        for tick in self.x.ticks_across(frame.width, size)? {
            let (x, bottom) = frame.place((self.x.fraction(tick.at), 0.0));
            if self.grid {
                canvas.rule((x, frame.top), (x, bottom), line, GRID)?;
            }
            canvas.rule((x, bottom), (x, bottom + 0.4 * size), line, BLACK)?;
            let text = Text::new(size, Anchor::Middle);
            canvas.text(&tick.label, (x, bottom + 1.2 * size), text)?;
        }
        Ok(())
    }

    /// Draws marks and numbers to the left of the frame.
    pub(super) fn draw_y<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Drawn<()> {
        let (frame, size, line) = (self.frame, self.size, self.line());
        for at in self.y.minor_ticks() {
            let (left, y) = frame.place((0.0, self.y.fraction(at)));
            canvas.rule((left - 0.2 * size, y), (left, y), line, BLACK)?;
        }
        for tick in self.y.ticks_up(frame.height, size) {
            let (left, y) = frame.place((0.0, self.y.fraction(tick.at)));
            if self.grid {
                canvas.rule((left, y), (frame.right(), y), line, GRID)?;
            }
            canvas.rule((left - 0.4 * size, y), (left, y), line, BLACK)?;
            let text = Text::new(size, Anchor::Right);
            canvas.text(&tick.label, (left - 0.65 * size, y), text)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn the_range_leaves_out_what_the_axis_cannot_show() {
        let values = [f64::NAN, -2.0, 0.0, 3.0, f64::INFINITY, 0.5];
        let (linear, _) = Axis::covering(values.into_iter(), false);
        assert_eq!((linear.low, linear.high), (-2.0, 3.0));
        let (logarithmic, _) = Axis::covering(values.into_iter(), true);
        assert_eq!((logarithmic.low, logarithmic.high), (0.5, 3.0));
    }

    #[test]
    fn every_range_has_a_positive_finite_width() {
        for values in [
            vec![],
            vec![0.0],
            vec![-5.0],
            vec![f64::MAX, -f64::MAX],
            vec![f64::NAN],
        ] {
            for logarithmic in [false, true] {
                let (axis, _) = Axis::covering(values.iter().copied(), logarithmic);
                assert!(
                    axis.high > axis.low && (axis.high - axis.low).is_finite(),
                    "{values:?}"
                );
                assert!(!logarithmic || axis.low > 0.0);
            }
        }
    }

    #[test]
    fn fractions_and_values_are_inverse() {
        for logarithmic in [false, true] {
            let axis = Axis {
                low: 2.0,
                high: 2e5,
                logarithmic,
            };
            for fraction in [0.0, 0.3, 1.0] {
                assert!((axis.fraction(axis.value(fraction)) - fraction).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn labels_side_by_side_do_not_touch() {
        let axis = Axis {
            low: 1_000_000.0,
            high: 1_000_000.1,
            logarithmic: false,
        };
        for length in [150.0, 400.0, 900.0] {
            let ticks = axis.ticks_across(length, 15.0).unwrap();
            let total: f64 = ticks
                .iter()
                .map(|t| text_width(&t.label, 15.0, false).unwrap())
                .sum();
            assert!(total < 1.7 * length, "{length}: {total}");
        }
    }
}
