//! Voronoi cells, clipped from a box by the planes half way to the points of a family.

use super::cells::{Arm, Cell, CellFace};
use crate::geometry::{Cloud, Vector};

/// A flat part of the surface of a convex body.
struct Facet<const D: usize> {
    /// Place of the bond in the family; `None` on the box.
    bond: Option<usize>,
    /// Its plane: unit normal out of the body, and distance from the point.
    normal: Vector<D>,
    distance: f64,
    /// Its two ends in the plane, its corners in order in space.
    corners: Vec<Vector<D>>,
}

/// Edges of its cell that a point reaches at most where points may leave voids, as [`Voids`] takes it.
///
/// [`Voids`]: crate::geometry::Voids
const REACH: f64 = 1.25;
/// Lengths and areas below this share of the cell's are rounding error.
const ROUNDING: f64 = 1e-10;

/// The cell of `owner`, whose family has the given arms.
///
/// Where cells are known to fill the domain the family bounds it. Other points may lie at a void or at an
/// outer boundary of which nothing is known: towards these the cell ends half an edge from the point.
pub(super) fn cell<const D: usize>(cloud: &Cloud<D>, owner: usize, arms: &[Arm<D>]) -> Cell<D> {
    let edges = cloud.cell[owner];
    let widest = arms.iter().map(|(_, xi)| xi.norm()).fold(0.0, f64::max);
    let closed = cloud.filled && cloud.domain.planes;
    let mut half = [match closed {
        true => Vector::repeat(widest.max(edges.amax())),
        false => edges * REACH,
    }; 2];
    let mut order: Vec<usize> = (0..arms.len()).collect();
    order.sort_by(|&a, &b| {
        arms[a]
            .1
            .norm_squared()
            .total_cmp(&arms[b].1.norm_squared())
    });
    let mut facets = clipped(&half, arms, &order);
    if !closed {
        // What is left of the box lies towards a void: there the cell has no more than its half edge.
        for facet in facets.iter().filter(|facet| facet.bond.is_none()) {
            let axis = facet.normal.iamax();
            half[usize::from(facet.normal[axis] > 0.0)][axis] = 0.5 * edges[axis];
        }
        facets = clipped(&half, arms, &order);
    }
    summed(&facets, arms, edges.amax())
}

/// The box with the given half edges below and above, clipped half way to every arm.
fn clipped<const D: usize>(
    half: &[Vector<D>; 2],
    arms: &[Arm<D>],
    order: &[usize],
) -> Vec<Facet<D>> {
    let mut facets = whole(half);
    for &bond in order {
        let xi = arms[bond].1;
        let length = xi.norm();
        let radius = facets.iter().map(Facet::radius).fold(0.0, f64::max);
        if 0.5 * length > radius {
            break;
        }
        cut(&mut facets, bond, &(xi / length), 0.5 * length);
    }
    facets
}

impl<const D: usize> Facet<D> {
    fn radius(&self) -> f64 {
        self.corners.iter().map(Vector::norm).fold(0.0, f64::max)
    }

    /// Area (length in the plane) and middle.
    fn measure(&self) -> (f64, Vector<D>) {
        let first = self.corners[0];
        if D == 2 {
            let along = self.corners[1] - first;
            return (along.norm(), first + along * 0.5);
        }
        let (mut area, mut sum) = (0.0, Vector::zeros());
        for pair in self.corners[1..].windows(2) {
            let own = 0.5 * cross(&(pair[0] - first), &(pair[1] - first)).norm();
            area += own;
            sum += (first + pair[0] + pair[1]) * (own / 3.0);
        }
        match area > 0.0 {
            true => (area, sum / area),
            false => (0.0, first),
        }
    }
}

/// Cross product in space.
fn cross<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> Vector<D> {
    Vector::from_fn(|axis, _| {
        let (next, last) = ((axis + 1) % D, (axis + 2) % D);
        a[next] * b[last] - a[last] * b[next]
    })
}

/// The facets of a box about the point.
fn whole<const D: usize>(half: &[Vector<D>; 2]) -> Vec<Facet<D>> {
    let facet = |axis: usize, upper: usize| {
        // Corners in order around the facet: all combinations of the other axes, in Gray's order.
        let corner = |k: usize| {
            let mut at = Vector::<D>::zeros();
            at[axis] = half[upper][axis] * if upper == 1 { 1.0 } else { -1.0 };
            for (bit, other) in (0..D).filter(|other| *other != axis).enumerate() {
                let side = (k ^ (k >> 1)) >> bit & 1;
                at[other] = half[side][other] * if side == 1 { 1.0 } else { -1.0 };
            }
            at
        };
        let mut normal = Vector::<D>::zeros();
        normal[axis] = if upper == 1 { 1.0 } else { -1.0 };
        Facet {
            bond: None,
            normal,
            distance: half[upper][axis],
            corners: (0..1 << (D - 1)).map(corner).collect(),
        }
    };
    let sides = (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]);
    sides.map(|(axis, upper)| facet(axis, upper)).collect()
}

/// Keeps what lies below `distance` along `normal`; the cut becomes a facet of `bond`.
fn cut<const D: usize>(facets: &mut Vec<Facet<D>>, bond: usize, normal: &Vector<D>, distance: f64) {
    let slack = ROUNDING * distance;
    let above = |corner: &Vector<D>| corner.dot(normal) - distance;
    let corners = facets.iter().flat_map(|facet| &facet.corners);
    if corners.map(above).fold(f64::NEG_INFINITY, f64::max) <= slack {
        return;
    }
    let mut rim: Vec<Vector<D>> = Vec::new();
    for facet in facets.iter_mut() {
        let old = std::mem::take(&mut facet.corners);
        let pairs = if D == 2 { 1 } else { old.len() };
        if D == 2 && above(&old[0]) <= slack {
            facet.corners.push(old[0]);
        }
        for k in 0..pairs {
            let (from, to) = (old[k], old[(k + 1) % old.len()]);
            let (low, high) = (above(&from), above(&to));
            if (low > slack) != (high > slack) {
                let crossing = from + (to - from) * (low / (low - high)).clamp(0.0, 1.0);
                facet.corners.push(crossing);
                rim.push(crossing);
            }
            if high <= slack {
                facet.corners.push(to);
            }
        }
    }
    facets.retain(|facet| facet.corners.len() >= D);
    if rim.len() >= D {
        around(&mut rim, normal);
        facets.push(Facet {
            bond: Some(bond),
            normal: *normal,
            distance,
            corners: rim,
        });
    }
}

/// Orders the corners of a cut in space by their angle.
fn around<const D: usize>(rim: &mut [Vector<D>], normal: &Vector<D>) {
    if D == 2 {
        return;
    }
    let middle = rim.iter().sum::<Vector<D>>() / rim.len() as f64;
    let mut axis = Vector::<D>::zeros();
    axis[normal.iamin()] = 1.0;
    let first = cross(normal, &axis);
    let second = cross(normal, &first);
    let angle = |corner: &Vector<D>| {
        let arm = corner - middle;
        arm.dot(&second).atan2(arm.dot(&first))
    };
    rim.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
}

/// Faces and volume; `edge` is the length that rounding is relative to.
fn summed<const D: usize>(facets: &[Facet<D>], arms: &[Arm<D>], edge: f64) -> Cell<D> {
    let mut cell = Cell {
        faces: Vec::new(),
        volume: 0.0,
        reach: 2.0 * facets.iter().map(Facet::radius).fold(0.0, f64::max),
    };
    for facet in facets {
        let (area, middle) = facet.measure();
        cell.volume += area * facet.distance / D as f64;
        if let Some(bond) = facet
            .bond
            .filter(|_| area > ROUNDING * edge.powi(D as i32 - 1))
        {
            cell.faces.push(CellFace {
                bond,
                conductance: area / arms[bond].1.norm(),
                area,
                arm: middle,
                share: 0.5,
                steps: [0; D],
            });
        }
    }
    cell.faces.sort_by_key(|face| face.bond);
    cell
}
