//! Fill-reducing orderings of symmetric patterns.
//!
//! Nested dissection from the coordinates: a set of points is cut at the median along an axis,
//! the points of one side that touch the other become the separator, and both rests are cut
//! again. The unknowns of the separator are eliminated last, so the two rests fill separately
//! (George 1973, SIAM J. Numer. Anal. 10, 345). It works on points, not on unknowns.

use std::borrow::Cow;

use crate::matrix::Rows;
use crate::problem::{Coordinates, Problem};

/// Sets of at most this many points are not cut further.
const LEAF_POINTS: usize = 64;

/// A permutation of the unknowns with its inverse.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Permutation {
    /// `forward[new]` is the old index.
    pub forward: Vec<u32>,
    /// `inverse[old]` is the new index.
    pub inverse: Vec<u32>,
}

impl Permutation {
    /// Expands an order of points to their unknowns, which stay together.
    fn of_unknowns(point_order: &[u32], unknowns_per_point: usize) -> Self {
        let per_point = unknowns_per_point as u32;
        let unknowns = |point: &u32| point * per_point..(point + 1) * per_point;
        let forward: Vec<u32> = point_order.iter().flat_map(unknowns).collect();
        let mut inverse = vec![0; forward.len()];
        for (new, old) in forward.iter().enumerate() {
            inverse[*old as usize] = new as u32;
        }
        Self { forward, inverse }
    }
}

/// Geometric nested dissection of the unknowns of a problem; `None` without coordinates.
///
/// The problem must be valid (see [`Problem::validate`]). Coincident points are allowed.
#[must_use]
pub fn nested_dissection(problem: &Problem<'_>) -> Option<Permutation> {
    let coordinates = problem.coordinates?;
    let graph = PointGraph::new(problem);
    let points = problem.points();
    let mut dissection = Dissection {
        coordinates,
        graph: &graph,
        side: vec![Side::Out; points],
    };
    let mut order: Vec<u32> = (0..points as u32).collect();
    dissection.order(&mut order);
    Some(Permutation::of_unknowns(&order, problem.unknowns_per_point))
}

/// Adjacency of the points in compressed rows; borrowed where unknowns are points.
struct PointGraph<'a> {
    starts: Cow<'a, [u32]>,
    neighbours: Cow<'a, [u32]>,
}

impl<'a> PointGraph<'a> {
    fn new(problem: &'a Problem<'_>) -> Self {
        let rows = Rows::new(&problem.pattern);
        if problem.unknowns_per_point == 1 {
            let (starts, neighbours) = (rows.starts().into(), rows.columns().into());
            return Self { starts, neighbours };
        }
        Self::condensed(rows, problem.points(), problem.unknowns_per_point)
    }

    fn condensed(rows: Rows<'_>, points: usize, per_point: usize) -> Self {
        let mut starts = vec![0];
        let mut neighbours = Vec::new();
        let mut seen_by = vec![u32::MAX; points];
        for point in 0..points {
            for row in point * per_point..(point + 1) * per_point {
                for column in rows.row(row).0 {
                    let neighbour = column / per_point as u32;
                    if seen_by[neighbour as usize] != point as u32 {
                        seen_by[neighbour as usize] = point as u32;
                        neighbours.push(neighbour);
                    }
                }
            }
            starts.push(neighbours.len() as u32);
        }
        Self {
            starts: starts.into(),
            neighbours: neighbours.into(),
        }
    }

    fn neighbours(&self, point: u32) -> &[u32] {
        let point = point as usize;
        &self.neighbours[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}

/// Where a point lies with respect to the cut under consideration.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Out,
    Low,
    High,
}

/// A cut through a set of points: the axis, and the half the separator is taken from.
struct Cut {
    axis: usize,
    separator_side: Side,
    separator_points: usize,
}

struct Dissection<'a> {
    coordinates: Coordinates<'a>,
    graph: &'a PointGraph<'a>,
    side: Vec<Side>,
}

impl Dissection<'_> {
    /// Reorders the points of a set: low rest, high rest, separator.
    fn order(&mut self, points: &mut [u32]) {
        if points.len() <= LEAF_POINTS {
            points.sort_unstable();
            return;
        }
        let Some(cut) = self.best_cut(points) else {
            return;
        };
        self.split(points, cut.axis);
        let opposite = if cut.separator_side == Side::Low {
            Side::High
        } else {
            Side::Low
        };
        let mut rests = (Vec::new(), Vec::new());
        let mut separator = Vec::with_capacity(cut.separator_points);
        for point in points.iter().copied() {
            match self.side[point as usize] {
                side if side == cut.separator_side && self.touches(point, opposite) => {
                    separator.push(point);
                }
                Side::Low => rests.0.push(point),
                _ => rests.1.push(point),
            }
        }
        self.leave(points);
        let (low, rest) = points.split_at_mut(rests.0.len());
        let (high, last) = rest.split_at_mut(rests.1.len());
        low.copy_from_slice(&rests.0);
        high.copy_from_slice(&rests.1);
        last.copy_from_slice(&separator);
        drop((rests, separator));
        self.order(low);
        self.order(high);
    }

    /// The axis and side with the fewest separator points; the first of equals.
    fn best_cut(&mut self, points: &mut [u32]) -> Option<Cut> {
        let mut best: Option<Cut> = None;
        for axis in 0..self.coordinates.dimension {
            self.split(points, axis);
            for (separator_side, opposite) in [(Side::Low, Side::High), (Side::High, Side::Low)] {
                let in_separator = |point: &&u32| {
                    self.side[**point as usize] == separator_side && self.touches(**point, opposite)
                };
                let separator_points = points.iter().filter(in_separator).count();
                if best
                    .as_ref()
                    .is_none_or(|cut| separator_points < cut.separator_points)
                {
                    best = Some(Cut {
                        axis,
                        separator_side,
                        separator_points,
                    });
                }
            }
        }
        best
    }

    /// Halves a set at the median along an axis and marks the sides. Ties go by index, so the
    /// halves are the same whatever the order of `points`.
    fn split(&mut self, points: &mut [u32], axis: usize) {
        let key = |point: u32| self.coordinates.along(axis, point);
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| {
            key(*a).total_cmp(&key(*b)).then_with(|| a.cmp(b))
        });
        for (position, point) in points.iter().enumerate() {
            let side = if position < middle {
                Side::Low
            } else {
                Side::High
            };
            self.side[*point as usize] = side;
        }
    }

    fn touches(&self, point: u32, side: Side) -> bool {
        self.graph
            .neighbours(point)
            .iter()
            .any(|other| self.side[*other as usize] == side)
    }

    fn leave(&mut self, points: &[u32]) {
        for point in points {
            self.side[*point as usize] = Side::Out;
        }
    }
}
#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_support::{Cloud, jittered_grid, positive_definite, wide_stencil};

    fn is_permutation(order: &Permutation, unknowns: usize) -> bool {
        order.forward.len() == unknowns
            && order.inverse.len() == unknowns
            && (0..unknowns).all(|old| order.forward[order.inverse[old] as usize] == old as u32)
    }

    fn dissect(cloud: &Cloud, per_point: usize, horizon: f64) -> Permutation {
        let a = wide_stencil(cloud, per_point, horizon, 5);
        nested_dissection(&positive_definite(&a, Some(cloud), per_point)).unwrap()
    }

    /// Clouds on a coarse lattice, so that many points coincide or lie on a line.
    fn clouds() -> impl Strategy<Value = Cloud> {
        (1_usize..=3).prop_flat_map(|dimension| {
            let points = proptest::collection::vec(-3_i8..=3, dimension * 150..dimension * 300);
            points.prop_map(move |mut values| {
                values.truncate(values.len() / dimension * dimension);
                let coordinates = values.into_iter().map(f64::from).collect();
                Cloud {
                    dimension,
                    coordinates,
                }
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn random_clouds_with_coincident_points_give_permutations(
            cloud in clouds(), horizon in 0.0_f64..3.0, per_point in 1_usize..=3,
        ) {
            let order = dissect(&cloud, per_point, horizon);
            prop_assert!(is_permutation(&order, cloud.points() * per_point));
        }
    }

    #[test]
    fn lines_and_single_places_are_ordered() {
        let line = Cloud {
            dimension: 2,
            coordinates: (0..400).map(|i| (i % 2) as f64).collect(),
        };
        assert!(is_permutation(&dissect(&line, 1, 0.5), 200));
        let heap = Cloud {
            dimension: 3,
            coordinates: vec![0.0; 600],
        };
        assert!(is_permutation(&dissect(&heap, 2, 0.5), 400));
        let empty = Cloud {
            dimension: 2,
            coordinates: Vec::new(),
        };
        assert!(is_permutation(&dissect(&empty, 1, 0.5), 0));
    }

    #[test]
    fn unknowns_of_a_point_stay_together_in_the_order_of_points() {
        let cloud = jittered_grid(20, 15, 0.3);
        let (points, unknowns) = (dissect(&cloud, 1, 2.3), dissect(&cloud, 3, 2.3));
        for (new, block) in unknowns.forward.chunks_exact(3).enumerate() {
            let first = 3 * points.forward[new];
            assert_eq!(block, [first, first + 1, first + 2]);
        }
    }

    #[test]
    fn the_last_points_separate_the_two_halves() {
        let cloud = jittered_grid(40, 10, 0.0);
        let a = wide_stencil(&cloud, 1, 1.5, 5);
        let order = dissect(&cloud, 1, 1.5);
        let (rest, separator) = order.forward.split_at(390);
        let column = |point: &u32| point % 40;
        assert!(
            separator
                .iter()
                .all(|point| column(point) == column(&separator[0]))
        );
        let cut = column(&separator[0]);
        for (i, j) in rest.iter().flat_map(|i| rest.iter().map(move |j| (i, j))) {
            let apart = (column(i) < cut) != (column(j) < cut);
            assert!(!apart || a.get(*i as usize, *j as usize).is_none());
        }
    }

    #[test]
    fn there_is_no_dissection_without_coordinates() {
        let a = wide_stencil(&jittered_grid(5, 5, 0.0), 1, 1.5, 5);
        assert!(nested_dissection(&positive_definite(&a, None, 1)).is_none());
    }
}
