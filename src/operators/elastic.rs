//! The linearised mechanical operator: strain energy of the nonlocal gradient plus an hourglass
//! energy per displacement component (Eqs. 10, 11 and 58).
//!
//! With the bond differences d of one family the energy is
//!
//!   ½ V_i C:ε:ε + ½ h_i Σ_b ω V_j |d_b − H ξ_b|²,  h_i = 2 c μ_i V_i / m_i,
//!
//! where ε is the symmetric part of Σ_b d_b ⊗ w_b with the weights w of the strain gradient, and H
//! the plain gradient. Adding up the families gives a symmetric matrix (Eq. 2). Families in which moduli vary
//! have the energy of [`Laminate`] instead.

use std::sync::{Arc, OnceLock};

use super::{Gradient, Laminate, Layers, MirrorContinuation, Neighbourhood};
use crate::geometry::{Matrix, Vector};
use crate::material::Lame;
use crate::parallel::{self, TASK, by_ranges};

/// Elastic operator over one neighbourhood; every displacement component has its own continuation.
#[derive(Debug, Clone)]
pub struct Elastic<const D: usize> {
    /// The families, without images beyond one-sided planes.
    pub around: Arc<Neighbourhood<D>>,
    /// Weights of the strain, divergence-consistent where the spacing varies.
    pub gradient: Arc<Gradient<D>>,
    /// Continuation of every displacement component.
    pub extension: Vec<MirrorContinuation<D>>,
    /// Elastic constants per point, shape `(n,)`.
    pub lame: Vec<Lame>,
    plain: Arc<Gradient<D>>,
    /// h per point, N/m⁴ in 3-D.
    hourglass: Vec<f64>,
    laminate: Option<Laminate<D>>,
    /// Sums of the weights of every family, 1/m; made when they are first asked for.
    sums: OnceLock<Vec<Vector<D>>>,
}

impl<const D: usize> Elastic<D> {
    /// Operator with the hourglass modulus `hourglass` · μ; `gradient` is the plain one if `None`.
    pub fn new(
        around: Arc<Neighbourhood<D>>,
        gradient: Option<Gradient<D>>,
        extension: Vec<MirrorContinuation<D>>,
        lame: Vec<Lame>,
        hourglass: f64,
    ) -> Self {
        let plain = Arc::new(Gradient::plain(&around));
        let stiffness = |(i, lame): (usize, &Lame)| {
            2.0 * hourglass * lame.mu * around.cloud.volume[i] / around.moment[i]
        };
        Elastic {
            gradient: gradient.map_or_else(|| plain.clone(), Arc::new),
            hourglass: lame.iter().enumerate().map(stiffness).collect(),
            around,
            extension,
            lame,
            plain,
            laminate: None,
            sums: OnceLock::new(),
        }
    }

    /// The same with plain weights that agree to the last bit where points are alike, so that rows of matrices repeat.
    ///
    /// Their rounding errors agree as well, and add up where some rock is softer by many orders of magnitude.
    #[must_use]
    pub fn with_repeated_weights(mut self) -> Self {
        let plain = Arc::new(Gradient::repeated(&self.around));
        if self.has_plain_gradient() {
            self.gradient = plain.clone();
        }
        self.plain = plain;
        self
    }

    /// The same with layers in some families; their hourglass modulus is that of shear across the layers.
    #[must_use]
    pub fn with_layers(mut self, laminate: Laminate<D>) -> Self {
        for owner in 0..self.points() {
            if let Some(layers) = laminate.of(owner) {
                let softer = (layers.means.shear_compliance * self.lame[owner].mu).recip();
                self.hourglass[owner] *= softer;
            }
        }
        self.laminate = Some(laminate);
        self
    }

    /// The layers of a point's family, if moduli vary in it.
    pub fn layers(&self, owner: usize) -> Option<Layers<'_, D>> {
        self.laminate.as_ref()?.of(owner)
    }

    /// Number of families with layers.
    pub fn layered(&self) -> usize {
        self.laminate.as_ref().map_or(0, Laminate::len)
    }

    /// Stress of the family of a point, Pa: the derivative of its energy.
    pub fn stress(&self, owner: usize, strain: &Matrix<D>) -> Matrix<D> {
        match self.layers(owner) {
            None => self.lame[owner].stress(strain),
            Some(layers) => layers.stress(strain),
        }
    }

    /// Stress at a point, in its own rock, and across the plane of plane strain, Pa.
    pub fn stress_at(&self, owner: usize, strain: &Matrix<D>) -> (Matrix<D>, f64) {
        let lame = self.lame[owner];
        match self.layers(owner) {
            None => (lame.stress(strain), lame.lambda * strain.trace()),
            Some(layers) => layers.stress_in(lame, strain),
        }
    }

    /// Modulus of uniaxial strain, Pa; the largest one of a family with layers.
    pub fn stiffest(&self, owner: usize) -> f64 {
        let own = self.lame[owner].lambda + 2.0 * self.lame[owner].mu;
        (self.layers(owner)).map_or(own, |layers| own.max(layers.means.stiffest()))
    }

    /// Multiplies the stiffness of one point, hourglass included; refill what was assembled from it.
    pub fn degrade(&mut self, point: usize, factor: f64) {
        let Lame { lambda, mu } = self.lame[point];
        self.lame[point] = Lame {
            lambda: factor * lambda,
            mu: factor * mu,
        };
        self.hourglass[point] *= factor;
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.around.len()
    }

    /// Signs with which the components of the displacement of a bond's end enter its difference.
    #[inline]
    pub fn signs(&self, bond: usize) -> Vector<D> {
        let image = self.around.families.image(bond);
        Vector::from_fn(|axis, _| self.extension[axis].sign(image))
    }

    /// A vector at the end of a bond with the signs of its image.
    #[inline]
    pub(super) fn signed(&self, bond: usize, vector: Vector<D>) -> Vector<D> {
        match self.around.families.image(bond) {
            0 => vector,
            _ => self.signs(bond).component_mul(&vector),
        }
    }

    /// Whether strains take the plain gradient.
    pub fn has_plain_gradient(&self) -> bool {
        Arc::ptr_eq(&self.gradient, &self.plain)
    }

    /// Bond difference of a displacement field of shape `(n·D,)`, fixed walls at rest, m.
    #[inline]
    pub fn difference(&self, displacement: &[f64], owner: usize, bond: usize) -> Vector<D> {
        let end = self.around.families.neighbour(bond);
        let (from, to) = (
            point_value(displacement, owner),
            point_value(displacement, end),
        );
        self.signed(bond, to) - from
    }

    /// Sum of the weights of the strain of every family, shape `(n,)`, 1/m: what a point takes off the gradient at itself.
    pub(super) fn weight_sums(&self) -> &[Vector<D>] {
        let families = &self.around.families;
        let sum = |point| {
            families
                .family(point)
                .map(|bond| self.gradient.weight[bond])
                .sum()
        };
        let all = || (0..self.points()).map(sum).collect();
        self.sums.get_or_init(all)
    }

    /// Displacement gradient of a point from its bond differences; rows are components.
    pub fn gradient_of(&self, owner: usize, difference: impl Fn(usize) -> Vector<D>) -> Matrix<D> {
        let family = self.around.families.family(owner);
        let mut sum = Matrix::zeros();
        for bond in family {
            sum += difference(bond) * self.gradient.weight[bond].transpose();
        }
        sum
    }

    /// Forces on the ends of all bonds, shape `(bonds,)`, N; `difference(owner, bond)` in m.
    pub fn bond_forces(
        &self,
        difference: impl Fn(usize, usize) -> Vector<D> + Sync,
    ) -> Vec<Vector<D>> {
        let response = |owner: usize, strain: &Matrix<D>| (self.stress(owner, strain), 1.0);
        self.bond_forces_of(difference, response)
    }

    /// As [`Elastic::bond_forces`] with `response(owner, strain)`, the stress in Pa and the factor of the
    /// hourglass stiffness.
    pub fn bond_forces_of(
        &self,
        difference: impl Fn(usize, usize) -> Vector<D> + Sync,
        response: impl Fn(usize, &Matrix<D>) -> (Matrix<D>, f64) + Sync,
    ) -> Vec<Vector<D>> {
        let families = &self.around.families;
        let mut forces = vec![Vector::zeros(); families.bonds()];
        by_ranges(families.offsets(), &mut forces, |owner, forces| {
            let difference = |bond: usize| difference(owner, bond);
            self.family_response(
                owner,
                difference,
                |strain, _| response(owner, strain),
                forces,
            );
        });
        forces
    }

    /// Forces on the ends of the bonds of one family, N, into `forces`; gives its hourglass energy, J,
    /// without the factor that `response(strain, energy)` gives beside the stress.
    pub(super) fn family_response(
        &self,
        owner: usize,
        difference: impl Fn(usize) -> Vector<D>,
        response: impl FnOnce(&Matrix<D>, f64) -> (Matrix<D>, f64),
        forces: &mut [Vector<D>],
    ) -> f64 {
        let around = &self.around;
        let family = around.families.family(owner);
        let (mut slope, mut plain) = (Matrix::zeros(), Matrix::zeros());
        for (bond, own) in family.clone().zip(&mut *forces) {
            *own = difference(bond);
            slope += *own * self.gradient.weight[bond].transpose();
        }
        if let Some(layers) = self.layers(owner) {
            return self.layered_response(owner, layers, &slope, response, forces);
        }
        match self.has_plain_gradient() {
            true => plain = slope,
            false => {
                for (bond, own) in family.clone().zip(&*forces) {
                    plain += own * self.plain.weight[bond].transpose();
                }
            }
        }
        let mut squares = 0.0;
        for (bond, own) in family.clone().zip(&mut *forces) {
            *own -= plain * around.bond_vector(owner, bond);
            squares += around.measure[bond] * own.norm_squared();
        }
        let hourglass_energy = 0.5 * self.hourglass[owner] * squares;
        let (stress, factor) = response(&((slope + slope.transpose()) * 0.5), hourglass_energy);
        let stress = stress * around.cloud.volume[owner];
        let hourglass = self.hourglass[owner] * factor;
        for (bond, own) in family.zip(forces) {
            let held = *own * (hourglass * around.measure[bond]);
            *own = stress * self.gradient.weight[bond] + held;
        }
        hourglass_energy
    }

    /// The same for a family with layers, whose bond differences are in `forces`.
    fn layered_response(
        &self,
        owner: usize,
        layers: Layers<'_, D>,
        slope: &Matrix<D>,
        response: impl FnOnce(&Matrix<D>, f64) -> (Matrix<D>, f64),
        forces: &mut [Vector<D>],
    ) -> f64 {
        let around = &self.around;
        let family = around.families.family(owner);
        let (mut squares, mut pull) = (0.0, Matrix::zeros());
        for (place, (bond, own)) in family.clone().zip(&mut *forces).enumerate() {
            let xi = around.bond_vector(owner, bond);
            *own -= layers.stretch(place, &xi, slope);
            squares += around.measure[bond] * own.norm_squared();
            *own *= around.measure[bond];
            pull += layers.pull(place, &xi, own);
        }
        let hourglass_energy = 0.5 * self.hourglass[owner] * squares;
        let (stress, factor) = response(&((slope + slope.transpose()) * 0.5), hourglass_energy);
        let hourglass = self.hourglass[owner] * factor;
        let total = stress * around.cloud.volume[owner] - pull * hourglass;
        for (bond, own) in family.zip(forces) {
            *own = total * self.gradient.weight[bond] + *own * hourglass;
        }
        hourglass_energy
    }

    /// Sums bond forces to the derivative of the energy at every point, shape `(n·D,)`, N.
    pub fn gather(&self, forces: &[Vector<D>]) -> Vec<f64> {
        let families = &self.around.families;
        let mut sums = vec![0.0; D * self.points()];
        let at = |point: usize, sums: &mut [f64]| {
            let own: Vector<D> = families.family(point).map(|bond| forces[bond]).sum();
            let dual: Vector<D> = families
                .dual(point)
                .map(|(_, bond)| self.signed(bond, forces[bond]))
                .sum();
            sums.copy_from_slice((dual - own).as_slice());
        };
        parallel::chunks(&mut sums, D, TASK, at);
        families.share.complete(&mut sums, D);
        sums
    }

    /// K u without a matrix: slower than a product, the oracle of the assembled one.
    pub fn force(&self, displacement: &[f64]) -> Vec<f64> {
        self.gather(&self.bond_forces(|owner, bond| self.difference(displacement, owner, bond)))
    }

    /// Weights of the hourglass energy: the plain gradient and h.
    #[inline]
    pub(crate) fn hourglass(&self, owner: usize) -> (&Gradient<D>, f64) {
        (&self.plain, self.hourglass[owner])
    }

    /// Bytes held beyond the neighbourhood.
    pub fn bytes(&self) -> usize {
        let gradients = if self.has_plain_gradient() { 1 } else { 2 } * self.plain.bytes();
        let layers = self.laminate.as_ref().map_or(0, Laminate::bytes);
        let sums = self.sums.get().map_or(0, |sums| 8 * D * sums.len());
        sums + gradients + layers + 8 * self.hourglass.len() + size_of::<Lame>() * self.lame.len()
    }
}

/// Components of a point in a field of shape `(n·D,)`.
#[inline]
pub(crate) fn point_value<const D: usize>(field: &[f64], point: usize) -> Vector<D> {
    Vector::from_fn(|axis, _| field[point * D + axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::lattice;
    use crate::geometry::{Families, Horizon, Influence, horizons};

    #[test]
    fn weights_that_repeat_are_those_by_positions_to_rounding() {
        let cloud = lattice(Vector::repeat(0.3), Vector::<2>::new(1.3, 0.7), [13, 12]).unwrap();
        let horizon = horizons(&cloud, Horizon::Ratio(3.015)).unwrap();
        let families = Arc::new(Families::search(&cloud, horizon).unwrap());
        let around = Neighbourhood::new(Arc::new(cloud), families, Influence::default());
        let around = Arc::new(around.unwrap());
        let plane = MirrorContinuation::new(
            &around.families.images,
            &[crate::operators::Parity::Even; 4],
            &[0.3, 1.6, 0.3, 1.0],
        );
        let lame = vec![
            Lame {
                lambda: 1.0,
                mu: 1.0
            };
            around.len()
        ];
        let extension = vec![plane.clone(), plane];
        let slow = Elastic::new(around.clone(), None, extension, lame, 1.0);
        let fast = slow.clone().with_repeated_weights();
        assert!(fast.has_plain_gradient());
        let alike = around.families.alike(&around.cloud).unwrap();
        for (point, first) in alike.into_iter().enumerate() {
            let own = around.families.family(point);
            for (bond, other) in own.zip(around.families.family(first as usize)) {
                assert_eq!(fast.gradient.weight[bond], fast.gradient.weight[other]);
                let apart = fast.gradient.weight[bond] - slow.gradient.weight[bond];
                assert!(apart.amax() < 1e-13 * slow.gradient.weight[bond].amax());
            }
        }
    }
}
