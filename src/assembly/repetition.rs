//! Points of a uniform lattice far from all sides have the same rows, each shifted to its place.

use super::Pattern;
use crate::geometry::Lattice;

/// Which points have the rows of which others.
#[derive(Debug, Clone)]
pub(crate) struct Repetition {
    /// First point with the row of every point, shape `(n,)`.
    first: Vec<u32>,
}

impl Repetition {
    /// Points of a lattice of `counts` points along the axes, the first axis fastest, where rows of points with
    /// `margin` points and more to both sides do not feel these. Along each axis all such points are alike.
    pub(crate) fn new<const D: usize>(counts: [usize; D], margin: [usize; D]) -> Self {
        Repetition {
            first: Lattice::alike(counts, margin),
        }
    }

    /// Whether rows that are the same are as long in a pattern over the points.
    pub(crate) fn fits(&self, pattern: &Pattern) -> bool {
        let length = |point: usize| pattern.row(point).len();
        let mut all = self.first.iter().enumerate();
        all.all(|(point, first)| length(point) == length(*first as usize))
    }

    /// Fills the rows that stand for others by `fill`, which is given those to fill, and copies them; row
    /// `i` of `values` starts at `offsets[i]`.
    pub(super) fn fill(
        &self,
        offsets: &[u32],
        values: &mut [f64],
        fill: impl Fn(&mut [f64], &(dyn Fn(usize) -> bool + Sync)),
    ) {
        fill(values, &|point| self.first[point] as usize == point);
        let row = |point: usize| offsets[point] as usize..offsets[point + 1] as usize;
        for (point, first) in self.first.iter().enumerate() {
            let first = *first as usize;
            if first != point {
                values.copy_within(row(first), row(point).start);
            }
        }
    }
}
