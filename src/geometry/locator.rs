//! Places that are no points, and the points nearest to them.

use super::cell_list::CellList;
use super::{Cloud, Vector};

/// A place and the points that give the values there.
#[derive(Debug, Clone, PartialEq)]
pub struct Place<const D: usize> {
    /// Position in metres.
    pub at: Vector<D>,
    /// All points as near as the nearest one, up to rounding, ascending.
    pub nearest: Vec<usize>,
}

impl<const D: usize> Place<D> {
    /// Looks at all points; many places are found faster by a [`Locator`].
    pub fn find(cloud: &Cloud<D>, at: Vector<D>) -> Self {
        Self::find_among(cloud, at, |_| true)
    }

    /// As [`Place::find`], among the points that are wanted.
    pub fn find_among(
        cloud: &Cloud<D>,
        at: Vector<D>,
        wanted: impl Fn(&usize) -> bool + Copy,
    ) -> Self {
        let distance = |point: usize| (cloud.position[point] - at).norm();
        let points = (0..cloud.len()).filter(wanted);
        let first = points.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let nearest = first.map_or_else(Vec::new, |first| {
            let limit = limit(cloud, &at, first);
            let near = |&i: &usize| wanted(&i) && distance(i) <= limit;
            (0..cloud.len()).filter(near).collect()
        });
        Place { at, nearest }
    }
}

/// Distance up to which points count as near as the nearest one.
fn limit<const D: usize>(cloud: &Cloud<D>, at: &Vector<D>, nearest: usize) -> f64 {
    (cloud.position[nearest] - at).norm() + 1e-6 * cloud.spacing(nearest)
}

/// Finds many places; pays for its preparation from a few places on.
pub struct Locator<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    cells: CellList<D>,
    /// First radius to look within, in metres.
    reach: f64,
}

impl<'a, const D: usize> Locator<'a, D> {
    /// Prepares the search.
    pub fn new(cloud: &'a Cloud<D>) -> Self {
        let mean = cloud.volume.iter().sum::<f64>() / cloud.len().max(1) as f64;
        let reach = super::edge(mean, D);
        let cells = CellList::new(&cloud.position, reach);
        Locator {
            cloud,
            cells,
            reach,
        }
    }

    /// As [`Place::find`].
    pub fn place(&self, at: Vector<D>) -> Place<D> {
        if self.cloud.is_empty() || !at.iter().all(|x| x.is_finite()) {
            return Place::find(self.cloud, at);
        }
        let limit = limit(self.cloud, &at, self.nearest(&at));
        let mut nearest = Vec::new();
        // The limit is one on distances; squares are compared with room for their rounding.
        self.cells.within(&at, limit * (1.0 + 1e-12), |index, _| {
            nearest.push(index as usize);
        });
        nearest.retain(|&i| (self.cloud.position[i] - at).norm() <= limit);
        nearest.sort_unstable();
        Place { at, nearest }
    }

    fn nearest(&self, at: &Vector<D>) -> usize {
        let mut radius = self.reach;
        loop {
            let mut nearest = (f64::INFINITY, u32::MAX);
            self.cells.within(at, radius, |index, squared| {
                let better = squared.total_cmp(&nearest.0).then(index.cmp(&nearest.1));
                if better.is_lt() {
                    nearest = (squared, index);
                }
            });
            if nearest.0.is_finite() {
                return nearest.1 as usize;
            }
            radius *= 2.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::{jitter, lattice};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_a_search_of_all_points_finds(
            place in prop::array::uniform2(-0.5..1.5_f64), amount in 0.0..0.4_f64, seed in 0..9_u64,
        ) {
            let mut cloud = lattice(Vector::<2>::zeros(), Vector::repeat(1.0), [9, 7]).unwrap();
            jitter(&mut cloud, amount, seed);
            let locator = Locator::new(&cloud);
            let corner = cloud.domain.upper / 2.0;
            for place in [Vector::from(place), cloud.position[11], corner] {
                prop_assert_eq!(locator.place(place), Place::find(&cloud, place));
            }
        }
    }
}
