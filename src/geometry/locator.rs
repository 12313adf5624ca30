//! Places that are no points, and the points nearest to them.

use super::cell_list::CellList;
use super::{Cloud, Vector};
use crate::parallel;

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
        let nearest = cloud.nearest(&at).map_or_else(Vec::new, |first| {
            let limit = limit(cloud, &at, first);
            let near = |&i: &usize| (cloud.position[i] - at).norm() <= limit;
            (0..cloud.len()).filter(near).collect()
        });
        Place { at, nearest }
    }
}

/// Distance up to which points count as near as the nearest one.
fn limit<const D: usize>(cloud: &Cloud<D>, at: &Vector<D>, nearest: usize) -> f64 {
    (cloud.position[nearest] - at).norm() + 1e-6 * cloud.spacing(nearest)
}

/// Distance of every point to the nearest other one, shape `(n,)`, m; found from positions alone, as
/// volumes may be at fault.
pub fn neighbour_distances<const D: usize>(cloud: &Cloud<D>) -> Vec<f64> {
    let position = &cloud.position;
    let Some(first) = position.first() else {
        return Vec::new();
    };
    let (low, high) = (position.iter()).fold((*first, *first), |(l, h), x| (l.inf(x), h.sup(x)));
    let widest = (high - low).amax();
    // Of points on a line or in a plane the other edges say nothing.
    let box_of = (high - low).map(|edge| edge.max(1e-3 * widest)).product();
    let typical = super::edge(box_of / position.len() as f64, D).max(f64::MIN_POSITIVE);
    let cells = CellList::new(position, typical);
    let nearest = |point: usize| {
        let mut radius = typical;
        loop {
            let mut best = f64::INFINITY;
            cells.within(&position[point], radius, |other, squared| {
                if other as usize != point {
                    best = best.min(squared);
                }
            });
            if best.is_finite() || radius > 2.0 * widest {
                return best.sqrt();
            }
            radius *= 2.0;
        }
    };
    parallel::map(position.len(), nearest)
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
        self.place_among(at, |_| true).unwrap_or(Place {
            at,
            nearest: Vec::new(),
        })
    }

    /// As [`Place::find`], among the points whose positions are wanted; `None` without any.
    pub fn place_among(
        &self,
        at: Vector<D>,
        wanted: impl Fn(&Vector<D>) -> bool,
    ) -> Option<Place<D>> {
        let position = &self.cloud.position;
        let limit = limit(self.cloud, &at, self.nearest(&at, &wanted)?);
        let mut nearest = Vec::new();
        // The limit is one on distances; squares are compared with room for their rounding.
        self.cells.within(&at, limit * (1.0 + 1e-12), |index, _| {
            nearest.push(index as usize);
        });
        nearest.retain(|&i| (position[i] - at).norm() <= limit && wanted(&position[i]));
        nearest.sort_unstable();
        Some(Place { at, nearest })
    }

    fn nearest(&self, at: &Vector<D>, wanted: impl Fn(&Vector<D>) -> bool) -> Option<usize> {
        let mut radius = self.reach;
        while radius.is_finite() {
            let (mut nearest, mut seen) = ((f64::INFINITY, u32::MAX), 0);
            self.cells.within(at, radius, |index, squared| {
                seen += 1;
                let better = squared.total_cmp(&nearest.0).then(index.cmp(&nearest.1));
                if better.is_lt() && wanted(&self.cloud.position[index as usize]) {
                    nearest = (squared, index);
                }
            });
            if nearest.0.is_finite() {
                return Some(nearest.1 as usize);
            }
            if seen == self.cloud.len() {
                return None;
            }
            radius *= 2.0;
        }
        None
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

    #[test]
    fn only_wanted_points_are_found_if_there_are_any() {
        let cloud = lattice(Vector::<2>::zeros(), Vector::repeat(1.0), [10, 10]).unwrap();
        let locator = Locator::new(&cloud);
        let at = Vector::<2>::new(0.5, 0.5);
        let above = locator.place_among(at, |x| x[1] > 0.5).unwrap();
        assert_eq!(above.nearest, [54, 55]);
        let far = locator.place_among(at, |x| x[0] > 0.9).unwrap();
        assert_eq!(far.nearest, [49, 59]);
        assert_eq!(locator.place_among(at, |x| x[0] > 1.0), None);
        let nowhere = Vector::<2>::new(f64::NAN, 0.0);
        assert_eq!(locator.place_among(nowhere, |_| true), None);
    }
}
