//! Marks of curves and the legend that explains them.

use plotters_backend::DrawingBackend;

use super::LineStyle;
use super::axes::Frame;
use super::canvas::{Anchor, Canvas, Colour, GRID, Text, WHITE};
use super::colours::PALETTE;
use super::decimate::dashes;
use super::font::text_width;
use super::{Drawn, Place};

/// Width of curves, px.
pub(super) const STROKE: f64 = 2.0;

/// Width of thin curves, px.
const THIN: f64 = 1.0;

/// Lengths of dash, gap, dash, gap …, px, in turn for dashed curves.
const PATTERNS: [&[f64]; 4] = [
    &[9.0, 5.0],
    &[2.5, 3.5],
    &[12.0, 4.0, 2.5, 4.0],
    &[18.0, 6.0],
];

/// Length of the piece of curve in the legend, px.
const SAMPLE: f64 = 38.0;

/// Corners of an upright cross, px.
#[rustfmt::skip]
const CROSS: [Place; 12] = [
    (-1.6, -5.4), (1.6, -5.4), (1.6, -1.6), (5.4, -1.6), (5.4, 1.6), (1.6, 1.6),
    (1.6, 5.4), (-1.6, 5.4), (-1.6, 1.6), (-5.4, 1.6), (-5.4, -1.6), (-1.6, -1.6),
];

/// The same cross, leaning, px.
#[rustfmt::skip]
const SALTIRE: [Place; 12] = [
    (0.0, -2.3), (2.7, -5.0), (5.0, -2.7), (2.3, 0.0), (5.0, 2.7), (2.7, 5.0),
    (0.0, 2.3), (-2.7, 5.0), (-5.0, 2.7), (-2.3, 0.0), (-5.0, -2.7), (-2.7, -5.0),
];

/// How one curve looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub index: usize,
    pub style: LineStyle,
    /// Whether a solid curve carries marks, to tell it from others without colour.
    pub marked: bool,
}

impl Look {
    pub(super) fn colour(&self) -> Colour {
        PALETTE[self.index % PALETTE.len()]
    }

    /// Number of the mark's form. Forms and colours are as many, and of curves of one colour each has its own form.
    pub(super) fn form(&self) -> usize {
        (self.index + self.index / PALETTE.len()) % PALETTE.len()
    }

    /// Draws the curve through the places, without marks.
    pub(super) fn stroke<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        places: &[Place],
    ) -> Drawn<()> {
        match self.style {
            LineStyle::Line => canvas.polyline(places, STROKE, self.colour()),
            LineStyle::Thin => canvas.polyline(places, THIN, self.colour()),
            LineStyle::Markers => Ok(()),
            LineStyle::Dashed => {
                for dash in dashes(places, PATTERNS[self.index % PATTERNS.len()]) {
                    canvas.polyline(&dash, STROKE, self.colour())?;
                }
                Ok(())
            }
        }
    }

    /// Draws the mark of this curve.
    pub(super) fn mark<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        (x, y): Place,
    ) -> Drawn<()> {
        let corners: &[Place] = match self.form() {
            0 => return canvas.disc((x, y), 4.2, self.colour()),
            1 => &[(-3.8, -3.8), (3.8, -3.8), (3.8, 3.8), (-3.8, 3.8)],
            2 => &[(0.0, -5.2), (4.9, 3.6), (-4.9, 3.6)],
            3 => &[(0.0, -5.6), (5.6, 0.0), (0.0, 5.6), (-5.6, 0.0)],
            4 => &[(0.0, 5.2), (4.9, -3.6), (-4.9, -3.6)],
            5 => &CROSS,
            _ => &SALTIRE,
        };
        let places: Vec<Place> = corners.iter().map(|c| (x + c.0, y + c.1)).collect();
        canvas.polygon(&places, self.colour())
    }
}

/// The legend with its size in pixels.
pub(super) struct Legend<'a> {
    entries: Vec<(&'a str, Look)>,
    size: f64,
    pub width: f64,
    pub height: f64,
}

impl<'a> Legend<'a> {
    /// Measures a legend of all entries with a label.
    pub(super) fn new(entries: Vec<(&'a str, Look)>, size: f64) -> Drawn<Self> {
        let entries: Vec<_> = entries
            .into_iter()
            .filter(|(label, _)| !label.is_empty())
            .collect();
        let mut text: f64 = 0.0;
        for (label, _) in &entries {
            text = text.max(text_width(label, size, false)?);
        }
        let height = (1.5 * entries.len() as f64 + 0.6) * size;
        Ok(Self {
            entries,
            size,
            width: SAMPLE + text + 2.2 * size,
            height,
        })
    }

    /// As [`Legend::new`], with a smaller font if that is needed to be no wider than `most`.
    pub(super) fn within(entries: Vec<(&'a str, Look)>, size: f64, most: f64) -> Drawn<Self> {
        let legend = Self::new(entries, size)?;
        match legend.width > most {
            true => Self::new(
                legend.entries,
                size * (most - SAMPLE) / (legend.width - SAMPLE),
            ),
            false => Ok(legend),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// A corner of the frame that none of the places (dense along the curves) touches.
    pub(super) fn free_corner(&self, frame: &Frame, places: &[Place]) -> Option<Place> {
        let gap = 0.7 * self.size;
        if self.width > 0.5 * frame.width || self.height > 0.6 * frame.height {
            return None;
        }
        let (left, top) = (frame.left + gap, frame.top + gap);
        let (right, bottom) = (
            frame.right() - gap - self.width,
            frame.bottom() - gap - self.height,
        );
        let free = |&(x, y): &Place| {
            let across = x - gap..=x + self.width + gap;
            let down = y - gap..=y + self.height + gap;
            !places
                .iter()
                .any(|place| across.contains(&place.0) && down.contains(&place.1))
        };
        [(right, top), (left, top), (right, bottom), (left, bottom)]
            .into_iter()
            .find(free)
    }

    /// Draws the legend with its upper left corner at the given place.
    pub(super) fn draw<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        (x, y): Place,
    ) -> Drawn<()> {
        let far = (x + self.width, y + self.height);
        canvas.rectangle((x - 1.0, y - 1.0), (far.0 + 1.0, far.1 + 1.0), GRID)?;
        canvas.rectangle((x, y), far, WHITE)?;
        for (row, (label, look)) in self.entries.iter().enumerate() {
            let middle = y + (1.5 * row as f64 + 1.05) * self.size;
            let (from, to) = (x + 0.7 * self.size, x + 0.7 * self.size + SAMPLE);
            look.stroke(canvas, &[(from, middle), (to, middle)])?;
            if look.marked || look.style == LineStyle::Markers {
                look.mark(canvas, (0.5 * (from + to), middle))?;
            }
            let text = Text::new(self.size, Anchor::Left);
            canvas.text(label, (to + 0.7 * self.size, middle), text)?;
        }
        Ok(())
    }
}
