//! The operator applied without a matrix: bond forces and what crosses the prescribed sides.
//!
//! Slower than a product with the assembled matrix; used at set-up, for boundary fluxes, and as the
//! oracle in tests.

use crate::geometry::Side;
use crate::operators::{BondForm, MirrorContinuation};
use crate::parallel;

/// Forces A_i d of the bonds of one family, written to `forces`.
pub(crate) fn bond_force<const D: usize, F: BondForm<D>>(
    form: &F,
    owner: usize,
    mobility: &[f64],
    differences: &[f64],
    forces: &mut Vec<f64>,
) {
    let family = form.neighbourhood().families.family(owner);
    forces.clear();
    forces.resize(family.len(), 0.0);
    form.conductances(owner, mobility, forces);
    forces
        .iter_mut()
        .zip(differences)
        .for_each(|(f, d)| *f *= d);
    for term in form.coupling(owner, mobility).into_iter().flatten() {
        let sum: crate::geometry::Vector<D> = term
            .weight
            .iter()
            .zip(differences)
            .map(|(w, d)| w * *d)
            .sum();
        let flux = term.stiffness * sum;
        for (force, weight) in forces.iter_mut().zip(term.weight) {
            *force += flux.dot(weight);
        }
    }
}

/// Derivative of the operator's energy with respect to every value, shape `(n,)`, where
/// `difference(owner, bond)` is the bond difference of the field, wall values included.
pub(crate) fn force<const D: usize, F: BondForm<D>>(
    form: &F,
    extension: &MirrorContinuation<D>,
    mobility: &[f64],
    difference: &(dyn Fn(usize, usize) -> f64 + Sync),
) -> Vec<f64> {
    let families = &form.neighbourhood().families;
    let per_bond: Vec<f64> = parallel::gather(families.len(), |owner, all| {
        let differences: Vec<f64> = families
            .family(owner)
            .map(|b| difference(owner, b))
            .collect();
        let mut forces = Vec::with_capacity(differences.len());
        bond_force(form, owner, mobility, &differences, &mut forces);
        all.append(&mut forces);
    });
    let mut sums: Vec<f64> = parallel::map(families.len(), |point| {
        let own: f64 = per_bond[families.family(point)].iter().sum();
        let dual: f64 = families
            .dual(point)
            .map(|(_, bond)| extension.sign(families.image(bond)) * per_bond[bond])
            .sum();
        dual - own
    });
    families.share.complete(&mut sums, 1);
    sums
}

/// Points of this process with bonds that leave through a side of prescribed value, in increasing order.
pub(crate) fn outlets<const D: usize, F: BondForm<D>>(
    form: &F,
    extension: &MirrorContinuation<D>,
) -> Vec<u32> {
    let families = &form.neighbourhood().families;
    (0..families.len())
        .filter(|&owner| families.share.owns(owner))
        .filter(|&owner| {
            families
                .family(owner)
                .any(|bond| extension.outlet(families.image(bond)).is_some())
        })
        .map(|owner| owner as u32)
        .collect()
}

/// Rate at which the field's flux leaves through every side, in the order of [`Side::index`].
///
/// `owners` comes from [`outlets`]; a bond with force F whose end changes sign takes 2F out.
pub(crate) fn outflow<const D: usize, F: BondForm<D>>(
    form: &F,
    extension: &MirrorContinuation<D>,
    owners: &[u32],
    mobility: &[f64],
    difference: &dyn Fn(usize, usize) -> f64,
) -> Vec<f64> {
    let families = &form.neighbourhood().families;
    let mut rates = vec![0.0; 2 * D];
    let (mut differences, mut forces) = (Vec::new(), Vec::new());
    for &owner in owners {
        let owner = owner as usize;
        differences.clear();
        differences.extend(families.family(owner).map(|bond| difference(owner, bond)));
        bond_force(form, owner, mobility, &differences, &mut forces);
        for (bond, force) in families.family(owner).zip(&forces) {
            if let Some(side) = extension.outlet(families.image(bond)) {
                rates[Side::index(side)] -= 2.0 * force;
            }
        }
    }
    families.share.sum(&mut rates);
    rates
}
