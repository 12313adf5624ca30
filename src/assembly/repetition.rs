//! Points of a uniform lattice far from all sides have the same rows, each shifted to its place.

use super::Pattern;

/// Which points have the rows of which others.
#[derive(Debug, Clone)]
pub struct Repetition {
    /// First point with the row of every point, shape `(n,)`.
    first: Vec<u32>,
}

impl Repetition {
    /// Points of a lattice of `counts` points along the axes, the first axis fastest, where rows of points with
    /// `margin` points and more to both sides do not feel these. Along each axis all such points are alike.
    pub fn new<const D: usize>(counts: [usize; D], margin: [usize; D]) -> Self {
        let first = |mut point: usize| {
            let (mut first, mut stride) = (0, 1);
            for axis in 0..D {
                let place = point % counts[axis];
                let inside = place >= margin[axis] && place + margin[axis] < counts[axis];
                first += stride * if inside { margin[axis] } else { place };
                point /= counts[axis];
                stride *= counts[axis];
            }
            first as u32
        };
        Repetition {
            first: (0..counts.iter().product()).map(first).collect(),
        }
    }

    /// Whether rows that are the same are as long in a pattern over the points.
    pub fn fits(&self, pattern: &Pattern) -> bool {
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
