//! Fixed-radius search: points sorted into cells by counting.

use super::Vector;

/// Points binned into a regular grid of cells.
pub(crate) struct CellList<const D: usize> {
    origin: Vector<D>,
    inverse_edge: f64,
    cells: [usize; D],
    start: Vec<u32>,
    order: Vec<u32>,
    position: Vec<Vector<D>>,
}

impl<const D: usize> CellList<D> {
    /// Bins `positions` into cells of about the given edge (metres), never more than four cells a
    /// point.
    pub(crate) fn new(positions: &[Vector<D>], edge: f64) -> Self {
        let mut low = Vector::<D>::repeat(f64::INFINITY);
        let mut high = Vector::<D>::repeat(f64::NEG_INFINITY);
        for x in positions {
            low = low.inf(x);
            high = high.sup(x);
        }
        let mut edge = edge.max(f64::MIN_POSITIVE);
        let count =
            |edge: f64| -> Vector<D> { (high - low).map(|length| (length / edge).floor() + 1.0) };
        while count(edge).product() > 4.0 * positions.len() as f64 + 64.0 {
            edge *= 1.25;
        }
        let cells: [usize; D] = std::array::from_fn(|axis| count(edge)[axis] as usize);
        let mut list = CellList {
            origin: low,
            inverse_edge: 1.0 / edge,
            cells,
            start: Vec::new(),
            order: Vec::new(),
            position: Vec::new(),
        };
        list.sort(positions);
        list
    }

    fn sort(&mut self, positions: &[Vector<D>]) {
        let total: usize = self.cells.iter().product();
        let cell: Vec<usize> = positions.iter().map(|x| self.cell(x)).collect();
        let mut start = vec![0_u32; total + 1];
        for &c in &cell {
            start[c + 1] += 1;
        }
        for c in 0..total {
            start[c + 1] += start[c];
        }
        let mut cursor = start.clone();
        let mut order = vec![0_u32; positions.len()];
        for (index, &c) in cell.iter().enumerate() {
            order[cursor[c] as usize] = index as u32;
            cursor[c] += 1;
        }
        self.position = order
            .iter()
            .map(|&index| positions[index as usize])
            .collect();
        self.start = start;
        self.order = order;
    }

    fn along(&self, axis: usize, x: f64) -> usize {
        let place = ((x - self.origin[axis]) * self.inverse_edge).floor();
        (place.max(0.0) as usize).min(self.cells[axis] - 1)
    }

    fn cell(&self, x: &Vector<D>) -> usize {
        (0..D).rev().fold(0, |cell, axis| {
            cell * self.cells[axis] + self.along(axis, x[axis])
        })
    }

    /// Calls `visit(index, squared distance)` for every point within `radius` of `x`.
    pub(crate) fn within(&self, x: &Vector<D>, radius: f64, mut visit: impl FnMut(u32, f64)) {
        let low: [usize; D] = std::array::from_fn(|axis| self.along(axis, x[axis] - radius));
        let high: [usize; D] = std::array::from_fn(|axis| self.along(axis, x[axis] + radius));
        let limit = radius * radius;
        let mut at = low;
        loop {
            let row = (1..D)
                .rev()
                .fold(0, |cell, axis| (cell + at[axis]) * self.cells[axis - 1]);
            let (first, last) = (row + low[0], row + high[0]);
            for k in self.start[first] as usize..self.start[last + 1] as usize {
                let squared = (self.position[k] - x).norm_squared();
                if squared <= limit {
                    visit(self.order[k], squared);
                }
            }
            let Some(axis) = (1..D).find(|&axis| at[axis] < high[axis]) else {
                return;
            };
            at[axis] += 1;
            at[1..axis].copy_from_slice(&low[1..axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute<const D: usize>(points: &[Vector<D>], x: &Vector<D>, radius: f64) -> Vec<u32> {
        let near = |p: &Vector<D>| (p - x).norm_squared() <= radius * radius;
        (0..points.len() as u32)
            .filter(|&i| near(&points[i as usize]))
            .collect()
    }

    proptest! {
        #[test]
        fn finds_what_an_all_pairs_search_finds(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..80),
            edge in 0.01..1.0_f64, radius in 0.0..1.5_f64,
        ) {
            let points: Vec<Vector<3>> = points.into_iter().map(Vector::from).collect();
            let list = CellList::new(&points, edge);
            for x in &points {
                let mut found = Vec::new();
                list.within(x, radius, |index, _| found.push(index));
                found.sort_unstable();
                prop_assert_eq!(found, brute(&points, x, radius));
            }
        }
    }
}
