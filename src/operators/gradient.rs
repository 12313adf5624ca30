//! The nonlocal gradient (Eq. 57) and its adjoint at constants, the area vectors.

#[cfg(test)]
use super::MirrorContinuation;
use super::Neighbourhood;
use super::neighbourhood::of_bonds;
use crate::geometry::Vector;
use crate::parallel;

/// Weights of the gradient: (∇̃f)_i = Σ_b weight_b · (bond difference of f)_b.
#[derive(Debug, Clone)]
pub struct Gradient<const D: usize> {
    /// One vector per bond, shape `(bonds,)`, unit 1/m.
    pub weight: Vec<Vector<D>>,
}

impl<const D: usize> Gradient<D> {
    /// The plain weights ω V_j K⁻¹ ξ.
    pub fn plain(around: &Neighbourhood<D>) -> Self {
        Self::of(around, None)
    }

    /// The same, those of points that are alike to the last bit.
    pub fn repeated(around: &Neighbourhood<D>) -> Self {
        Self::of(around, around.families.alike(&around.cloud).as_deref())
    }

    fn of(around: &Neighbourhood<D>, alike: Option<&[u32]>) -> Self {
        let weight = of_bonds(&around.families, alike, |owner, bond| {
            plain_weight(around, owner, bond)
        });
        Gradient { weight }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        8 * D * self.weight.len()
    }
}

fn plain_weight<const D: usize>(around: &Neighbourhood<D>, owner: usize, bond: usize) -> Vector<D> {
    around.inverse_shape[owner] * around.bond_vector(owner, bond) * around.measure[bond]
}

/// Plain gradient of one family from its bond differences, without stored weights.
pub(crate) fn family_gradient<const D: usize>(
    around: &Neighbourhood<D>,
    owner: usize,
    difference: impl Fn(usize) -> f64,
) -> Vector<D> {
    let mut sum = Vector::zeros();
    for bond in around.families.family(owner) {
        sum += around.bond_vector(owner, bond) * (around.measure[bond] * difference(bond));
    }
    around.inverse_shape[owner] * sum
}

/// Area vectors a_j = Σ_i V_i ∂(∇̃f)_i/∂f_j of a field with the given continuation, shape `(n,)`,
/// unit m^(D−1).
///
/// Zero inside a uniform cloud; in the layer at a one-sided boundary they add up to the outward
/// area of the boundary, so that a uniform flux or stress is balanced exactly.
#[cfg(test)]
fn area_vectors<const D: usize>(
    around: &Neighbourhood<D>,
    gradient: &Gradient<D>,
    extension: &MirrorContinuation<D>,
) -> Vec<Vector<D>> {
    let sign = |_: usize, bond: usize| extension.sign(around.families.image(bond));
    column_sums(around, |axis, bond| gradient.weight[bond][axis], sign)
}

/// Column sums Σ_i V_i ∂g_i/∂f_j of a gradient with the given `weight(axis, bond)`, for a field whose
/// images carry `sign(axis, bond)`; shape `(n,)`, unit m^(D−1).
pub(crate) fn column_sums<const D: usize>(
    around: &Neighbourhood<D>,
    weight: impl Fn(usize, usize) -> f64 + Sync,
    sign: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<Vector<D>> {
    let families = &around.families;
    let volume = &around.cloud.volume;
    let sums: Vec<Vector<D>> = parallel::map(around.len(), |point| {
        let mut sum = Vector::zeros();
        for axis in 0..D {
            let own: f64 = families.family(point).map(|bond| weight(axis, bond)).sum();
            sum[axis] = -volume[point] * own;
            for (owner, bond) in families.dual(point) {
                sum[axis] += volume[owner] * sign(axis, bond) * weight(axis, bond);
            }
        }
        sum
    });
    if families.share.partition().is_none() {
        return sums;
    }
    let mut flat: Vec<f64> = sums.iter().flat_map(|sum| sum.iter().copied()).collect();
    families.share.complete(&mut flat, D);
    flat.chunks_exact(D)
        .map(Vector::from_column_slice)
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::generate::lattice;
    use crate::geometry::{Families, Horizon, Influence, Side, horizons};
    use crate::operators::Parity;

    /// Area vectors of a 12 × 8 lattice whose left side is one-sided for the field.
    #[test]
    fn area_vectors_vanish_inside_and_add_up_to_a_one_sided_face() {
        let cloud = lattice(Vector::<2>::zeros(), Vector::<2>::new(1.2, 0.8), [12, 8]).unwrap();
        let horizon = horizons(&cloud, Horizon::Neighbours(15)).unwrap();
        let families = Families::search(&cloud, horizon).unwrap();
        let planes: Vec<f64> = Side::all(2).map(|side| cloud.domain.plane(side)).collect();
        let parity = [Parity::OneSided, Parity::Odd, Parity::Even, Parity::Even];
        let extension = MirrorContinuation::new(&families.images, &parity, &planes);
        let families = families
            .retain_images(|image| extension.keeps(image))
            .unwrap();
        let (cloud, families) = (Arc::new(cloud), Arc::new(families));
        let around = Neighbourhood::new(cloud, families, Influence::default()).unwrap();
        let areas = area_vectors(&around, &Gradient::plain(&around), &extension);
        let total: f64 = areas.iter().map(|area| area[0]).sum();
        assert!(
            (total + 0.8).abs() < 1e-12,
            "outward through the left side: {total}"
        );
        for (area, x) in areas.iter().zip(&around.cloud.position) {
            assert!(x[0] < 0.5 || area[0].abs() < 1e-13, "{area} at {x}");
        }
    }
}
