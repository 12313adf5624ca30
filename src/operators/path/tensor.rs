//! Full permeability tensors on a lattice in the plane: four cells around a corner, as one square of bonds.
//!
//! The squares between four points fill the plane. In each of them six bonds carry what the tensor there
//! does to any linear pressure: with the effective tensor K of the four cells the diagonals take (D ± K_xy)/2, the
//! edges what is left of K_xx and K_yy. Every node then has the force of the bilinear finite element, so that uniform
//! flow and flow in layers along an axis are exact, whatever D; D is that of the isotropic operator where it
//! may be (see [`Square::new`]). Beyond a side the cells are mirrored, their K_xy with them: the sealed side of an
//! oblique rock is a layered rock, of which the square takes the right mean.

use super::super::Neighbourhood;
use crate::geometry::Families;

/// A symmetric tensor in the plane: xx, yy, xy.
pub(crate) type PlaneTensor = [f64; 3];

/// Steps to the cells around one, and the number of each in [`Tensors::around`].
const RING: [[i8; 2]; 8] = [
    [1, 0],
    [1, 1],
    [0, 1],
    [-1, 1],
    [-1, 0],
    [-1, -1],
    [0, -1],
    [1, -1],
];

/// Marks a cell that is not there.
const NONE: u8 = u8::MAX;

/// Tensors of all cells.
#[derive(Debug, Clone)]
pub(super) struct Tensors {
    /// Tensor per unit of the mobility of the point, in a frame in which cells are squares, shape `(n,)`.
    shape: Vec<PlaneTensor>,
    /// Place in the family of the cells around each, in the order of [`RING`], shape `(n,)`.
    around: Vec<[u8; 8]>,
}

/// What conducts in the square between four points: own, along x, along y, across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Square {
    /// From the own point along x, between the other two along x, and both along y.
    pub edges: [f64; 4],
    /// From the own point across, and between the other two.
    pub diagonals: [f64; 2],
}

/// Share of the weakest edge that diagonals may take; with all of it an edge has nothing left. The isotropic
/// operator takes a third.
const MOST: f64 = 0.95;

fn harmonic_mean(a: f64, b: f64) -> f64 {
    2.0 / (1.0 / a + 1.0 / b)
}

fn difference(a: &PlaneTensor, b: &PlaneTensor) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + 2.0 * (a[2] - b[2]).powi(2)
}

/// Means of pairs of cells that follow each other along one axis.
struct Layers {
    /// Normal conductivity of the two pairs.
    normal: [f64; 2],
    /// Effective xy component, and what it adds to the tangential conductivity.
    cross: f64,
    added: f64,
}

impl Layers {
    /// Of two pairs along axis `n` (Backus 1962 for conduction): flux across layers and slope along them are
    /// continuous.
    fn new(pairs: [[&PlaneTensor; 2]; 2], n: usize) -> Self {
        let normal = pairs.map(|[a, b]| harmonic_mean(a[n], b[n]));
        let tilt = pairs.map(|[a, b]| 0.5 * (a[2] / a[n] + b[2] / b[n]));
        Layers {
            cross: 0.5 * (normal[0] * tilt[0] + normal[1] * tilt[1]),
            added: 0.5 * (normal[0] * tilt[0].powi(2) + normal[1] * tilt[1].powi(2)),
            normal,
        }
    }
}

/// Conductivity along axis `t` where nothing flows across it.
fn held(tensor: &PlaneTensor, t: usize) -> f64 {
    tensor[t] - tensor[2].powi(2) / tensor[1 - t]
}

impl Square {
    /// Of four tensors: own, next along x, next along y, across.
    ///
    /// Where the cells lie in layers along an axis their effective tensor is exact. Elsewhere, at corners of
    /// regions, the two means of layers are blended by the differences along x and y, and K_xy is kept to what
    /// leaves all bonds positive.
    pub(super) fn new([own, along, up, across]: [PlaneTensor; 4]) -> Self {
        let change = [
            difference(&own, &along) + difference(&up, &across),
            difference(&own, &up) + difference(&along, &across),
        ];
        let layered = change[0].min(change[1]) <= 0.0;
        let sum = change[0] + change[1];
        let x = if sum > 0.0 { change[0] / sum } else { 0.5 };
        let y = 1.0 - x;
        let in_x = Layers::new([[&own, &along], [&up, &across]], 0);
        let in_y = Layers::new([[&own, &up], [&along, &across]], 1);
        let tangential = |a, b, t: usize, added| harmonic_mean(held(a, t), held(b, t)) + added;
        let edges = [
            x * in_x.normal[0] + y * tangential(&own, &along, 0, in_y.added),
            x * in_x.normal[1] + y * tangential(&up, &across, 0, in_y.added),
            y * in_y.normal[0] + x * tangential(&own, &up, 1, in_x.added),
            y * in_y.normal[1] + x * tangential(&along, &across, 1, in_x.added),
        ];
        let weakest = MOST * edges.iter().copied().fold(f64::INFINITY, f64::min);
        let mut cross = x * in_x.cross + y * in_y.cross;
        if !layered {
            cross = cross.clamp(-weakest, weakest);
        }
        let traces = [own, along, up, across].map(|tensor| tensor[0] + tensor[1]);
        let most = traces.iter().copied().fold(0.0, f64::max);
        let alike = (traces.iter().copied().fold(most, f64::min) / most).powi(2);
        // A third of the mean edge, as 1/6 a corner of the isotropic operator.
        let usual = alike * edges.iter().sum::<f64>() / 12.0;
        let diagonal = usual.min(weakest).max(cross.abs());
        Square {
            edges: edges.map(|edge| 0.5 * (edge - diagonal)),
            diagonals: [0.5 * (diagonal + cross), 0.5 * (diagonal - cross)],
        }
    }

    /// Whether a bond has a negative conductance, so that pressures may leave the range of the sides'.
    fn is_signed(&self) -> bool {
        let least = self.edges.iter().copied().fold(f64::INFINITY, f64::min);
        least < 0.0
    }
}

impl Tensors {
    /// Of the tensors of all points per unit of their mobility, on families that hold all cells around.
    pub(super) fn new<const D: usize>(around: &Neighbourhood<D>, tensors: &[PlaneTensor]) -> Self {
        let families = &around.families;
        let places = |owner: usize| {
            let mut places = [NONE; 8];
            let edges = around.cloud.cell[owner];
            for (place, bond) in families.family(owner).enumerate() {
                let xi = around.bond_vector(owner, bond);
                let step = [0, 1].map(|axis| (xi[axis] / edges[axis]).round() as i8);
                if let Some(number) = RING.iter().position(|own| *own == step) {
                    places[number] = place as u8;
                }
            }
            places
        };
        let aspect = |owner: usize| {
            let edges = around.cloud.cell[owner];
            edges[1] / edges[0]
        };
        let shape = |(owner, [xx, yy, xy]): (usize, &PlaneTensor)| {
            [xx * aspect(owner), yy / aspect(owner), *xy]
        };
        Tensors {
            shape: tensors.iter().enumerate().map(shape).collect(),
            around: (0..around.len()).map(places).collect(),
        }
    }

    /// The tensor at the end of a bond, m²/(Pa s), seen through the mirrors between.
    fn end<const D: usize>(
        &self,
        families: &Families<D>,
        bond: usize,
        mobility: &[f64],
    ) -> PlaneTensor {
        let end = families.neighbour(bond);
        let order = families.images.get(families.image(bond)).order;
        let turned = order.iter().sum::<i32>() % 2 != 0;
        let [xx, yy, xy] = self.shape[end].map(|own| own * mobility[end]);
        [xx, yy, if turned { -xy } else { xy }]
    }

    /// Calls `visit(places along x, along y, across; square)` for the four squares around a point.
    fn each_square<const D: usize>(
        &self,
        families: &Families<D>,
        owner: usize,
        mobility: &[f64],
        mut visit: impl FnMut([usize; 3], Square),
    ) {
        let start = families.family(owner).start;
        let own = self.shape[owner].map(|own| own * mobility[owner]);
        for (first, sign) in [(0, 1.0), (2, -1.0), (4, 1.0), (6, -1.0)] {
            // Around the corner from one face to the next; the first of an odd quarter is along y.
            let ring = [first, first + 1, (first + 2) % 8].map(|k| self.around[owner][k]);
            if ring.contains(&NONE) {
                continue;
            }
            let [near, across, far] = ring.map(usize::from);
            let (along, up) = match sign > 0.0 {
                true => (near, far),
                false => (far, near),
            };
            let facing = |[xx, yy, xy]: PlaneTensor| [xx, yy, sign * xy];
            let end = |place: usize| facing(self.end(families, start + place, mobility));
            let square = Square::new([facing(own), end(along), end(up), end(across)]);
            visit([along, up, across], square);
        }
    }

    /// Conductances of the bonds of `owner`, half of what their two directions carry together.
    pub(super) fn conductances<const D: usize>(
        &self,
        families: &Families<D>,
        owner: usize,
        mobility: &[f64],
        conductances: &mut [f64],
    ) {
        conductances.fill(0.0);
        self.each_square(families, owner, mobility, |[along, up, across], square| {
            conductances[along] += 0.5 * square.edges[0];
            conductances[up] += 0.5 * square.edges[2];
            conductances[across] += 0.5 * square.diagonals[0];
        });
    }

    /// Points with a bond of negative conductance.
    pub(super) fn signed<const D: usize>(&self, families: &Families<D>, mobility: &[f64]) -> usize {
        let is_signed = |owner: &usize| {
            let mut found = false;
            self.each_square(families, *owner, mobility, |_, square| {
                found |= square.is_signed();
            });
            found
        };
        (0..self.shape.len()).filter(is_signed).count()
    }

    pub(super) fn bytes(&self) -> usize {
        (size_of::<PlaneTensor>() + 8) * self.shape.len()
    }
}

#[cfg(test)]
#[path = "tensor_tests.rs"]
mod tests;
