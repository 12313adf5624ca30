//! Where bonds leave the region of one material for that of another.

use crate::geometry::{Cloud, Families, Vector};
use crate::plan::Plan;

use super::properties::material_at;

/// Halvings that find where a bond leaves a region, to the last bit of its length.
const HALVINGS: usize = 53;

/// The regions of a plan's materials along the bonds of a cloud.
pub(super) struct Interfaces<'a, const D: usize> {
    pub(super) plan: &'a Plan,
    pub(super) cloud: &'a Cloud<D>,
    pub(super) families: &'a Families<D>,
    /// Material per point.
    pub(super) material: &'a [u16],
}

impl<const D: usize> Interfaces<'_, D> {
    /// Part of a bond in the material of its owner; `None` where both ends are of one material, and where
    /// materials have no regions.
    pub(super) fn share(&self, owner: usize, bond: usize) -> Option<f64> {
        let own = self.material[owner];
        if self.material[self.families.neighbour(bond)] == own {
            return None;
        }
        let xi = self.families.bond_vector(self.cloud, owner, bond);
        let image = self.families.images.get(self.families.image(bond));
        let holds = |share: f64| {
            let x: Vector<D> = self.cloud.position[owner] + xi * share;
            let domain = &self.cloud.domain;
            let inside = x >= domain.lower && x <= domain.upper;
            let x = if inside { x } else { image.inverse(&x) };
            material_at(self.plan, &x) == Some(own)
        };
        if !holds(0.0) || holds(1.0) {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match holds(middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        Some(0.5 * (low + high))
    }
}
