//! Pictures of coloured pixels, and point cells painted onto them.

use std::path::Path;

use super::axes::{Axis, Frame};
use super::canvas::Colour;
use super::{Drawn, PICTURE_KEY, PictureFacts};
use crate::output::{OutputError, write_atomically};

/// Cells are painted this much larger than they are, so that rounding leaves no gap between them.
const OVERLAP: f64 = 1.06;

/// Reach of a cell, in cell sizes, into gaps between cells that do not quite tile the plane.
const REACH: f64 = 1.6;

/// An RGB picture, row by row from the top.
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<u8>,
    /// What the file tells beside the pixels.
    pub facts: Option<PictureFacts>,
}

/// Writes a picture that was drawn as a PNG file, atomically.
///
/// # Errors
/// [`OutputError::Drawing`] if drawing failed, else those of [`write_atomically`].
pub(super) fn write_png(path: &Path, picture: Drawn<Picture>) -> Result<(), OutputError> {
    let bytes = picture.and_then(|picture| picture.encode());
    let bytes = bytes.map_err(|reason| OutputError::Drawing {
        path: path.to_path_buf(),
        reason,
    })?;
    write_atomically(path, |writer| writer.write_all(&bytes))
}

impl Picture {
    /// A white picture.
    pub(super) fn white(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            pixels: vec![255; 3 * width * height],
            facts: None,
        }
    }

    fn set(&mut self, x: usize, y: usize, colour: Colour) {
        if x < self.width && y < self.height {
            let start = 3 * (y * self.width + x);
            self.pixels[start..start + 3].copy_from_slice(&colour);
        }
    }

    /// The picture as a PNG file.
    pub(super) fn encode(&self) -> Drawn<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = self.encoder(&mut bytes);
        if let Some(facts) = &self.facts {
            let text = serde_json::to_string(facts).map_err(|e| e.to_string())?;
            encoder
                .add_itxt_chunk(PICTURE_KEY.to_owned(), text)
                .map_err(|e| e.to_string())?;
        }
        let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
        writer
            .write_image_data(&self.pixels)
            .map_err(|e| e.to_string())?;
        writer.finish().map_err(|e| e.to_string())?;
        Ok(bytes)
    }

    fn encoder<'a>(&self, bytes: &'a mut Vec<u8>) -> png::Encoder<'static, &'a mut Vec<u8>> {
        let mut encoder = png::Encoder::new(bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // Cells are of one colour: differences of pixels make files no smaller on the whole, and take time to find.
        encoder.set_filter(png::Filter::NoFilter);
        encoder
    }
}

/// Pictures of one size as an animated PNG file that runs without end, each shown for
/// `milliseconds`. They are drawn one after the other, so that only one is held at a time.
pub(super) fn encode_animation(
    mut pictures: impl ExactSizeIterator<Item = Drawn<Picture>>,
    milliseconds: u16,
) -> Drawn<Vec<u8>> {
    let count = u32::try_from(pictures.len()).map_err(|e| e.to_string())?;
    let first = pictures.next().ok_or("there are no frames")??;
    let mut bytes = Vec::new();
    let mut encoder = first.encoder(&mut bytes);
    encoder
        .set_animated(count, 0)
        .and_then(|()| encoder.set_frame_delay(milliseconds, 1000))
        .map_err(|e| e.to_string())?;
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    for picture in std::iter::once(Ok(first)).chain(pictures) {
        writer
            .write_image_data(&picture?.pixels)
            .map_err(|e| e.to_string())?;
    }
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// A square cell around a point, all lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    pub x: f64,
    pub y: f64,
    pub size: f64,
    pub colour: Colour,
}

/// The part of the plane a frame shows, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub left: f64,
    pub right: f64,
    pub bottom: f64,
    pub top: f64,
}

impl Window {
    /// The ranges of x and y, m.
    pub(super) fn axes(&self) -> (Axis, Axis) {
        let axis = |low, high| Axis {
            low,
            high,
            logarithmic: false,
        };
        (axis(self.left, self.right), axis(self.bottom, self.top))
    }
}

/// Which cell is nearest to each pixel of a frame, by the square of the distance in cell sizes.
struct Coverage {
    width: usize,
    height: usize,
    nearest: Vec<f64>,
    colours: Vec<Colour>,
}

impl Coverage {
    fn paint(
        &mut self,
        cell: &Cell,
        window: &Window,
        factor: f64,
        allowed: &dyn Fn(usize) -> bool,
    ) {
        let across = self.width as f64 / (window.right - window.left);
        let up = self.height as f64 / (window.top - window.bottom);
        let (x, y) = ((cell.x - window.left) * across, (window.top - cell.y) * up);
        let half = |scale: f64| (0.5 * cell.size * scale * factor).max(0.5 * OVERLAP);
        let (half_x, half_y) = (half(across), half(up));
        for row in pixels(y, half_y, self.height) {
            let off_y = (row as f64 + 0.5 - y) / half_y;
            for column in pixels(x, half_x, self.width) {
                let off_x = (column as f64 + 0.5 - x) / half_x;
                let distance = off_y * off_y + off_x * off_x;
                let index = row * self.width + column;
                if distance < self.nearest[index] && allowed(index) {
                    self.nearest[index] = distance;
                    self.colours[index] = cell.colour;
                }
            }
        }
    }

    /// Unpainted pixels between painted ones in their row, or between such or painted ones in their
    /// column.
    fn holes(&self) -> Vec<bool> {
        let painted: Vec<bool> = self
            .nearest
            .iter()
            .map(|distance| distance.is_finite())
            .collect();
        let mut filled = painted.clone();
        for row in 0..self.height {
            close(&mut filled, row * self.width, 1, self.width);
        }
        for column in 0..self.width {
            close(&mut filled, column, self.width, self.height);
        }
        filled
            .iter()
            .zip(painted)
            .map(|(&filled, painted)| filled && !painted)
            .collect()
    }
}

/// Fills everything between the first and the last filled entry of a line of pixels.
fn close(filled: &mut [bool], start: usize, stride: usize, count: usize) {
    let index = |i: usize| start + i * stride;
    let first = (0..count).find(|&i| filled[index(i)]);
    let last = (0..count).rfind(|&i| filled[index(i)]);
    if let (Some(first), Some(last)) = (first, last) {
        (first..last).for_each(|i| filled[index(i)] = true);
    }
}

/// Pixels whose centre lies within `half` of `centre`, in a row of `length` pixels.
fn pixels(centre: f64, half: f64, length: usize) -> std::ops::Range<usize> {
    let first = (centre - half - 0.5).ceil().clamp(0.0, length as f64) as usize;
    let last = (centre + half - 0.5)
        .floor()
        .clamp(-1.0, length as f64 - 1.0);
    first..(last + 1.0) as usize
}

/// Paints cells into a frame with whole-numbered corners. Where cells overlap, the nearest wins;
/// gaps between them are filled.
pub(super) fn paint_cells(picture: &mut Picture, frame: &Frame, window: &Window, cells: &[Cell]) {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut coverage = Coverage {
        width,
        height,
        nearest: vec![f64::INFINITY; width * height],
        colours: vec![[255; 3]; width * height],
    };
    cells
        .iter()
        .for_each(|cell| coverage.paint(cell, window, OVERLAP, &|_| true));
    let holes = coverage.holes();
    if holes.contains(&true) {
        let inside = |index: usize| holes[index];
        cells
            .iter()
            .for_each(|cell| coverage.paint(cell, window, REACH, &inside));
    }
    for (index, &colour) in coverage.colours.iter().enumerate() {
        let (x, y) = (
            frame.left as usize + index % width,
            frame.top as usize + index / width,
        );
        picture.set(x, y, colour);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    const RED: Colour = [200, 0, 0];
    const WHITE: Colour = [255; 3];

    fn painted(cells: &[Cell], pixels: usize) -> Picture {
        let mut picture = Picture::white(pixels, pixels);
        let side = pixels as f64;
        let frame = Frame {
            left: 0.0,
            top: 0.0,
            width: side,
            height: side,
        };
        let window = Window {
            left: 0.0,
            right: 1.0,
            bottom: 0.0,
            top: 1.0,
        };
        paint_cells(&mut picture, &frame, &window, cells);
        picture
    }

    fn at(picture: &Picture, x: usize, y: usize) -> Colour {
        let start = 3 * (y * picture.width + x);
        picture.pixels[start..start + 3].try_into().unwrap()
    }

    fn lattice(count: usize, size: f64) -> Vec<Cell> {
        let centre = |i: usize| (i as f64 + 0.5) / count as f64;
        let cell = |i: usize| Cell {
            x: centre(i % count),
            y: centre(i / count),
            size,
            colour: RED,
        };
        (0..count * count).map(cell).collect()
    }

    #[test]
    fn a_lattice_leaves_no_white_pixel_at_any_ratio_of_cells_to_pixels() {
        for count in [1, 3, 7, 30, 97, 200] {
            let picture = painted(&lattice(count, 1.0 / count as f64), 100);
            assert!(
                picture.pixels.chunks(3).all(|p| p == RED),
                "{count} cells across"
            );
        }
    }

    #[test]
    fn gaps_between_too_small_cells_are_closed_but_the_outside_stays_white() {
        let picture = painted(&lattice(4, 0.8 / 4.0), 100);
        assert_eq!(at(&picture, 25, 12), RED);
        assert_eq!(at(&picture, 25, 25), RED, "where four cells meet");
        assert_eq!(at(&picture, 0, 50), WHITE);
    }

    #[test]
    fn a_large_hole_stays_open() {
        let mut cells = lattice(10, 0.1);
        cells.retain(|cell| (cell.x - 0.5).hypot(cell.y - 0.5) > 0.25);
        assert_eq!(at(&painted(&cells, 100), 50, 50), WHITE);
    }

    #[test]
    fn of_overlapping_cells_the_nearest_wins_in_any_order() {
        let blue = [0, 0, 200];
        let mut cells = [
            Cell {
                x: 0.3,
                y: 0.5,
                size: 0.8,
                colour: RED,
            },
            Cell {
                x: 0.7,
                y: 0.5,
                size: 0.8,
                colour: blue,
            },
        ];
        let forward = painted(&cells, 50);
        cells.reverse();
        assert!(forward.pixels == painted(&cells, 50).pixels);
        assert_eq!((at(&forward, 15, 25), at(&forward, 35, 25)), (RED, blue));
    }

    #[test]
    fn a_cell_smaller_than_a_pixel_is_still_seen() {
        let tiny = Cell {
            x: 0.5,
            y: 0.5,
            size: 1e-9,
            colour: RED,
        };
        let picture = painted(&[tiny], 11);
        assert_eq!(at(&picture, 5, 5), RED);
    }
}
