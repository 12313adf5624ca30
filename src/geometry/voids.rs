//! Voids: what the cells of a cloud leave out of its box, such as a hole or the part beyond a
//! re-entrant corner, known only by the points that are not there.
//!
//! Probes around every point are compared with the cells about them. What no cell reaches is a void,
//! whatever the spacing does: a graded cloud has coarse cells where it has few points. A mesh tells its free
//! surfaces itself.

use super::cell_list::CellList;
use super::{Cloud, Vector};
use crate::parallel;

/// Distance of a probe from its point, in edges of the point's cell.
const PROBE: f64 = 1.5;

/// Distance up to which a cell reaches, in its edges.
///
/// Corners of cubes are at 0.71 (2-D) and 0.87 (3-D). Measured for the probes of lattices jittered by 0.4
/// the farthest from all points is at 1.08 and 1.14, in cells of 4:1 known by their volume alone 1.03.
/// The narrowest void that is found is two cells wide.
const REACH: f64 = 1.25;

/// Empty balls in the box of a cloud.
pub struct Voids<const D: usize> {
    centre: Vec<Vector<D>>,
    radius: Vec<f64>,
    list: Option<CellList<D>>,
    largest: f64,
}

impl<const D: usize> Voids<D> {
    /// Looks for the voids of a cloud whose planes are known; none without planes.
    pub fn find(cloud: &Cloud<D>) -> Self {
        let balls = match (&cloud.outline, cloud.domain.planes && !cloud.filled) {
            (Some(outline), _) => outline.surface.clone(),
            (None, true) => empty_balls(cloud),
            (None, false) => Vec::new(),
        };
        let (centre, radius): (Vec<Vector<D>>, Vec<f64>) = balls.into_iter().unzip();
        let largest = radius.iter().copied().fold(0.0, f64::max);
        Voids {
            list: (!centre.is_empty()).then(|| CellList::new(&centre, 2.0 * largest)),
            centre,
            radius,
            largest,
        }
    }

    /// Whether the cells fill the box.
    pub fn is_empty(&self) -> bool {
        self.centre.is_empty()
    }

    /// Whether a void is nearer to `x` than `distance` (metres).
    pub fn within(&self, x: &Vector<D>, distance: f64) -> bool {
        let mut found = false;
        if let Some(list) = &self.list {
            list.within(x, distance + self.largest, |ball, squared| {
                found |= squared.sqrt() - self.radius[ball as usize] < distance;
            });
        }
        found
    }
}

/// Points of about the same cell size, for searches that do not suffer from the largest cells.
struct Level<const D: usize> {
    points: Vec<u32>,
    list: CellList<D>,
    /// Largest edge of a cell, m.
    edge: f64,
}

fn levels<const D: usize>(cloud: &Cloud<D>) -> Vec<Level<D>> {
    let mut sizes: Vec<(i32, u32)> = (0_u32..)
        .zip(&cloud.cell)
        .map(|(point, cell)| (cell.amax().log2().floor() as i32, point))
        .collect();
    sizes.sort_unstable();
    let level = |own: &[(i32, u32)]| {
        let points: Vec<u32> = own.iter().map(|(_, point)| *point).collect();
        let position = |point: &u32| cloud.position[*point as usize];
        let positions: Vec<Vector<D>> = points.iter().map(position).collect();
        let edge = 2.0_f64.powi(own[0].0 + 1);
        Level {
            points,
            list: CellList::new(&positions, REACH * edge),
            edge,
        }
    };
    sizes.chunk_by(|a, b| a.0 == b.0).map(level).collect()
}

/// Centres and radii of balls that no cell reaches, found from the points beside them.
fn empty_balls<const D: usize>(cloud: &Cloud<D>) -> Vec<(Vector<D>, f64)> {
    let levels = levels(cloud);
    let directions = directions::<D>();
    parallel::gather(cloud.len(), |point, found| {
        let probe = |direction: &Vector<D>| {
            let arm = direction.component_mul(&cloud.cell[point]) * PROBE;
            let at = cloud.position[point] + arm;
            let domain = &cloud.domain;
            let inside = at > domain.lower && at < domain.upper;
            let radius = inside.then(|| clearance(cloud, &levels, &at, arm.norm()))?;
            Some((at, radius?))
        };
        found.extend(directions.iter().filter_map(probe));
    })
}

/// Distance from `at` to the nearest cell within `reach`, m; `None` where a cell reaches `at`.
fn clearance<const D: usize>(
    cloud: &Cloud<D>,
    levels: &[Level<D>],
    at: &Vector<D>,
    reach: f64,
) -> Option<f64> {
    let (mut filled, mut nearest) = (false, reach);
    for level in levels {
        let radius = reach.max(REACH * level.edge);
        level.list.within(at, radius, |index, squared| {
            let point = level.points[index as usize] as usize;
            let arm = (cloud.position[point] - at).component_div(&cloud.cell[point]);
            filled |= arm.norm_squared() < REACH * REACH;
            nearest = nearest.min(squared.sqrt() - 0.5 * cloud.spacing(point));
        });
        if filled {
            return None;
        }
    }
    Some(nearest.max(0.0))
}

/// Unit vectors to the corners, edges and faces of a cube, in the plane also those between.
fn directions<const D: usize>() -> Vec<Vector<D>> {
    let steps: i32 = if D == 2 { 2 } else { 1 };
    let width = (2 * steps + 1) as usize;
    let all = (0..width.pow(D as u32)).map(|mut index| {
        Vector::<D>::from_fn(|_, _| {
            let k = index % width;
            index /= width;
            f64::from(k as i32 - steps)
        })
    });
    let rim = all.filter(|v| v.amax() > f64::from(steps) - 0.5);
    rim.map(|v| v.normalize()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Shape;
    use crate::geometry::generate::{Refinement, Segment, blocks, graded, jitter, lattice};

    /// The same points, known by position and volume alone, as from a file.
    fn as_read<const D: usize>(mut cloud: Cloud<D>) -> Cloud<D> {
        cloud.cell = (0..cloud.len())
            .map(|i| Vector::repeat(cloud.spacing(i)))
            .collect();
        cloud.filled = false;
        cloud
    }

    fn without<const D: usize>(cloud: Cloud<D>, out: impl Fn(&Vector<D>) -> bool) -> Cloud<D> {
        let mut cloud = as_read(cloud);
        let kept = |i: &usize| !out(&cloud.position[*i]);
        let kept: Vec<usize> = (0..cloud.len()).filter(kept).collect();
        cloud.cell = kept.iter().map(|&i| cloud.cell[i]).collect();
        cloud.volume = kept.iter().map(|&i| cloud.volume[i]).collect();
        cloud.position = kept.iter().map(|&i| cloud.position[i]).collect();
        cloud
    }

    fn jittered<const D: usize>(cells: usize, amount: f64, seed: u64) -> Cloud<D> {
        let mut cloud = lattice(Vector::zeros(), Vector::repeat(1.0), [cells; D]).unwrap();
        jitter(&mut cloud, amount, seed);
        cloud
    }

    fn refined<const D: usize>(levels: u32) -> Cloud<D> {
        let region = Shape::Box {
            min: vec![0.3; D],
            max: vec![0.5; D],
        };
        let refinements = [Refinement { region, levels }];
        blocks(Vector::zeros(), Vector::repeat(1.0), 0.1, &refinements).unwrap()
    }

    #[test]
    fn clouds_that_fill_their_box_have_none() {
        for seed in 0..20 {
            assert!(Voids::find(&as_read(jittered::<2>(40, 0.4, seed))).is_empty());
        }
        for seed in 0..4 {
            assert!(Voids::find(&as_read(jittered::<3>(14, 0.4, seed))).is_empty());
        }
        assert!(Voids::find(&as_read(refined::<2>(4))).is_empty());
        assert!(Voids::find(&as_read(refined::<3>(2))).is_empty());
        let flat = lattice(Vector::zeros(), Vector::<2>::new(4.0, 1.0), [20, 20]).unwrap();
        assert!(Voids::find(&as_read(flat)).is_empty(), "cells of 4:1");
        let axis = |first, last| {
            vec![Segment {
                length: 1.0,
                first,
                last,
            }]
        };
        let tensor = graded(Vector::<2>::zeros(), &[axis(0.02, 0.08), axis(0.05, 0.02)]).unwrap();
        assert!(Voids::find(&as_read(tensor)).is_empty(), "tensor grading");
    }

    /// Points within two spacings of a void are near it, those four away are not.
    fn finds<const D: usize>(cloud: &Cloud<D>, inside: impl Fn(&Vector<D>) -> bool, edge: f64) {
        let cut = without(cloud.clone(), &inside);
        let voids = Voids::find(&cut);
        assert!(!voids.is_empty());
        for (i, x) in cut.position.iter().enumerate() {
            let gone = cloud.position.iter().filter(|y| inside(y));
            let gap = gone.map(|y| (y - x).norm()).fold(f64::INFINITY, f64::min);
            let near = voids.within(x, edge);
            assert!(!near || gap < 2.5 * edge, "{x} is {gap} away");
            // Points that moved by 0.3 leave a void that begins so much later.
            assert!(near || gap > 1.1 * edge, "{x} is {gap} away ({i})");
        }
    }

    #[test]
    fn holes_notches_and_re_entrant_corners_are_found_where_they_are() {
        let round = |x: &Vector<2>| (x - Vector::repeat(0.4)).norm() < 0.15;
        let corner = |x: &Vector<2>| x[0] > 0.5 && x[1] > 0.5;
        for amount in [0.0, 0.3] {
            let cloud = jittered::<2>(40, amount, 3);
            finds(&cloud, round, 0.025);
            finds(&cloud, corner, 0.025);
        }
        let slot = |x: &Vector<2>| x[0] < 0.6 && (x[1] - 0.5).abs() < 0.05;
        finds(&jittered::<2>(40, 0.0, 3), slot, 0.025);
    }
}
