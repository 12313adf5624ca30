//! What acts on bonds: shape tensors, gradients, hourglass terms, bond conductances.
//!
//! A scalar diffusion operator is a sum of local quadratic forms, one per family. With the bond
//! differences d of the family of point i the energy is ½ dᵀ A_i d, and every form here is
//!
//!   A_i = diag(conductance) + Wᵀ M W (+ Uᵀ N U),
//!
//! W and U holding one `D`-vector per bond. Forms without the coupling terms reach one hop, forms
//! with them two. Because the dual sum is the transpose of the family sum (Eq. 2), adding up these
//! forms gives a symmetric matrix.

mod bond_conductance;
mod correspondence;
mod crossings;
mod damage;
mod divergence;
mod elastic;
mod elastic_force;
mod extension;
mod faces;
mod family_width;
mod gradient;
mod hourglass;
mod laminate;
mod neighbourhood;
mod path;

pub(crate) use bond_conductance::BondConductance;
pub(crate) use correspondence::Correspondence;
pub(crate) use crossings::{Crossings, cells_along};
pub(crate) use damage::{Damage, DamageFields, Response};
pub(crate) use divergence::Divergence;
pub(crate) use elastic::{Elastic, point_value};
pub(crate) use elastic_force::{ElasticForce, diagonal};
pub(crate) use extension::{MirrorContinuation, Parity};
pub(crate) use faces::face_areas;
pub(crate) use family_width::{BandLaw, FamilyWidths, WholeFamily, WidthRange};
pub(crate) use gradient::{Gradient, column_sums, family_gradient};
pub(crate) use hourglass::Hourglass;
pub(crate) use laminate::{Laminate, Layered, Layers};
pub(crate) use neighbourhood::Neighbourhood;
pub(crate) use path::{
    Arm, Cells, Path, PlaneTensor, Tessellation, cell_faces, grid_families, runs_along_axes,
};

pub(crate) use crate::material::Lame;

use crate::geometry::{Matrix, Side, Vector};

/// One term Wᵀ M W that couples all bonds of a family.
#[derive(Debug, Clone, Copy)]
pub struct Coupling<'a, const D: usize> {
    /// M, symmetric.
    pub stiffness: Matrix<D>,
    /// Columns of W, one per bond of the family.
    pub weight: &'a [Vector<D>],
}

/// Face of a point's cell on a side of the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenFace<const D: usize> {
    /// The point.
    pub point: u32,
    /// The side.
    pub side: Side,
    /// Area, m^(D−1).
    pub area: f64,
    /// From the point to the middle of the face, m.
    pub arm: Vector<D>,
}

/// Local quadratic forms of a diffusion operator; linear or harmonic in the mobility.
pub trait BondForm<const D: usize>: Send + Sync {
    /// Name in scenes and reports.
    fn name(&self) -> &'static str;

    /// The families the form lives on.
    fn neighbourhood(&self) -> &Neighbourhood<D>;

    /// Geometric factor of one bond of `owner`: its conductance for unit mobility, m^(D−2).
    fn geometric(&self, owner: usize, bond: usize) -> f64;

    /// Mobility of a bond from those of its owner and of its end, m²/(Pa s).
    fn mean(&self, owner: f64, end: f64) -> f64;

    /// Whether a bond's conductance is its geometric factor times the mean over its two ends, so that
    /// nothing else between them counts.
    fn pairwise(&self) -> bool {
        true
    }

    /// Diagonal entries of A for the bonds of `owner`, in the order of its family; `mobility` is K/μ
    /// per point in m²/(Pa s).
    fn conductances(&self, owner: usize, mobility: &[f64], conductances: &mut [f64]) {
        let families = &self.neighbourhood().families;
        for (bond, conductance) in families.family(owner).zip(conductances) {
            let mean = self.mean(mobility[owner], mobility[families.neighbour(bond)]);
            *conductance = self.geometric(owner, bond) * mean;
        }
    }

    /// Whether the family of `owner` has coupling terms, that is a second hop.
    fn couples(&self, _owner: usize) -> bool {
        false
    }

    /// The coupling terms of the family of `owner`; `None` where [`BondForm::couples`] is false.
    fn coupling(&self, _owner: usize, _mobility: &[f64]) -> [Option<Coupling<'_, D>>; 2] {
        [None, None]
    }

    /// Whether [`BondForm::flux`] is the mean of what the faces of a point's cell carry, right beside
    /// jumps of the mobility too.
    fn flux_is_carried(&self) -> bool {
        false
    }

    /// Faces of cells on sides without images, which no bond stands for.
    fn open_faces(&self) -> &[OpenFace<D>] {
        &[]
    }

    /// Flux −κ∇̃p of one family from its bond differences, m/s.
    fn flux(&self, owner: usize, mobility: &[f64], difference: &dyn Fn(usize) -> f64) -> Vector<D> {
        family_gradient(self.neighbourhood(), owner, difference) * -mobility[owner]
    }

    /// Bytes held beyond the neighbourhood.
    fn bytes(&self) -> usize;
}
