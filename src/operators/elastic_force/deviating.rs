//! Families that are not those of a stencil: forces of their bonds one by one, and the points that see them.

use super::Work;
use super::lattice::LatticeForce;
use crate::geometry::Vector;
use crate::operators::Elastic;
use crate::parallel::{self, TASK, by_ranges};

/// Families whose bonds have forces of their own.
#[derive(Debug, Clone)]
pub(super) struct Deviating {
    /// Whose families they are, in increasing order.
    owners: Vec<u32>,
    /// Start of their bonds among those of all of them, shape `(owners + 1,)`.
    offsets: Vec<u32>,
    /// Place in `owners` per point, shape `(n,)`; `NONE` for families of the stencil.
    place: Vec<u32>,
    /// Points in whose families or dual families a family deviates, in increasing order.
    near: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Deviating {
    /// All families but those of the stencil.
    pub(crate) fn new<const D: usize>(
        elastic: &Elastic<D>,
        lattice: Option<&LatticeForce<D>>,
    ) -> Self {
        let families = &elastic.around.families;
        let deviates = |point: usize| lattice.is_none_or(|own| !own.regular[point]);
        let mut own = Deviating {
            owners: Vec::new(),
            offsets: vec![0],
            place: vec![NONE; elastic.points()],
            near: Vec::new(),
        };
        let mut bonds = 0;
        for point in (0..elastic.points()).filter(|point| deviates(*point)) {
            own.place[point] = own.owners.len() as u32;
            own.owners.push(point as u32);
            bonds += families.family(point).len() as u32;
            own.offsets.push(bonds);
        }
        let sees = |point: usize| {
            deviates(point) || families.dual(point).any(|(owner, _)| deviates(owner))
        };
        own.near = (0..elastic.points())
            .filter(|point| sees(*point))
            .map(|point| point as u32)
            .collect();
        own
    }

    /// Whether all families are those of a stencil.
    pub(crate) fn is_empty(&self) -> bool {
        self.owners.is_empty()
    }

    /// Room for the forces of all bonds.
    pub(crate) fn prepare<const D: usize>(&self, work: &mut Work<D>) {
        let bonds = self.offsets.last().map_or(0, |last| *last as usize);
        work.forces = vec![Vector::zeros(); bonds];
        work.near = vec![Vector::zeros(); self.near.len()];
    }

    /// First pass: forces of all bonds, N.
    pub(crate) fn first_pass<const D: usize>(
        &self,
        elastic: &Elastic<D>,
        displacement: &[f64],
        work: &mut Work<D>,
    ) {
        by_ranges(&self.offsets, &mut work.forces, |place, forces| {
            let owner = self.owners[place] as usize;
            elastic.family_response(
                owner,
                |bond| elastic.difference(displacement, owner, bond),
                |strain, _| (elastic.stress(owner, strain), 1.0),
                forces,
            );
        });
    }

    /// Second pass: K u of the points that see such families.
    pub(crate) fn second_pass<const D: usize>(
        &self,
        elastic: &Elastic<D>,
        lattice: Option<&LatticeForce<D>>,
        displacement: &[f64],
        work: &mut Work<D>,
        result: &mut [f64],
    ) {
        let families = &elastic.around.families;
        let (forces, stress) = (&work.forces, &work.stress);
        let force = |owner: usize, bond: usize| match (self.place[owner], lattice) {
            (NONE, Some(lattice)) => {
                lattice.bond_force(elastic, (stress, displacement), owner, bond)
            }
            (place, _) => {
                let first = self.offsets[place as usize] as usize;
                forces[first + bond - families.family(owner).start]
            }
        };
        let at = |number: usize, sum: &mut Vector<D>| {
            let point = self.near[number] as usize;
            let own = families.family(point).map(|bond| force(point, bond));
            let own: Vector<D> = own.sum();
            let dual = families.dual(point);
            let dual = dual.map(|(owner, bond)| elastic.signed(bond, force(owner, bond)));
            *sum = dual.sum::<Vector<D>>() - own;
        };
        parallel::each(&mut work.near, TASK, at);
        for (point, sum) in self.near.iter().zip(&work.near) {
            let first = D * *point as usize;
            result[first..first + D].copy_from_slice(sum.as_slice());
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        4 * (self.owners.len() + self.offsets.len() + self.place.len() + self.near.len())
    }
}
