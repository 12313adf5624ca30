//! Nearest points of many places.

use super::cell_list::CellList;
use super::{Cloud, Vector};

/// Finds the points nearest to places; pays for its preparation from a few places on.
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

    /// As [`Cloud::all_nearest`], in ascending order.
    pub fn all_nearest(&self, target: &Vector<D>) -> Vec<usize> {
        if self.cloud.is_empty() || !target.iter().all(|x| x.is_finite()) {
            return self.cloud.all_nearest(target);
        }
        let mut radius = self.reach;
        let nearest = loop {
            let mut nearest = (f64::INFINITY, u32::MAX);
            self.cells.within(target, radius, |index, squared| {
                let better = squared.total_cmp(&nearest.0).then(index.cmp(&nearest.1));
                if better.is_lt() {
                    nearest = (squared, index);
                }
            });
            if nearest.0.is_finite() {
                break nearest.1 as usize;
            }
            radius *= 2.0;
        };
        let limit = self.cloud.near_limit(target, nearest);
        let mut found = Vec::new();
        // The limit is one on distances; squares are compared with room for their rounding.
        self.cells
            .within(target, limit * (1.0 + 1e-12), |index, _| {
                found.push(index as usize)
            });
        found.retain(|&i| (self.cloud.position[i] - target).norm() <= limit);
        found.sort_unstable();
        found
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
                prop_assert_eq!(locator.all_nearest(&place), cloud.all_nearest(&place));
            }
        }
    }
}
