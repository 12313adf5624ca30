//! Where the parts of a field picture go.

use super::Drawn;
use super::axes::{Axis, Frame, widest};
use super::font::{text_width, wrap};

/// What has to find a place.
pub(super) struct Content<'a> {
    pub width: f64,
    pub title: &'a str,
    pub time: &'a str,
    pub unit: &'a str,
    pub notes: &'a [String],
    /// Axes in the units shown.
    pub x: Axis,
    pub y: Axis,
    pub bar: Axis,
}

/// All places in pixels; `size` is the font size of the numbers.
#[derive(Debug)]
pub(super) struct Layout {
    pub size: f64,
    pub height: f64,
    pub title: Vec<String>,
    pub left: f64,
    pub heading: f64,
    pub frame: Frame,
    pub bar: Frame,
    pub bar_below: bool,
    pub notes: Vec<String>,
    pub notes_top: f64,
    /// Whether one metre is equally long in both directions.
    pub to_scale: bool,
}

/// Widths around the frame, px.
struct Sides {
    left: f64,
    right: f64,
}

impl Layout {
    /// Size of the title, px.
    pub(super) fn title_size(&self) -> f64 {
        1.3 * self.size
    }

    /// Finds places so that nothing is clipped and one metre is equally long in both directions,
    /// unless the domain is so slender that it would become a line.
    pub(super) fn fit(content: &Content<'_>) -> Drawn<Self> {
        let size = (content.width / 60.0).max(14.0);
        let aspect = (content.y.high - content.y.low) / (content.x.high - content.x.low);
        let labels = widest(&content.y.ticks(8), size)?;
        let left = size + 1.9 * size + labels + 0.65 * size;
        let numbers = 2.1 * size + widest(&content.bar.ticks(8), size)?;
        let beside = numbers.max(text_width(content.unit, size, false)?);
        let mut sides = Sides {
            left,
            right: 1.4 * size + beside + size,
        };
        let mut wide = content.width - sides.left - sides.right;
        let bar_below = wide * aspect < 9.0 * size;
        if bar_below {
            sides.right = 2.5 * size;
            wide = content.width - sides.left - sides.right;
        }
        let (width, height, to_scale) = frame_size(wide, 1.1 * content.width, aspect, 1.5 * size);
        let mut layout = Self::place(content, size, &sides, (width, height), bar_below)?;
        let mut notes = content.notes.to_vec();
        if !to_scale {
            notes.push("x and y are not to the same scale".to_owned());
        }
        layout.add_notes(&notes, content.width)?;
        layout.to_scale = to_scale;
        Ok(layout)
    }

    /// Places everything but the notes.
    fn place(
        content: &Content<'_>,
        size: f64,
        sides: &Sides,
        (width, height): (f64, f64),
        bar_below: bool,
    ) -> Drawn<Self> {
        let mut room = content.width - 2.0 * size;
        let title = wrap(content.title, 1.3 * size, true, room)?;
        for line in &title {
            room = room.min(content.width - 2.0 * size - text_width(line, 1.3 * size, true)?);
        }
        let shift = ((content.width - sides.left - width - sides.right) / 2.0).max(0.0);
        let mut top = size * (1.4 + 1.9 * title.len() as f64);
        let heading = top + 0.2 * size;
        if !content.time.is_empty() || (!content.unit.is_empty() && !bar_below) {
            top += 1.9 * size;
        }
        let (left, top) = ((shift + sides.left).round(), top.round());
        let frame = Frame {
            left,
            top,
            width,
            height,
        };
        let (bar, below) = bar_place(&frame, size, bar_below, !content.unit.is_empty());
        Ok(Self {
            size,
            height: (below + 0.3 * size).ceil(),
            title,
            left: size + shift.min(room).max(0.0),
            heading,
            frame,
            bar,
            bar_below,
            notes: Vec::new(),
            notes_top: below + 0.5 * size,
            to_scale: true,
        })
    }

    fn add_notes(&mut self, notes: &[String], width: f64) -> Drawn<()> {
        for note in notes {
            self.notes
                .extend(wrap(note, self.size, false, width - 2.0 * self.size)?);
        }
        self.height = (self.height + 1.5 * self.size * self.notes.len() as f64).ceil();
        Ok(())
    }
}

/// Place of the colour bar, and where everything down to its labels ends.
fn bar_place(frame: &Frame, size: f64, bar_below: bool, has_unit: bool) -> (Frame, f64) {
    let below = frame.bottom() + 4.0 * size;
    if bar_below {
        let (top, height) = (below.round(), (1.2 * size).round());
        let bar = Frame {
            top,
            height,
            ..*frame
        };
        return (bar, bar.bottom() + if has_unit { 3.9 } else { 2.3 } * size);
    }
    let (left, width) = ((frame.right() + 1.4 * size).round(), (1.3 * size).round());
    (
        Frame {
            left,
            width,
            ..*frame
        },
        below,
    )
}

/// Largest frame of the given aspect (height over width) within the limits; no side gets shorter
/// than `least`, and then the aspect is given up.
pub(super) fn frame_size(wide: f64, high: f64, aspect: f64, least: f64) -> (f64, f64, bool) {
    let width = wide.min(high / aspect).max(least);
    let height = (width * aspect).min(high).max(least);
    let to_scale = (height / (width * aspect) - 1.0).abs() < 0.02;
    (width.round(), height.round(), to_scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(x: f64, y: f64) -> Layout {
        let axis = |high| Axis {
            low: 0.0,
            high,
            logarithmic: false,
        };
        let content = Content {
            width: 900.0,
            title: "a rather long title ".repeat(8).leak(),
            time: "t = 1 s",
            unit: "×10⁻¹² m²",
            notes: &["something to tell".to_owned()],
            x: axis(x),
            y: axis(y),
            bar: axis(1.0),
        };
        Layout::fit(&content).unwrap()
    }

    #[test]
    fn every_part_stays_on_the_picture_for_all_shapes_of_domains() {
        for (x, y) in [
            (1.0, 1.0),
            (10.0, 1.0),
            (300.0, 1.0),
            (1.0, 10.0),
            (1.0, 500.0),
        ] {
            let layout = layout(x, y);
            let Layout { frame, bar, .. } = &layout;
            assert!(
                frame.left > 60.0 && frame.right() < 900.0,
                "{x} × {y}: {layout:?}"
            );
            assert!(bar.right() < 890.0 && bar.bottom() < layout.height);
            assert!(frame.top > layout.title.len() as f64 * 20.0 + 20.0);
            assert!(frame.bottom() < layout.notes_top && layout.notes_top < layout.height);
            assert!(frame.width >= 20.0 && frame.height >= 20.0);
        }
    }

    #[test]
    fn one_metre_is_equally_long_in_both_directions() {
        for (x, y) in [(1.0, 1.0), (10.0, 1.0), (1.0, 10.0)] {
            let layout = layout(x, y);
            let ratio = (layout.frame.width / x) / (layout.frame.height / y);
            assert!(
                layout.to_scale && (ratio - 1.0).abs() < 0.02,
                "{x} × {y}: {ratio}"
            );
        }
        assert!(!layout(1.0, 500.0).to_scale);
    }
}
