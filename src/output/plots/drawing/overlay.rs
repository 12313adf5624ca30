//! Cells that are no squares, and lines over a field.

use plotters_backend::DrawingBackend;

use super::axes::Frame;
use super::canvas::{BLACK, Canvas, WHITE};
use super::clip::clipped;
use super::raster::{Cell, Window};
use super::{Drawn, Place};

/// Widths of a line and of the white rim that sets it off from dark colours, in hundredths of the frame.
const LINE: f64 = 0.35;
const RIM: f64 = 0.8;

/// Fills the outlines of cells (m), one for each; what has no finite corners is left out.
pub(super) fn draw_outlines<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    (outlines, cells): (&[Vec<[f64; 2]>], &[Cell]),
    frame: &Frame,
    window: &Window,
) -> Drawn<()> {
    let (x, y) = window.axes();
    for (outline, cell) in outlines.iter().zip(cells) {
        let place = |[px, py]: &[f64; 2]| frame.place((x.fraction(*px), y.fraction(*py)));
        let mut places: Vec<Place> = outline.iter().map(place).collect();
        let finite = |(x, y): &Place| x.is_finite() && y.is_finite();
        if !places.iter().all(finite) {
            continue;
        }
        canvas.polygon(&places, cell.colour)?;
        // Its border as well: between cells that only touch, rounding would leave pixels out.
        places.extend(places.first().copied());
        canvas.polyline(&places, 1.0, cell.colour)?;
    }
    Ok(())
}

/// Draws lines (m) into a frame that shows a window.
pub(super) fn draw_lines<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    lines: &[Vec<[f64; 2]>],
    frame: &Frame,
    window: &Window,
) -> Drawn<()> {
    let (x, y) = window.axes();
    let place = |[px, py]: [f64; 2]| frame.place((x.fraction(px), y.fraction(py)));
    let bounds = [[window.left, window.bottom], [window.right, window.top]];
    let hundredth = frame.width.max(frame.height) / 100.0;
    for (width, colour) in [(RIM, WHITE), (LINE, BLACK)] {
        for piece in lines.iter().flat_map(|line| clipped(line, bounds)) {
            let places: Vec<Place> = piece.into_iter().map(place).collect();
            canvas.polyline(&places, (width * hundredth).max(1.0), colour)?;
        }
    }
    Ok(())
}
