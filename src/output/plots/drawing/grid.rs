//! Where the parts of a picture of several panels go.

use super::axes::{Axis, Frame, widest};
use super::font::{text_width, wrap};
use super::layout::frame_size;
use super::{Drawn, Place};

/// Greatest height of all panels together, as a part of the width of the picture.
const TALLEST: f64 = 0.75;

/// What has to find a place.
pub(super) struct Contents<'a> {
    pub width: f64,
    pub title: &'a str,
    /// Label of each panel.
    pub times: &'a [String],
    pub notes: &'a [String],
    /// Axes in the units shown.
    pub x: Axis,
    pub y: Axis,
    pub bar: Axis,
}

/// One panel, and whether it carries the numbers of its column and of its row.
#[derive(Debug)]
pub(super) struct Panel {
    pub frame: Frame,
    pub lowest: bool,
    pub leftmost: bool,
}

/// All places in pixels; `size` is the font size of the numbers.
#[derive(Debug)]
pub(super) struct Grid {
    pub size: f64,
    pub height: f64,
    pub title: Vec<String>,
    pub left: f64,
    pub panels: Vec<Panel>,
    pub bar: Frame,
    /// Middles of the labels of the axes.
    pub x_label: Place,
    pub y_label: Place,
    pub notes: Vec<String>,
    pub notes_top: f64,
}

/// Lengths around the panels, px.
struct Room {
    size: f64,
    left: f64,
    right: f64,
    /// Between panels side by side.
    gap: f64,
    /// Above each panel, for its label.
    head: f64,
    /// Least width of a column, for the label.
    column: f64,
    /// Least width of a panel, for its numbers.
    least: f64,
}

/// Panels in columns and rows, px.
struct Tiling {
    columns: usize,
    rows: usize,
    panel: (f64, f64),
    /// Width of a column.
    column: f64,
    to_scale: bool,
}

impl Grid {
    /// Size of the title, px.
    pub(super) fn title_size(&self) -> f64 {
        1.3 * self.size
    }

    /// Finds the arrangement with the largest panels in which nothing is clipped and one metre is
    /// equally long in both directions, unless the domain is so slender that it would become a line.
    pub(super) fn fit(contents: &Contents<'_>) -> Drawn<Self> {
        let room = Room::around(contents)?;
        let tiling = Tiling::largest(contents, &room);
        let mut notes = contents.notes.to_vec();
        if !tiling.to_scale {
            notes.push("x and y are not to the same scale".to_owned());
        }
        let mut grid = Self::place(contents, &room, &tiling)?;
        for note in &notes {
            let width = contents.width - grid.left - room.size;
            grid.notes.extend(wrap(note, room.size, false, width)?);
        }
        grid.height = (grid.height + 1.5 * room.size * grid.notes.len() as f64).ceil();
        Ok(grid)
    }

    /// Places everything but the notes.
    fn place(contents: &Contents<'_>, room: &Room, tiling: &Tiling) -> Drawn<Self> {
        let size = room.size;
        let across = tiling.columns as f64 * (tiling.column + room.gap) - room.gap;
        let spare = ((contents.width - room.left - room.right - across) / 2.0).max(0.0);
        let mut title_room = contents.width - 2.0 * size;
        let title = wrap(contents.title, 1.3 * size, true, title_room)?;
        for line in &title {
            let width = text_width(line, 1.3 * size, true)?;
            title_room = title_room.min(contents.width - 2.0 * size - width);
        }
        let origin = (spare + room.left, size * (1.4 + 1.9 * title.len() as f64));
        let panels = tiling.panels(origin, room, contents.times.len());
        let whole = hull(&panels);
        let numbers = room.left - 3.7 * size;
        let bar = Frame {
            left: (whole.right() + 1.4 * size).round(),
            width: (1.3 * size).round(),
            ..whole
        };
        let below = whole.bottom() + 4.0 * size;
        Ok(Self {
            size,
            height: (below + 0.3 * size).ceil(),
            title,
            left: size + spare.min(title_room).max(0.0),
            bar,
            x_label: (whole.left + 0.5 * whole.width, whole.bottom() + 2.95 * size),
            y_label: (
                whole.left - 1.85 * size - numbers,
                whole.top + 0.5 * whole.height,
            ),
            panels,
            notes: Vec::new(),
            notes_top: below + 0.5 * size,
        })
    }
}

impl Room {
    fn around(contents: &Contents<'_>) -> Drawn<Self> {
        let size = (contents.width / 75.0).max(12.0);
        let across = widest(&contents.x.ticks(4), size)?;
        let mut label: f64 = 0.0;
        for time in contents.times {
            label = label.max(text_width(time, size, false)?);
        }
        Ok(Self {
            size,
            left: 3.7 * size + widest(&contents.y.ticks(8), size)?,
            right: 4.5 * size + widest(&contents.bar.ticks(8), size)?,
            gap: (1.2 * size).max(across + size),
            head: 1.9 * size,
            column: label,
            least: across + 1.5 * size,
        })
    }
}

impl Tiling {
    /// The tiling that shows most of the field; tilings with empty places count less.
    fn largest(contents: &Contents<'_>, room: &Room) -> Self {
        let count = contents.times.len().max(1);
        let mut best = Self::with_columns(contents, room, 1);
        for columns in 2..=count {
            let next = Self::with_columns(contents, room, columns);
            let fits = next.columns as f64 * (next.column + room.gap) - room.gap
                <= contents.width - room.left - room.right + 0.5;
            let filled = |tiling: &Self| {
                let part = count as f64 / (tiling.rows * tiling.columns) as f64;
                part * tiling.panel.0 * tiling.panel.1
            };
            let better = filled(&next) > filled(&best) && (next.to_scale || !best.to_scale);
            if fits && (better || (next.to_scale && !best.to_scale)) {
                best = next;
            }
        }
        best
    }

    fn with_columns(contents: &Contents<'_>, room: &Room, columns: usize) -> Self {
        let rows = contents.times.len().max(1).div_ceil(columns);
        let wide = contents.width - room.left - room.right + room.gap;
        let wide = (wide / columns as f64 - room.gap).floor();
        let high = TALLEST * contents.width / rows as f64 - room.head;
        let aspect = (contents.y.high - contents.y.low) / (contents.x.high - contents.x.low);
        let shortest = 1.5 * room.size;
        let (width, height, to_scale) = frame_size(wide, high.max(shortest), aspect, shortest);
        // Numbers need more room across than along: a narrower panel is widened.
        let widened = width < room.least;
        let width = width.max(room.least.ceil());
        Self {
            columns,
            rows,
            panel: (width, height),
            column: width.max(room.column),
            to_scale: to_scale && !widened,
        }
    }

    fn panels(&self, (left, top): Place, room: &Room, count: usize) -> Vec<Panel> {
        let (width, height) = self.panel;
        let panel = |index: usize| {
            let (row, column) = (index / self.columns, index % self.columns);
            let middle = left + column as f64 * (self.column + room.gap) + 0.5 * self.column;
            let frame = Frame {
                left: (middle - 0.5 * width).round(),
                top: (top + room.head + row as f64 * (height + room.head)).round(),
                width,
                height,
            };
            Panel {
                frame,
                lowest: index + self.columns >= count,
                leftmost: column == 0,
            }
        };
        (0..count).map(panel).collect()
    }
}

/// The rectangle around all panels.
fn hull(panels: &[Panel]) -> Frame {
    let all = || panels.iter().map(|panel| panel.frame);
    let left = all().fold(f64::INFINITY, |least, frame| least.min(frame.left));
    let top = all().fold(f64::INFINITY, |least, frame| least.min(frame.top));
    Frame {
        left,
        top,
        width: all().fold(left, |most, frame| most.max(frame.right())) - left,
        height: all().fold(top, |most, frame| most.max(frame.bottom())) - top,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(count: usize, x: f64, y: f64, width: f64) -> Grid {
        let axis = |high| Axis {
            low: 0.0,
            high,
            logarithmic: false,
        };
        let contents = Contents {
            width,
            title: "a rather long title ".repeat(8).leak(),
            times: &vec!["t = 1234 min".to_owned(); count],
            notes: &["something to tell".to_owned()],
            x: axis(x),
            y: axis(y),
            bar: axis(1.0),
        };
        Grid::fit(&contents).unwrap()
    }

    fn apart(a: &Panel, b: &Panel, room: f64) -> bool {
        let (a, b) = (a.frame, b.frame);
        a.right() + room <= b.left || a.bottom() + room <= b.top
    }

    #[test]
    fn panels_stay_apart_and_on_the_picture_for_all_shapes_and_numbers() {
        for (x, y) in [
            (1.0, 1.0),
            (10.0, 1.0),
            (300.0, 1.0),
            (1.0, 8.0),
            (1.0, 500.0),
        ] {
            for count in 1..=12 {
                let grid = grid(count, x, y, 900.0);
                assert_eq!(grid.panels.len(), count);
                for (index, panel) in grid.panels.iter().enumerate() {
                    let Frame { left, top, .. } = panel.frame;
                    assert!(left > 45.0 && top > 40.0, "{count}, {x} × {y}: {grid:?}");
                    assert!(panel.frame.right() < grid.bar.left);
                    assert!(panel.frame.bottom() + 40.0 < grid.notes_top);
                    let mut later = grid.panels[index + 1..].iter();
                    assert!(later.all(|other| apart(panel, other, 10.0)));
                }
                assert!(grid.bar.right() < 880.0 && grid.notes_top < grid.height);
            }
        }
    }

    #[test]
    fn one_metre_is_equally_long_in_both_directions() {
        for (x, y) in [(1.0, 1.0), (10.0, 1.0), (1.0, 8.0)] {
            let frame = grid(6, x, y, 1200.0).panels[0].frame;
            let ratio = (frame.width / x) / (frame.height / y);
            assert!((ratio - 1.0).abs() < 0.03, "{x} × {y}: {ratio}");
        }
    }

    #[test]
    fn numbers_stand_at_the_left_of_rows_and_below_columns() {
        let grid = grid(5, 1.0, 1.0, 900.0);
        let lowest: Vec<bool> = grid.panels.iter().map(|panel| panel.lowest).collect();
        let leftmost: Vec<bool> = grid.panels.iter().map(|panel| panel.leftmost).collect();
        assert_eq!(lowest, [false, false, true, true, true]);
        assert_eq!(leftmost, [true, false, false, true, false]);
    }
}
