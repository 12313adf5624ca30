//! Faces of cracks: what cutting bonds adds to the column sums of the gradient.

use super::Neighbourhood;
use crate::geometry::{Matrix, Severed, Vector};

/// What the cuts of cracks (by number) add to the column sums Σ_i V_i ∂g_i/∂f_j of the plain gradient,
/// for a field whose images carry `sign(axis, image)`; shape `(n,)`, unit m^(D−1).
///
/// These are the area vectors of the faces, out of the body and spread over the points that lost bonds.
/// A uniform stress σ is in equilibrium with the forces σ a on them to rounding error, as it is with
/// tractions on the area vectors of sides. `None` without cracks.
pub(crate) fn face_areas<const D: usize>(
    around: &Neighbourhood<D>,
    cracks: std::ops::Range<u16>,
    sign: impl Fn(usize, u8) -> f64,
) -> Option<Vec<Vector<D>>> {
    let families = &around.families;
    let severed = families.severed.as_ref()?;
    let mut areas = vec![Vector::zeros(); around.len()];
    for severed in severed.chunk_by(|a, b| a.owner == b.owner) {
        if !severed.iter().any(|bond| cracks.contains(&bond.crack)) {
            continue;
        }
        let owner = severed[0].owner as usize;
        let volume = around.cloud.volume[owner];
        // Bonds that later cracks cut are there before and after: they are those cracks' business.
        let before = weights(around, severed, cracks.start);
        let after = weights(around, severed, cracks.end);
        let changes = before.into_iter().map(|bond| (bond, -volume));
        for (bond, factor) in changes.chain(after.into_iter().map(|bond| (bond, volume))) {
            let signs: Vector<D> = Vector::from_fn(|axis, _| sign(axis, bond.image));
            let change = bond.weight * factor;
            areas[bond.end] += signs.component_mul(&change);
            areas[owner] -= change;
        }
    }
    if families.share.partition().is_some() {
        let components = areas
            .iter()
            .flat_map(|area: &Vector<D>| area.iter().copied());
        let mut flat: Vec<f64> = components.collect();
        families.share.complete(&mut flat, D);
        areas = flat
            .chunks_exact(D)
            .map(Vector::from_column_slice)
            .collect();
    }
    Some(areas)
}

/// A bond and its weight in the gradient.
struct Weighed<const D: usize> {
    end: usize,
    image: u8,
    weight: Vector<D>,
}

/// Plain weights of a family that still has the bonds which cracks from number `first` on cut.
fn weights<const D: usize>(
    around: &Neighbourhood<D>,
    severed: &[Severed],
    first: u16,
) -> Vec<Weighed<D>> {
    let (families, cloud) = (&around.families, &around.cloud);
    let owner = severed[0].owner as usize;
    let kept = families.family(owner);
    let kept = kept.map(|bond| (families.neighbour(bond), families.image(bond)));
    let restored = severed.iter().filter(|bond| bond.crack >= first);
    let restored = restored.map(|bond| (bond.neighbour as usize, bond.image));
    let mut shape = Matrix::<D>::zeros();
    let mut bonds = Vec::new();
    for (end, image) in kept.chain(restored) {
        let place = families.images.get(image).place(&cloud.position[end]);
        let xi = place - cloud.position[owner];
        let weight = xi * around.weigh(owner, end, &xi);
        shape += weight * xi.transpose();
        bonds.push(Weighed { end, image, weight });
    }
    // No fewer bonds than the family has, whose shape tensor has an inverse.
    let inverse = shape.try_inverse().unwrap_or_else(Matrix::zeros);
    bonds
        .iter_mut()
        .for_each(|bond| bond.weight = inverse * bond.weight);
    bonds
}
