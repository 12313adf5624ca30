//! Which part of a domain lies near some points: coarse, fast, never too small.

use super::Vector;

/// A set of cells of a regular grid that covers everything within a margin of some points.
pub(super) struct Near<const D: usize> {
    origin: Vector<D>,
    inverse_edge: f64,
    cells: [usize; D],
    marked: Vec<bool>,
}

/// Most cells of the grid per point.
const MOST: f64 = 4.0;

impl<const D: usize> Near<D> {
    /// Everything within `margin` metres of `points`, and some more.
    pub(super) fn new(points: &[Vector<D>], margin: f64) -> Self {
        let mut low = Vector::<D>::repeat(f64::INFINITY);
        let mut high = Vector::<D>::repeat(f64::NEG_INFINITY);
        for x in points {
            low = low.inf(x);
            high = high.sup(x);
        }
        if points.is_empty() {
            (low, high) = (Vector::zeros(), Vector::zeros());
        }
        // One more cell on each side holds what is near the outermost points.
        let mut edge = margin.max(f64::MIN_POSITIVE);
        let along = |axis: usize, edge: f64| ((high[axis] - low[axis]) / edge).floor() + 3.0;
        let count = |edge: f64| -> f64 { (0..D).map(|axis| along(axis, edge)).product() };
        while count(edge) > MOST * points.len() as f64 + 64.0 {
            edge *= 1.25;
        }
        let cells: [usize; D] = std::array::from_fn(|axis| along(axis, edge) as usize);
        let mut near = Near {
            origin: low.add_scalar(-edge),
            inverse_edge: 1.0 / edge,
            cells,
            marked: vec![false; cells.iter().product()],
        };
        for x in points {
            near.mark_around(x);
        }
        near
    }

    /// Whether a place may be within the margin of one of the points; where it is not, it is not.
    pub(super) fn holds(&self, x: &Vector<D>) -> bool {
        let mut cell = 0;
        for axis in (0..D).rev() {
            let place = (x[axis] - self.origin[axis]) * self.inverse_edge;
            if place.is_nan() || place < 0.0 || place >= self.cells[axis] as f64 {
                return false;
            }
            cell = cell * self.cells[axis] + place as usize;
        }
        self.marked[cell]
    }

    fn mark_around(&mut self, x: &Vector<D>) {
        let at: [usize; D] = std::array::from_fn(|axis| {
            let place = (x[axis] - self.origin[axis]) * self.inverse_edge;
            (place.max(0.0) as usize).min(self.cells[axis] - 1)
        });
        for neighbour in 0..3_usize.pow(D as u32) {
            let mut rest = neighbour;
            let mut cell = Some([0; D]);
            for axis in 0..D {
                let place = (at[axis] + rest % 3).checked_sub(1);
                rest /= 3;
                let inside = place.filter(|place| *place < self.cells[axis]);
                cell = cell.zip(inside).map(|(mut cell, place)| {
                    cell[axis] = place;
                    cell
                });
            }
            if let Some(cell) = cell {
                let index = (0..D)
                    .rev()
                    .fold(0, |index, axis| index * self.cells[axis] + cell[axis]);
                self.marked[index] = true;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nothing_within_the_margin_is_missed(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..40),
            steps in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..40),
            margin in 0.001..0.5_f64,
        ) {
            let points: Vec<Vector<3>> = points.into_iter().map(Vector::from).collect();
            let near = Near::new(&points, margin);
            for (x, step) in points.iter().cycle().zip(steps) {
                let step = Vector::from(step).normalize() * margin;
                prop_assert!(near.holds(&(x + step * 0.999_999)));
            }
        }
    }

    #[test]
    fn places_far_off_are_left_out() {
        let points = [Vector::<2>::zeros(), Vector::<2>::new(10.0, 0.0)];
        let near = Near::new(&points, 0.5);
        let far = [
            [5.0, 0.0],
            [0.0, 2.0],
            [-2.0, 0.0],
            [12.0, 0.0],
            [f64::NAN, 0.0],
        ];
        assert!(far.iter().all(|x| !near.holds(&Vector::from(*x))));
    }
}
