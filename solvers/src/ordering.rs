//! Fill-reducing orderings of symmetric patterns.
//!
//! Nested dissection from the coordinates: a set of points is cut at the median along an axis,
//! the points of one side that touch the other become the separator, and both rests are cut
//! again. The unknowns of the separator are eliminated last, so the two rests fill separately
//! (George 1973, SIAM J. Numer. Anal. 10, 345). It works on points, not on unknowns.
//!
//! Sweep along the longest axis: a band as wide as the reach of the rows. It fills less where a
//! cloud is hardly wider than that reach.

use std::borrow::Cow;

use crate::matrix::Rows;
use crate::problem::{Coordinates, Problem, Symmetry};

/// Sets of at most this many points are not cut further.
const LEAF_POINTS: usize = 64;
/// Points of a sweep whose unknowns of one kind stay together.
const SWEEP_POINTS: usize = 16;
/// Length over width from which a sweep may pay.
const SLENDER: f64 = 2.0;

/// A permutation of the unknowns with its inverse.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Permutation {
    /// `forward[new]` is the old index.
    pub forward: Vec<u32>,
    /// `inverse[old]` is the new index.
    pub inverse: Vec<u32>,
}

impl Permutation {
    fn new(forward: Vec<u32>) -> Self {
        let mut inverse = vec![0; forward.len()];
        for (new, old) in forward.iter().enumerate() {
            inverse[*old as usize] = new as u32;
        }
        Self { forward, inverse }
    }
}

/// An order of points in consecutive groups that are eliminated together.
#[derive(Debug, Default)]
pub(crate) struct PointOrder {
    points: Vec<u32>,
    /// Number of points of each group.
    groups: Vec<usize>,
}

impl PointOrder {
    pub(crate) fn of_points(&self) -> Permutation {
        Permutation::new(self.points.clone())
    }

    /// The order of the unknowns. The unknowns of a point stay together in a positive definite
    /// problem. In a quasi-definite one a group lists the first unknowns of its points, then the
    /// second ones and so on: a last unknown with a tiny diagonal entry (a pressure without
    /// storage) gets a large pivot only after its neighbours of the other block.
    pub(crate) fn of_unknowns(&self, problem: &Problem<'_>) -> Permutation {
        let per_point = problem.unknowns_per_point as u32;
        if problem.symmetry != Symmetry::QuasiDefinite {
            let unknowns = |point: &u32| point * per_point..(point + 1) * per_point;
            return Permutation::new(self.points.iter().flat_map(unknowns).collect());
        }
        let mut forward = Vec::with_capacity(problem.unknowns());
        let mut rest = self.points.as_slice();
        for size in &self.groups {
            let (group, after) = rest.split_at(*size);
            for kind in 0..per_point {
                forward.extend(group.iter().map(|point| point * per_point + kind));
            }
            rest = after;
        }
        Permutation::new(forward)
    }
}

/// Geometric nested dissection of the unknowns of a problem; `None` without coordinates.
///
/// The problem must be valid (see [`Problem::validate`]). Coincident points are allowed.
#[must_use]
pub fn nested_dissection(problem: &Problem<'_>) -> Option<Permutation> {
    let coordinates = problem.coordinates?;
    let graph = PointGraph::new(problem);
    Some(dissect(&coordinates, &graph).of_unknowns(problem))
}

/// Nested dissection of the points. A group is a separator or a set not cut further.
pub(crate) fn dissect(coordinates: &Coordinates<'_>, graph: &PointGraph<'_>) -> PointOrder {
    let count = graph.starts.len() - 1;
    let mut dissection = Dissection {
        coordinates: *coordinates,
        graph,
        side: vec![Side::Out; count],
        groups: Vec::new(),
    };
    let mut points: Vec<u32> = (0..count as u32).collect();
    dissection.order(&mut points);
    PointOrder {
        points,
        groups: dissection.groups,
    }
}

/// Points sorted along the longest axis, ties by the other axes and the index: from both ends to the middle, so that
/// both halves can be eliminated at the same time.
pub(crate) fn sweep(coordinates: &Coordinates<'_>, count: usize) -> PointOrder {
    let mut axes: Vec<usize> = (0..coordinates.dimension).collect();
    let extents = extents(coordinates);
    axes.sort_by(|a, b| extents[*b].total_cmp(&extents[*a]));
    let compare = |a: &u32, b: &u32| {
        let along = |axis: &usize| {
            let key = |point| coordinates.along(*axis, point);
            key(*a).total_cmp(&key(*b))
        };
        let differing = axes.iter().map(along).find(|order| order.is_ne());
        differing.unwrap_or_else(|| a.cmp(b))
    };
    let mut points: Vec<u32> = (0..count as u32).collect();
    points.sort_unstable_by(compare);
    let (one, other) = points.split_at_mut(count / 2);
    other.reverse();
    let groups = [one, other]
        .into_iter()
        .flat_map(|half| half.chunks(SWEEP_POINTS));
    let groups = groups.map(<[u32]>::len).collect();
    PointOrder { points, groups }
}

/// Whether a cloud of at least two dimensions is much longer along one axis than along the others.
pub(crate) fn is_slender(coordinates: &Coordinates<'_>) -> bool {
    let mut extents = extents(coordinates);
    extents.sort_by(|a, b| b.total_cmp(a));
    extents.len() > 1 && extents[0] >= SLENDER * extents[1]
}

/// Difference of the largest and smallest coordinate along each axis; negative without points.
fn extents(coordinates: &Coordinates<'_>) -> Vec<f64> {
    let extent = |axis: usize| {
        let values = coordinates.values.iter().skip(axis);
        let values = values.step_by(coordinates.dimension);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        high - low
    };
    (0..coordinates.dimension).map(extent).collect()
}

/// Adjacency of the points in compressed rows; borrowed where unknowns are points.
pub(crate) struct PointGraph<'a> {
    starts: Cow<'a, [u32]>,
    neighbours: Cow<'a, [u32]>,
}

impl<'a> PointGraph<'a> {
    pub(crate) fn new(problem: &'a Problem<'_>) -> Self {
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

    /// Starts of the rows and the neighbours in them, not sorted.
    pub(crate) fn parts(&self) -> (&[u32], &[u32]) {
        (&self.starts, &self.neighbours)
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
    groups: Vec<usize>,
}

impl Dissection<'_> {
    /// Reorders the points of a set: low rest, high rest, separator.
    fn order(&mut self, points: &mut [u32]) {
        if points.len() <= LEAF_POINTS {
            points.sort_unstable();
            self.groups.push(points.len());
            return;
        }
        let Some(cut) = self.best_cut(points) else {
            self.groups.push(points.len());
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
        self.groups.push(last.len());
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
mod tests;
