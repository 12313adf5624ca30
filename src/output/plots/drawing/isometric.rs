//! Pictures of space, seen from a corner.

use std::path::Path;

use plotters_backend::DrawingBackend;
use plotters_bitmap::BitMapBackend;

use super::axes::Axis;
use super::canvas::{Anchor, BLACK, Canvas, DIM, GRID, Text};
use super::colours::ColourScale;
use super::field::WIDTHS;
use super::layout::{Content, Layout};
use super::page::Page;
use super::raster::{Picture, write_png};
use super::units::{engineering, short_number};
use super::{Drawn, IsometricPlot, Place};
use crate::output::OutputError;

/// Cosine and sine of 30°, under which the level axes run.
const SLANT: (f64, f64) = (0.866_025_403_784_438_6, 0.5);

/// Room around the box for the names of its edges, in parts of its width.
const ROOM: f64 = 0.08;

/// Draws sections and broken places as a PNG picture, written atomically.
///
/// # Errors
/// [`OutputError::Drawing`] if the picture fails, else those of [`write_atomically`](crate::output::write_atomically).
pub fn isometric_png(path: impl AsRef<Path>, plot: &IsometricPlot<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    write_png(path, draw(plot))
}

/// To the right and upwards, m.
fn flat([x, y, z]: [f64; 3]) -> [f64; 2] {
    [(y - x) * SLANT.0, z - (x + y) * SLANT.1]
}

/// How near a place is; larger is nearer.
fn nearness([x, y, z]: [f64; 3]) -> f64 {
    x + y + z
}

/// Corner of a box: bit `k` of the number tells low or high along axis `k`.
fn corner([low, high]: [[f64; 3]; 2], number: usize) -> [f64; 3] {
    std::array::from_fn(|k| {
        if number >> k & 1 == 1 {
            high[k]
        } else {
            low[k]
        }
    })
}

/// Whether a place lies in the box, of which rounding is no part.
fn within([low, high]: [[f64; 3]; 2], at: [f64; 3]) -> bool {
    let slack = |k: usize| 1e-9 * (high[k] - low[k]);
    (0..3).all(|k| (low[k] - slack(k)..=high[k] + slack(k)).contains(&at[k]))
}

/// What is painted, from back to front.
enum Piece {
    Polygon(Vec<[f64; 2]>),
    Disc([f64; 2]),
}

fn values<'a>(plot: &'a IsometricPlot<'_>) -> impl Iterator<Item = f64> + 'a {
    let tiles = plot.tiles.iter().map(|tile| tile.value);
    tiles.chain(plot.places.iter().map(|place| place[3]))
}

/// What a reader must know besides the colours.
fn notes(plot: &IsometricPlot<'_>, colours: &ColourScale) -> Vec<String> {
    let mut notes = match values(plot).next() {
        Some(_) => colours.remarks(values(plot)),
        None => Vec::new(),
    };
    notes.extend(plot.notes.iter().cloned());
    notes
}

fn draw(plot: &IsometricPlot<'_>) -> Drawn<Picture> {
    let values = || values(plot);
    let range = plot.range.map(|[low, high]| (low, high));
    let colours = ColourScale::over(values(), range, false);
    let largest = colours.axis.high.abs().max(colours.axis.low.abs());
    let shown = engineering(plot.unit, largest);
    let time = plot.time.map_or(String::new(), |time| {
        format!("t = {}", super::units::readable_time(time))
    });
    let notes = notes(plot, &colours);
    let (x, y) = window(plot.bounds);
    let content = Content {
        width: f64::from(plot.width_px.clamp(WIDTHS.0, WIDTHS.1)),
        title: plot.title,
        time: &time,
        unit: &shown.unit,
        notes: &notes,
        x,
        y,
        bar: colours.axis.divided(shown.divisor),
    };
    let layout = Layout::fit(&content)?;
    let mut picture = Picture::white(content.width as usize, layout.height as usize);
    let size = (picture.width as u32, picture.height as u32);
    let mut canvas = Canvas::bitmap(BitMapBackend::with_buffer(&mut picture.pixels, size));
    let place = |[px, py]: [f64; 2]| layout.frame.place((x.fraction(px), y.fraction(py)));
    let page = Page {
        content: &content,
        layout: &layout,
        metres: &shown,
        axes: ["", ""],
    };
    page.texts(&mut canvas)?;
    if values().next().is_some() {
        page.bar(&colours).draw(&mut canvas)?;
    }
    edges(&mut canvas, plot.bounds, place)?;
    let pixels = layout.frame.width / (x.high - x.low);
    paint(&mut canvas, plot, &colours, (place, pixels))?;
    lines(&mut canvas, plot, place)?;
    names(&mut canvas, plot.bounds, (place, layout.size))?;
    canvas.finish()?;
    Ok(picture)
}

/// Ranges that hold the box with the names of its edges.
fn window(bounds: [[f64; 3]; 2]) -> (Axis, Axis) {
    let corners = || (0..8).map(|number| flat(corner(bounds, number)));
    let [x, y] = [0, 1].map(|k| Axis::covering(corners().map(|at| at[k]), false).0);
    let room = ROOM * (x.high - x.low);
    let wider = |axis: Axis| Axis {
        low: axis.low - room,
        high: axis.high + room,
        ..axis
    };
    (wider(x), wider(y))
}

/// The edges of the box.
fn edges<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    bounds: [[f64; 3]; 2],
    place: impl Fn([f64; 2]) -> Place,
) -> Drawn<()> {
    for from in 0..8_usize {
        for axis in (0..3).filter(|axis| from >> axis & 1 == 0) {
            let ends = [from, from | 1 << axis].map(|number| place(flat(corner(bounds, number))));
            canvas.polyline(&ends, 1.5, GRID)?;
        }
    }
    Ok(())
}

/// Lines within the box.
fn lines<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    plot: &IsometricPlot<'_>,
    place: impl Fn([f64; 2]) -> Place,
) -> Drawn<()> {
    let all = plot.lines.iter().flat_map(|line| line.windows(2));
    for ends in all.filter(|ends| ends.iter().all(|at| within(plot.bounds, *at))) {
        let places: Vec<Place> = ends.iter().map(|at| place(flat(*at))).collect();
        canvas.polyline(&places, 2.0, BLACK)?;
    }
    Ok(())
}

/// Nearness, value and form of everything that has a place, the farthest first.
fn pieces(plot: &IsometricPlot<'_>) -> Vec<(f64, f64, Piece)> {
    let mut pieces: Vec<(f64, f64, Piece)> = Vec::new();
    for tile in plot.tiles {
        let half = 0.51 * tile.size;
        let across: [usize; 2] = match tile.normal {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        let corner = |signs: [f64; 2]| {
            let mut at = tile.at;
            (0..2).for_each(|k| at[across[k]] += signs[k] * half);
            flat(at)
        };
        let ring = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let polygon = Piece::Polygon(ring.map(corner).to_vec());
        pieces.push((nearness(tile.at), tile.value, polygon));
    }
    for [x, y, z, value] in plot.places {
        let at = [*x, *y, *z];
        pieces.push((nearness(at), *value, Piece::Disc(flat(at))));
    }
    pieces.retain(|(near, ..)| near.is_finite());
    pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
    pieces
}

/// Tiles and discs, the farthest first.
fn paint<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    plot: &IsometricPlot<'_>,
    colours: &ColourScale,
    (place, pixels): (impl Fn([f64; 2]) -> Place, f64),
) -> Drawn<()> {
    let pieces = pieces(plot);
    let radius = (0.5 * plot.size * pixels).max(1.5);
    for (_, value, piece) in &pieces {
        let colour = colours.colour(*value);
        match piece {
            Piece::Polygon(ring) => {
                let ring: Vec<Place> = ring.iter().map(|at| place(*at)).collect();
                canvas.polygon(&ring, colour)?;
            }
            Piece::Disc(at) => {
                canvas.disc(place(*at), radius + 0.7, DIM)?;
                canvas.disc(place(*at), radius, colour)?;
            }
        }
    }
    Ok(())
}

/// Names and ends of the three edges that are seen against white.
fn names<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    bounds: [[f64; 3]; 2],
    (place, size): (impl Fn([f64; 2]) -> Place, f64),
) -> Drawn<()> {
    let [low, high] = bounds;
    let farthest = low
        .iter()
        .chain(&high)
        .fold(0.0, |most: f64, end| most.max(end.abs()));
    let metres = engineering("m", farthest);
    let middle = |k: usize| 0.5 * (low[k] + high[k]);
    for (axis, at, anchor) in [
        (0, [middle(0), high[1], low[2]], Anchor::Left),
        (1, [high[0], middle(1), low[2]], Anchor::Right),
        (2, [high[0], low[1], middle(2)], Anchor::Right),
    ] {
        let ends = [low[axis], high[axis]].map(|end| short_number(end / metres.divisor));
        let name = format!(
            "{} = {} … {} {}",
            ["x", "y", "z"][axis],
            ends[0],
            ends[1],
            metres.unit
        );
        let (x, y) = place(flat(at));
        let shift = match (axis, anchor) {
            (2, _) => (-size, 0.0),
            (_, Anchor::Left) => (0.6 * size, size),
            _ => (-0.6 * size, size),
        };
        let text = match axis {
            2 => Text {
                upwards: true,
                ..Text::new(size, Anchor::Middle)
            },
            _ => Text::new(size, anchor),
        };
        canvas.text(&name, (x + shift.0, y + shift.1), text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    const BOX: [[f64; 3]; 2] = [[0.0; 3], [1.0, 1.0, 1.0]];

    fn tile(at: [f64; 3], value: f64) -> crate::output::Tile {
        crate::output::Tile {
            at,
            normal: 2,
            size: 0.5,
            value,
        }
    }

    fn drawn(tiles: &[crate::output::Tile], places: &[[f64; 4]]) -> Picture {
        draw(&IsometricPlot {
            title: "a box",
            unit: "1",
            bounds: BOX,
            tiles,
            places,
            size: 0.1,
            lines: &[],
            time: None,
            range: Some([0.0, 1.0]),
            notes: &[],
            width_px: 600,
        })
        .unwrap()
    }

    fn count(picture: &Picture, colour: super::super::canvas::Colour) -> usize {
        picture
            .pixels
            .chunks(3)
            .filter(|own| *own == colour)
            .count()
    }

    /// By hand: unit steps along the axes go as far in the picture, under 120°.
    #[test]
    fn all_axes_are_shortened_alike() {
        let length = |at: [f64; 3]| {
            let [x, y] = flat(at);
            x.hypot(y)
        };
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            assert!((length(axis) - 1.0).abs() < 1e-12);
        }
        let [right, up] = flat([1.0, 1.0, 1.0]);
        assert!(
            right.abs() < 1e-12 && up.abs() < 1e-12,
            "the view is along the diagonal"
        );
    }

    #[test]
    fn what_is_nearer_hides_what_is_farther_in_any_order() {
        let yellow = ColourScale::new(&[], Some((0.0, 1.0)), false).colour(1.0);
        let bare = count(&drawn(&[], &[[0.5, 0.5, 0.5, 0.0]]), yellow);
        // Along the view, so that one lies right over the other.
        let (near, far) = (tile([0.7, 0.7, 0.7], 1.0), tile([0.4, 0.4, 0.4], 0.0));
        let front = count(&drawn(&[near, far], &[]), yellow);
        assert_eq!(front, count(&drawn(&[far, near], &[]), yellow));
        assert!(front > bare + 1000, "{front} {bare}");
        let (near, far) = (tile([0.7, 0.7, 0.7], 0.0), tile([0.4, 0.4, 0.4], 1.0));
        let hidden = count(&drawn(&[near, far], &[]), yellow);
        assert!(hidden < front / 10, "{hidden} {front}");
    }

    #[test]
    fn places_that_are_nowhere_are_left_out() {
        let picture = drawn(&[], &[[f64::NAN, 0.0, 0.0, 0.5]]);
        assert!(picture.height > 100);
    }
}
