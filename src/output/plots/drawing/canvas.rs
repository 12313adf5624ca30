//! Drawing in pixels with fractions, on any backend.

use plotters_backend::text_anchor::HPos;
use plotters_backend::{BackendColor, BackendStyle, DrawingBackend};

use super::font::BackendText;
use super::{Drawn, Place};

/// Red, green and blue, 0 to 255.
pub(super) type Colour = [u8; 3];

pub(super) const BLACK: Colour = [25, 25, 25];
pub(super) const DIM: Colour = [90, 90, 90];
pub(super) const GRID: Colour = [226, 226, 226];
pub(super) const WHITE: Colour = [255, 255, 255];

/// SVG viewers centre text on half the height of an `x`, 0.09 of the font size above the middle of
/// the capitals.
const SVG_TEXT_SHIFT: f64 = 0.09;

/// Backend units per pixel in SVG drawings: the backend knows whole numbers only, so that finer
/// units keep curves smooth.
pub(super) const SVG_UNITS: u32 = 20;

/// How a text is set.
#[derive(Clone, Copy)]
pub(super) struct Text {
    pub size: f64,
    pub bold: bool,
    /// Turned by 90° so that it reads upwards.
    pub upwards: bool,
    pub anchor: Anchor,
    pub colour: Colour,
}

impl Text {
    pub(super) fn new(size: f64, anchor: Anchor) -> Self {
        Self {
            size,
            bold: false,
            upwards: false,
            anchor,
            colour: BLACK,
        }
    }
}

/// Which end of the text its place refers to; vertically it is always the middle.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}

struct Pen {
    colour: BackendColor,
    width: u32,
}

impl BackendStyle for Pen {
    fn color(&self) -> BackendColor {
        self.colour
    }

    fn stroke_width(&self) -> u32 {
        self.width
    }
}

/// A backend together with its resolution.
pub(super) struct Canvas<B> {
    backend: B,
    units: f64,
    text_shift: f64,
}

impl<B: DrawingBackend> Canvas<B> {
    /// For backends whose unit is the pixel.
    pub(super) fn bitmap(backend: B) -> Self {
        Self {
            backend,
            units: 1.0,
            text_shift: 0.0,
        }
    }

    /// For the SVG backend, drawn in units of 1/[`SVG_UNITS`] pixel.
    pub(super) fn vector(backend: B) -> Self {
        Self {
            backend,
            units: f64::from(SVG_UNITS),
            text_shift: SVG_TEXT_SHIFT,
        }
    }

    fn unit(&self, value: f64) -> i32 {
        (value * self.units).round() as i32
    }

    fn place(&self, (x, y): Place) -> (i32, i32) {
        (self.unit(x), self.unit(y))
    }

    fn pen(&self, colour: Colour, width: f64) -> Pen {
        let [r, g, b] = colour;
        let width = (width * self.units).round().max(1.0) as u32;
        Pen {
            colour: BackendColor {
                alpha: 1.0,
                rgb: (r, g, b),
            },
            width,
        }
    }

    /// A filled rectangle between two corners, at least one unit in each direction.
    pub(super) fn rectangle(&mut self, from: Place, to: Place, colour: Colour) -> Drawn<()> {
        let (low, high) = (self.place(from), self.place(to));
        // The bitmap backend leaves out the far edges, as SVG does: the sizes are exact.
        let high = (high.0.max(low.0 + 1), high.1.max(low.1 + 1));
        let pen = self.pen(colour, 1.0);
        self.backend
            .draw_rect(low, high, &pen, true)
            .map_err(|e| e.to_string())
    }

    /// A sharp horizontal or vertical line of the given width, centred on its ends.
    pub(super) fn rule(&mut self, from: Place, to: Place, width: f64, colour: Colour) -> Drawn<()> {
        let half = width / 2.0;
        let low = (from.0.min(to.0) - half, from.1.min(to.1) - half);
        let high = (from.0.max(to.0) + half, from.1.max(to.1) + half);
        self.rectangle(low, high, colour)
    }

    /// Connected straight lines.
    pub(super) fn polyline(&mut self, places: &[Place], width: f64, colour: Colour) -> Drawn<()> {
        let pen = self.pen(colour, width);
        let places: Vec<_> = places.iter().map(|&place| self.place(place)).collect();
        self.backend
            .draw_path(places, &pen)
            .map_err(|e| e.to_string())
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, places: &[Place], colour: Colour) -> Drawn<()> {
        let pen = self.pen(colour, 1.0);
        let places: Vec<_> = places.iter().map(|&place| self.place(place)).collect();
        self.backend
            .fill_polygon(places, &pen)
            .map_err(|e| e.to_string())
    }

    /// A filled disc.
    pub(super) fn disc(&mut self, centre: Place, radius: f64, colour: Colour) -> Drawn<()> {
        let pen = self.pen(colour, 1.0);
        let radius = self.unit(radius).max(1) as u32;
        let centre = self.place(centre);
        self.backend
            .draw_circle(centre, radius, &pen, true)
            .map_err(|e| e.to_string())
    }

    /// One line of text, or nothing if it is empty; control characters, which XML forbids, become spaces.
    pub(super) fn text(&mut self, text: &str, (x, y): Place, how: Text) -> Drawn<()> {
        if text.is_empty() {
            return Ok(());
        }
        let [r, g, b] = how.colour;
        let style = BackendText {
            size: how.size * self.units,
            bold: how.bold,
            upwards: how.upwards,
            anchor: match how.anchor {
                Anchor::Left => HPos::Left,
                Anchor::Middle => HPos::Center,
                Anchor::Right => HPos::Right,
            },
            colour: BackendColor {
                alpha: 1.0,
                rgb: (r, g, b),
            },
        };
        let shift = self.text_shift * how.size;
        let place = if how.upwards {
            (x + shift, y)
        } else {
            (x, y + shift)
        };
        let place = self.place(place);
        let text = text.replace(char::is_control, " ");
        self.backend
            .draw_text(&text, &style, place)
            .map_err(|e| e.to_string())
    }

    /// Completes the picture.
    pub(super) fn finish(mut self) -> Drawn<()> {
        self.backend.present().map_err(|e| e.to_string())
    }
}
