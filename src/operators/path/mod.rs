//! The path form of diffusion: bonds between cells that touch, with what lies between their points.
//!
//! A bond conducts c_ij κ_ij, where κ_ij = |ξ|/∫ds/κ is the mean along its path through the two cells: the
//! flux of layers in series is exact at every contrast. c_ij is the area of the face over the distance. On
//! lattices cells that meet at an edge are bonded as well (2/3 and 1/6 in the plane, 1/3 and 1/6 in space),
//! which makes the error isotropic; such a bond passes between two other cells, and takes part only as far
//! as all four are alike (see [`corner`]). All conductances are positive: the matrix is an M-matrix.

mod cells;
mod corner;
mod tensor;
mod tessellation;
mod voronoi;

use cells::CellFace;
pub(crate) use cells::{Arm, Cells, cell_faces, grid_families, runs_along_axes};
pub(crate) use tensor::PlaneTensor;
pub(crate) use tessellation::Tessellation;

use std::sync::Arc;

use self::corner::Corners;
use self::tensor::Tensors;
use super::bond_conductance::harmonic;
use super::{BondForm, Neighbourhood, OpenFace};
use crate::geometry::{Cloud, Families, GeometryError, Influence, Side, Vector};

/// Path diffusion operator.
#[derive(Debug, Clone)]
pub(crate) struct Path<const D: usize> {
    around: Arc<Neighbourhood<D>>,
    /// Conductance per unit mobility where all cells are alike: half of c_ij, since every bond is in the
    /// families of both its ends, shape `(bonds,)`, m^(D−2).
    geometric: Vec<f64>,
    /// From the owner to the middle of the face, m, shape `(bonds,)`.
    arm: Vec<Vector<D>>,
    /// Part of the bond in the owner's cell or material, shape `(bonds,)`; empty where it is always one half.
    share: Vec<f64>,
    corners: Corners,
    /// Where the permeability is a tensor; conductances are then its alone.
    tensors: Option<Tensors>,
    open: Vec<OpenFace<D>>,
}

impl<const D: usize> Path<D> {
    /// Makes the operator on the bonds between cells that touch, without those to images for which `keeps` is
    /// false. With `own_volume` scattered points get the volumes of their cells. `own_share` tells the part
    /// of a bond (owner, bond) in the material of its owner where that does not end at the face.
    ///
    /// # Errors
    /// As [`Families::search`](crate::geometry::Families::search).
    pub(crate) fn new(
        cloud: &Arc<Cloud<D>>,
        found: &Tessellation<D>,
        own_volume: bool,
        influence: Influence,
        keeps: impl Fn(u8) -> bool,
        own_share: impl Fn(usize, usize) -> Option<f64>,
    ) -> Result<Self, GeometryError> {
        let families = &found.families;
        let (mut geometric, mut arm, mut share) = (Vec::new(), Vec::new(), Vec::new());
        let mut steps = Vec::new();
        let mut open = Vec::new();
        let (mut counts, mut bonds) = (Vec::with_capacity(families.len()), Vec::new());
        for owner in 0..families.len() {
            let (before, start) = (bonds.len(), families.family(owner).start);
            for face in &found.cell(owner).faces {
                let bond = start + face.bond;
                let image = families.image(bond);
                if !keeps(image) {
                    open.extend(open_face(families, owner, bond, face));
                    continue;
                }
                bonds.push((families.neighbour(bond) as u32, image));
                geometric.push(0.5 * face.conductance);
                arm.push(face.arm);
                share.push(own_share(owner, bond).unwrap_or(face.share));
                steps.push(face.steps);
            }
            counts.push((bonds.len() - before) as u32);
        }
        let kept = families.with_bonds(counts, bonds)?;
        let cloud = match own_volume && found.kind == Cells::Scattered {
            false => cloud.clone(),
            true => Arc::new(Cloud {
                volume: found.volumes(),
                ..Cloud::clone(cloud)
            }),
        };
        let around = Arc::new(Neighbourhood::of_cells(cloud, Arc::new(kept), influence));
        if share.iter().all(|share| (share - 0.5).abs() < 1e-12) {
            share.clear();
        }
        let corners = match found.kind {
            Cells::Lattice => Corners::find(&around, &steps, &mut geometric),
            Cells::Oblique | Cells::Tensor | Cells::Scattered => Corners::default(),
        };
        Ok(Path {
            around,
            geometric,
            arm,
            share,
            corners,
            tensors: None,
            open,
        })
    }

    /// The same with a tensor per unit of the mobility of every point, shape `(n,)`. The cells must be
    /// [`Cells::Oblique`], in the plane, with images beyond all sides.
    #[must_use]
    pub(crate) fn with_tensors(mut self, tensors: &[PlaneTensor]) -> Self {
        self.tensors = Some(Tensors::new(&self.around, tensors));
        self.share.clear();
        self
    }

    /// Points with a bond of negative conductance, at mobilities of shape `(n,)`: pressures near them may leave the
    /// range of what they come from. Only strong tensors that are not along the axes have any.
    pub(crate) fn signed(&self, mobility: &[f64]) -> usize {
        let families = &self.around.families;
        let tensors = self.tensors.as_ref();
        tensors.map_or(0, |tensors| tensors.signed(families, mobility))
    }

    /// Mean mobility along a bond of `owner`.
    fn along(&self, bond: usize, own: f64, end: f64) -> f64 {
        match self.share.get(bond) {
            None => harmonic(own, end),
            Some(&share) => {
                let (small, large) = (own.min(end), own.max(end));
                let slow = if own < end { share } else { 1.0 - share };
                small / (slow + (1.0 - slow) * (small / large))
            }
        }
    }
}

/// The face that a bond to an image beyond a side stands for; none across edges.
fn open_face<const D: usize>(
    families: &Families<D>,
    owner: usize,
    bond: usize,
    face: &CellFace<D>,
) -> Option<OpenFace<D>> {
    let order = families.images.get(families.image(bond)).order;
    let axis = (0..D).find(|axis| order[*axis] != 0)?;
    (face.area > 0.0).then(|| OpenFace {
        point: owner as u32,
        side: Side {
            axis,
            upper: order[axis] > 0,
        },
        area: face.area,
        arm: face.arm,
    })
}

impl<const D: usize> BondForm<D> for Path<D> {
    fn name(&self) -> &'static str {
        "path"
    }

    fn neighbourhood(&self) -> &Neighbourhood<D> {
        &self.around
    }

    fn geometric(&self, _owner: usize, bond: usize) -> f64 {
        self.geometric[bond]
    }

    fn mean(&self, owner: f64, end: f64) -> f64 {
        harmonic(owner, end)
    }

    fn pairwise(&self) -> bool {
        self.corners.is_empty() && self.share.is_empty() && self.tensors.is_none()
    }

    fn conductances(&self, owner: usize, mobility: &[f64], conductances: &mut [f64]) {
        let families = &self.around.families;
        if let Some(tensors) = &self.tensors {
            return tensors.conductances(families, owner, mobility, conductances);
        }
        let family = families.family(owner);
        conductances.copy_from_slice(&self.geometric[family.clone()]);
        let end = |place: usize| mobility[families.neighbour(family.start + place)];
        self.corners
            .collapse(owner, mobility[owner], end, conductances);
        for (place, conductance) in conductances.iter_mut().enumerate() {
            *conductance *= self.along(family.start + place, mobility[owner], end(place));
        }
    }

    fn flux_is_carried(&self) -> bool {
        true
    }

    fn open_faces(&self) -> &[OpenFace<D>] {
        &self.open
    }

    /// (1/V) Σ F (x_face − x) over the faces of the cell. A family has half of what each carries.
    fn flux(&self, owner: usize, mobility: &[f64], difference: &dyn Fn(usize) -> f64) -> Vector<D> {
        let family = self.around.families.family(owner);
        let mut conductances = vec![0.0; family.len()];
        self.conductances(owner, mobility, &mut conductances);
        let carried = family.zip(conductances);
        let sum: Vector<D> = carried
            .map(|(bond, conductance)| self.arm[bond] * (-2.0 * conductance * difference(bond)))
            .sum();
        sum / self.around.cloud.volume[owner]
    }

    fn bytes(&self) -> usize {
        let faces = self.open.len() * size_of::<OpenFace<D>>();
        8 * (self.geometric.len() + D * self.arm.len() + self.share.len())
            + faces
            + self.corners.bytes()
            + self.tensors.as_ref().map_or(0, Tensors::bytes)
    }
}

#[cfg(test)]
mod tests;
