//! Names of the six sides of a box.

use std::fmt;

/// A side of the domain: the plane where one coordinate takes its smallest or largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Side {
    /// Axis normal to the side: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Whether it is the side of the largest coordinate.
    pub upper: bool,
}

const NAMES: [&str; 6] = ["left", "right", "bottom", "top", "front", "back"];

impl Side {
    /// All sides of a `dimension`-dimensional box, in the order of [`Side::index`].
    pub fn all(dimension: usize) -> impl Iterator<Item = Side> {
        (0..2 * dimension).map(Side::from_index)
    }

    /// Side number: 2 × axis, plus one for the upper side.
    pub fn index(self) -> usize {
        2 * self.axis + usize::from(self.upper)
    }

    /// Inverse of [`Side::index`].
    pub fn from_index(index: usize) -> Side {
        Side {
            axis: index / 2,
            upper: index % 2 == 1,
        }
    }

    /// Name in scenes and reports, such as `left`.
    pub fn name(self) -> &'static str {
        NAMES[self.index()]
    }

    /// Component of the outward unit normal along the side's own axis: −1 or +1.
    pub fn outward(self) -> f64 {
        if self.upper { 1.0 } else { -1.0 }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
