//! The cells that points stand for, and the faces through which they exchange fluid.
//!
//! Every cell belongs to one point and every face to the bond between two. On grids the cells are the boxes
//! of the generator; of the bonds those between touching boxes are kept, on uniform grids also the ones
//! across edges. Elsewhere they are Voronoi cells.

use super::voronoi;
use crate::geometry::{Cloud, Families, GeometryError, ImageTable, Subdomain, Vector};

/// How the cells of a cloud are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cells {
    /// Equal boxes, side by side.
    Lattice,
    /// The same with bonds across every edge, for tensors that are not along the axes.
    Oblique,
    /// Boxes of a tensor grid.
    Tensor,
    /// By the points alone.
    Scattered,
}

/// What a bond between two cells carries for unit mobility.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CellFace<const D: usize> {
    /// Place of the bond in the family that was asked about.
    pub bond: usize,
    /// Conductance of the bond of two cells, both directions together, m^(D−2).
    pub conductance: f64,
    /// Area of the face, m^(D−1); 0 where cells meet at an edge.
    pub area: f64,
    /// From the point to the middle of the face, m; to the middle of the bond where cells meet at an edge.
    pub arm: Vector<D>,
    /// Part of the bond in the owner's cell.
    pub share: f64,
    /// Step to the other cell along every axis of a grid, −1, 0 or 1; zero elsewhere.
    pub steps: [i8; D],
}

/// The cell of one point.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Cell<const D: usize> {
    /// Its faces, in the order of the family.
    pub faces: Vec<CellFace<D>>,
    /// Its volume, m^D.
    pub volume: f64,
    /// Points farther away than this have no face with it, m; 0 on grids, whose neighbours are known.
    pub reach: f64,
}

/// A neighbour and the vector to it, m.
pub(crate) type Arm<const D: usize> = (usize, Vector<D>);

/// The cell of `owner`, whose family has the given arms.
pub(crate) fn cell_faces<const D: usize>(
    cloud: &Cloud<D>,
    cells: Cells,
    owner: usize,
    arms: &[Arm<D>],
) -> Cell<D> {
    match cells {
        Cells::Scattered => voronoi::cell(cloud, owner, arms),
        Cells::Lattice | Cells::Oblique | Cells::Tensor => grid_cell(cloud, cells, owner, arms),
    }
}

/// Distance from touching, in edges of the smaller cell, that is rounding error: points farther from the
/// origin than 1e10 edges are refused.
const TOUCH: f64 = 1e-4;

fn grid_cell<const D: usize>(
    cloud: &Cloud<D>,
    cells: Cells,
    owner: usize,
    arms: &[Arm<D>],
) -> Cell<D> {
    let own = cloud.cell[owner];
    let edges = match cells {
        Cells::Lattice => edge_weights(&own),
        _ => [[0.0; D]; D],
    };
    let mut faces = Vec::new();
    for (bond, (end, xi)) in arms.iter().enumerate() {
        let Some(steps) = steps_between(&own, &cloud.cell[*end], xi) else {
            continue;
        };
        let axes: Vec<usize> = (0..D).filter(|axis| steps[*axis] != 0).collect();
        let (area, conductance) = match axes[..] {
            [a] => {
                let area = own.product() / own[a];
                let moved = 2.0 * edges[a].iter().sum::<f64>();
                (area, area / xi[a].abs() - moved)
            }
            [a, b] => (0.0, edges[a][b]),
            _ => (0.0, 0.0),
        };
        let kept = conductance > 0.0 || cells == Cells::Oblique && axes.len() == 2;
        if let Some(&axis) = axes.first().filter(|_| kept) {
            let share = 0.5 * own[axis] / xi[axis].abs();
            faces.push(CellFace {
                bond,
                conductance,
                area,
                arm: xi * share,
                share,
                steps,
            });
        }
    }
    Cell {
        faces,
        volume: cloud.volume[owner],
        reach: 0.0,
    }
}

/// Distance within which every point of a grid has all cells that its own touches, m, shape `(n,)`.
pub(super) fn grid_reach<const D: usize>(cloud: &Cloud<D>, cells: Cells) -> Vec<f64> {
    let strides = strides(cloud);
    let reach = |point: usize| match cells {
        Cells::Lattice | Cells::Oblique => cloud.cell[point].norm(),
        _ => (0..D)
            .map(|axis| widest_pitch(cloud, point, axis, strides[axis]))
            .fold(0.0, f64::max),
    };
    (0..cloud.len())
        .map(|point| reach(point) * (1.0 + TOUCH))
        .collect()
}

/// Cells along every axis of a grid, whose points run along x first.
fn counts<const D: usize>(cloud: &Cloud<D>) -> [usize; D] {
    let mut stride = 1;
    std::array::from_fn(|axis| {
        let at = |k: usize| cloud.position.get(stride * k).map(|x| x[axis]);
        let goes_on = |k: &usize| {
            at(*k)
                .zip(at(k - 1))
                .is_some_and(|(here, last)| here > last)
        };
        let count = 1 + (1..).take_while(goes_on).count();
        stride *= count;
        count
    })
}

/// Whether the points of a grid run along x first, then along the other axes; those of blocks do not.
pub(crate) fn runs_along_axes<const D: usize>(cloud: &Cloud<D>) -> bool {
    counts(cloud).iter().product::<usize>() == cloud.len()
}

/// Points between neighbours along every axis of a grid.
fn strides<const D: usize>(cloud: &Cloud<D>) -> [usize; D] {
    let counts = counts(cloud);
    std::array::from_fn(|axis| counts[..axis].iter().product())
}

/// Bonds of every point of a grid that runs along the axes to all that differ by one cell at most along each axis, without a search:
/// about flat cells a ball would hold thousands of points. Horizons are taken down as they are.
///
/// # Errors
/// As [`Families::of`].
pub(crate) fn grid_families<const D: usize>(
    cloud: &Cloud<D>,
    images: ImageTable<D>,
    share: Subdomain,
    horizon: Vec<f64>,
) -> Result<Families<D>, GeometryError> {
    let (counts, strides) = (counts(cloud), strides(cloud));
    let steps: Vec<[i64; D]> = (0..3_usize.pow(D as u32))
        .map(|mut index| {
            std::array::from_fn(|_| {
                let step = (index % 3) as i64 - 1;
                index /= 3;
                step
            })
        })
        .filter(|step| step.iter().any(|own| *own != 0))
        .collect();
    let place_of = |order: &[i32; D]| {
        let digits = order.iter().rev();
        digits.fold(0, |place, own| 3 * place + (own + 1) as usize)
    };
    let mut numbers = vec![None; 3_usize.pow(D as u32)];
    for (number, image) in images.iter().enumerate() {
        if image.order.iter().all(|own| own.abs() <= 1) {
            numbers[place_of(&image.order)] = Some(number as u8);
        }
    }
    let bond = |point: usize, step: &[i64; D]| {
        let (mut end, mut order) = (0, [0; D]);
        for axis in 0..D {
            let last = counts[axis] as i64 - 1;
            let place = (point / strides[axis] % counts[axis]) as i64 + step[axis];
            let inside = place.clamp(0, last);
            // Behind a side lies the image of the cell before it.
            order[axis] = (place - inside) as i32;
            end += inside as usize * strides[axis];
        }
        let image = numbers[place_of(&order)]?;
        Some((end as u32, image))
    };
    let family = |point: usize, bonds: &mut Vec<(u32, u8)>| {
        let before = bonds.len();
        bonds.extend(steps.iter().filter_map(|s| bond(point, s)));
        bonds[before..].sort_unstable();
    };
    Families::of(horizon, images.clone(), share, family)
}

/// Larger distance from a point of a grid to its two neighbours along an axis, its own image included, m.
fn widest_pitch<const D: usize>(cloud: &Cloud<D>, point: usize, axis: usize, stride: usize) -> f64 {
    let own = cloud.cell[point][axis];
    let pitch = |other: Option<usize>| {
        let end = cloud.position.get(other?)?;
        let arm = end - cloud.position[point];
        let across = (0..D).any(|other| other != axis && arm[other] != 0.0);
        (!across).then(|| arm[axis].abs())
    };
    let (below, above) = (
        pitch(point.checked_sub(stride)),
        pitch(point.checked_add(stride)),
    );
    below.unwrap_or(own).max(above.unwrap_or(own))
}

/// −1, 0 or 1 along every axis where two boxes touch; `None` where they do not.
fn steps_between<const D: usize>(
    own: &Vector<D>,
    other: &Vector<D>,
    xi: &Vector<D>,
) -> Option<[i8; D]> {
    let mut steps = [0; D];
    for axis in 0..D {
        let slack = TOUCH * own[axis].min(other[axis]);
        let pitch = 0.5 * (own[axis] + other[axis]);
        let gap = xi[axis].abs();
        steps[axis] = match gap {
            gap if gap < slack => 0,
            gap if (gap - pitch).abs() < slack => xi[axis].signum() as i8,
            _ => return None,
        };
    }
    Some(steps)
}

/// Conductances c_ab of the bonds across edges in every plane of axes, m^(D−2); the face across a keeps
/// V/h_a² − 2 Σ_b c_ab, so that Σ c ξ⊗ξ over half the bonds is V I.
///
/// With c_ab = V (h_a² + h_b²)/(12 h_a² h_b²) the error of second order is that of Δ applied twice to a
/// sum of squares: it vanishes where Δp does. On squares c is 1/6 and the faces have 2/3, on cubes h/6 and
/// h/3. Where a face would get no positive conductance (edges of more than √5 : 1 in the plane) all edges
/// have none, which leaves the flux between two points.
pub(super) fn edge_weights<const D: usize>(cell: &Vector<D>) -> [[f64; D]; D] {
    let volume = cell.product();
    let mut weights = [[0.0; D]; D];
    for a in 0..D {
        for b in (0..D).filter(|b| *b != a) {
            let (a2, b2) = (cell[a].powi(2), cell[b].powi(2));
            weights[a][b] = volume * (a2 + b2) / (12.0 * a2 * b2);
        }
    }
    let face = |a: usize| volume / cell[a].powi(2);
    let keeps = |a: usize| 2.0 * weights[a].iter().sum::<f64>() < (1.0 - LEAST) * face(a);
    match (0..D).all(keeps) {
        true => weights,
        false => [[0.0; D]; D],
    }
}

/// Least share of its area that a face keeps beside the edges; it has 2/3 on squares, 1/3 on cubes.
const LEAST: f64 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ c ξ⊗ξ over half of all bonds between boxes of these edges, over the volume.
    fn moment<const D: usize>(cell: Vector<D>) -> (Vector<D>, f64) {
        let edges = edge_weights(&cell);
        let mut moment = Vector::zeros();
        let mut least = f64::INFINITY;
        for a in 0..D {
            let face = cell.product() / cell[a].powi(2) - 2.0 * edges[a].iter().sum::<f64>();
            let across: f64 = edges[a].iter().sum();
            moment[a] = (face + 2.0 * across) * cell[a].powi(2) / cell.product();
            least = least.min(face);
        }
        (moment, least)
    }

    #[test]
    fn weights_are_positive_and_their_second_moment_is_the_identity_at_every_aspect() {
        for ratio in [1.0, 1.3, 2.0, 2.2, 2.3, 5.0, 100.0] {
            let (plane, least) = moment(Vector::<2>::new(ratio, 1.0));
            assert!((plane - Vector::repeat(1.0)).amax() < 1e-14 && least > 0.0);
            let (space, least) = moment(Vector::<3>::new(ratio, 1.0, 1.2));
            assert!((space - Vector::repeat(1.0)).amax() < 1e-14 && least > 0.0);
        }
    }

    #[test]
    fn squares_have_a_sixth_across_corners_and_cubes_a_sixth_across_edges() {
        assert!((edge_weights(&Vector::<2>::repeat(0.1))[0][1] - 1.0 / 6.0).abs() < 1e-15);
        assert!((edge_weights(&Vector::<3>::repeat(0.1))[0][2] - 0.1 / 6.0).abs() < 1e-16);
        assert!(edge_weights(&Vector::<2>::new(2.1, 1.0))[0][1] > 0.0);
        assert!(edge_weights(&Vector::<2>::new(2.3, 1.0))[0][1].abs() < 1e-300);
    }
}
