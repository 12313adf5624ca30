//! The bond form of diffusion: one conductance per bond with the harmonic mean of the mobilities.
//!
//! C_ij = (D/m_i) ω V_i V_j · 2κ_iκ_j/(κ_i + κ_j) reaches one hop, gives an M-matrix (no over- or
//! undershoot), and carries the flux of layers in series where the correspondence form behaves like
//! an arithmetic mean. On families that are not isotropic D/m_i becomes ξ̂ᵀ B_i ξ̂ with B_i such that
//! Σ_j w_ij ξ⊗ξ V_j = I, as long as that keeps all weights positive.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::{BondForm, Neighbourhood};
use crate::geometry::{Matrix, Vector};
use crate::parallel;

/// Bond diffusion operator.
#[derive(Debug, Clone)]
pub(crate) struct BondConductance<const D: usize> {
    around: Arc<Neighbourhood<D>>,
    /// Conductance per unit mobility, shape `(bonds,)`.
    geometric: Vec<f64>,
    uncorrected: usize,
}

impl<const D: usize> BondConductance<D> {
    /// Weighs all bonds.
    pub(crate) fn new(around: Arc<Neighbourhood<D>>) -> Self {
        let families: Vec<(Vec<f64>, bool)> =
            parallel::map(around.len(), |owner| family_weights(&around, owner));
        let uncorrected = families
            .iter()
            .filter(|(_, second_moment)| !second_moment)
            .count();
        let geometric = families
            .into_iter()
            .flat_map(|(weights, _)| weights)
            .collect();
        BondConductance {
            around,
            geometric,
            uncorrected,
        }
    }

    /// Points whose second moment could not be made exact with positive weights.
    pub(crate) fn uncorrected(&self) -> usize {
        self.uncorrected
    }
}

/// Smallest accepted ratio of a corrected weight to the plain one.
const POSITIVE: f64 = 0.05;

/// Conductances of one family per unit mobility, and whether their second moment is exact.
fn family_weights<const D: usize>(around: &Neighbourhood<D>, owner: usize) -> (Vec<f64>, bool) {
    let volume = around.cloud.volume[owner];
    let plain = D as f64 / around.moment[owner];
    let scaled = around.shape(owner) * plain - Matrix::identity();
    let uniform = || {
        around
            .families
            .family(owner)
            .map(|b| volume * around.measure[b] * plain)
            .collect()
    };
    if scaled.amax() < 1e-11 || !around.families.share.holds(owner) {
        return (uniform(), true);
    }
    let Some(tensor) = second_moment_tensor(around, owner) else {
        return (uniform(), false);
    };
    let weight = |bond: usize| {
        let direction = around.bond_vector(owner, bond).normalize();
        direction.dot(&(tensor * direction))
    };
    let weights: Vec<f64> = around.families.family(owner).map(weight).collect();
    if weights.iter().any(|&w| w < POSITIVE * plain) {
        return (uniform(), false);
    }
    let bonds = around.families.family(owner);
    (
        bonds
            .zip(weights)
            .map(|(b, w)| volume * around.measure[b] * w)
            .collect(),
        true,
    )
}

/// B with Σ_b ω V_j (ξ̂ᵀ B ξ̂) ξ⊗ξ = I.
fn second_moment_tensor<const D: usize>(
    around: &Neighbourhood<D>,
    owner: usize,
) -> Option<Matrix<D>> {
    let pairs: Vec<(usize, usize)> = (0..D).flat_map(|a| (a..D).map(move |b| (a, b))).collect();
    let mut system = DMatrix::zeros(pairs.len(), pairs.len());
    for bond in around.families.family(owner) {
        let xi: Vector<D> = around.bond_vector(owner, bond);
        let scale = around.measure[bond] / xi.norm_squared();
        for (row, &(a, b)) in pairs.iter().enumerate() {
            for (column, &(c, d)) in pairs.iter().enumerate() {
                let both = if c == d { 1.0 } else { 2.0 };
                system[(row, column)] += scale * xi[a] * xi[b] * both * xi[c] * xi[d];
            }
        }
    }
    let unit = DVector::from_iterator(pairs.len(), pairs.iter().map(|&(a, b)| f64::from(a == b)));
    let solution = system.lu().solve(&unit)?;
    let mut tensor = Matrix::zeros();
    for (&(a, b), &value) in pairs.iter().zip(solution.iter()) {
        tensor[(a, b)] = value;
        tensor[(b, a)] = value;
    }
    Some(tensor)
}

/// Harmonic mean of two mobilities.
pub(super) fn harmonic(a: f64, b: f64) -> f64 {
    // Divide by the larger one first: the product of two tiny mobilities underflows.
    let (small, large) = (a.min(b), a.max(b));
    2.0 * small / (1.0 + small / large)
}

impl<const D: usize> BondForm<D> for BondConductance<D> {
    fn name(&self) -> &'static str {
        "bond"
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

    /// Sum over the bonds of what each carries: the flux is continuous across jumps of the mobility.
    fn flux(&self, owner: usize, mobility: &[f64], difference: &dyn Fn(usize) -> f64) -> Vector<D> {
        let mut sum = Vector::zeros();
        let families = &self.around.families;
        for bond in families.family(owner) {
            let mean = self.mean(mobility[owner], mobility[families.neighbour(bond)]);
            let carried = self.geometric[bond] * mean * difference(bond);
            sum -= self.around.bond_vector(owner, bond) * carried;
        }
        sum / self.around.cloud.volume[owner]
    }

    fn bytes(&self) -> usize {
        8 * self.geometric.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::{jitter, lattice};
    use crate::geometry::{Families, Horizon, Influence, horizons};

    fn jittered(amount: f64) -> BondConductance<2> {
        let mut cloud = lattice(Vector::<2>::zeros(), Vector::repeat(1.0), [12, 12]).unwrap();
        jitter(&mut cloud, amount, 3);
        let families =
            Families::search(&cloud, horizons(&cloud, Horizon::Ratio(3.0)).unwrap()).unwrap();
        let around = Neighbourhood::new(Arc::new(cloud), Arc::new(families), Influence::default());
        BondConductance::new(Arc::new(around.unwrap()))
    }

    #[test]
    fn weights_are_positive_and_their_second_moment_is_the_identity_on_a_jittered_cloud() {
        let form = jittered(0.2);
        assert_eq!(form.uncorrected(), 0);
        for owner in 0..form.around.len() {
            let mut moment = Matrix::<2>::zeros();
            for bond in form.around.families.family(owner) {
                let conductance = form.geometric(owner, bond);
                assert!(conductance > 0.0);
                let xi = form.around.bond_vector(owner, bond);
                moment += xi * xi.transpose() * (conductance / form.around.cloud.volume[owner]);
            }
            assert!((moment - Matrix::identity()).amax() < 1e-12);
        }
    }

    #[test]
    fn the_mean_is_harmonic_and_survives_extreme_mobilities() {
        let form = jittered(0.0);
        let mut mobility = vec![1e-300; form.around.len()];
        let families = &form.around.families;
        let bond = families
            .family(0)
            .find(|&bond| families.neighbour(bond) != 0)
            .unwrap();
        let neighbour = form.around.families.neighbour(bond);
        mobility[neighbour] = 1e12;
        let alone = form.geometric[bond];
        let mut conductances = vec![0.0; families.family(0).len()];
        let place = bond - families.family(0).start;
        form.conductances(0, &mobility, &mut conductances);
        assert!((conductances[place] / alone / 2e-300 - 1.0).abs() < 1e-12);
        mobility[0] = 1e12;
        form.conductances(0, &mobility, &mut conductances);
        assert!((conductances[place] / alone / 1e12 - 1.0).abs() < 1e-12);
    }
}
