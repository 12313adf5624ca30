//! The mechanical divergence and its adjoint: what couples the displacement to the pressure.

use super::Elastic;
use crate::geometry::Vector;
use crate::parallel;

/// Q = D(V α) div of Biot's equations, with the gradient of the mechanical operator, so that the
/// work of the pressure on the solid and that of the solid on the fluid are the same.
#[derive(Debug, Clone)]
pub struct Divergence {
    /// V α per point, m^D, shape `(n,)`.
    pub weight: Vec<f64>,
}

impl Divergence {
    /// Adds Q u to `result` (shape `(n,)`, m^D): the gain of pore volume by strain.
    pub fn add<const D: usize>(
        &self,
        elastic: &Elastic<D>,
        displacement: &[f64],
        result: &mut [f64],
    ) {
        let at = |point: usize| {
            self.of_differences(elastic, point, |bond| {
                elastic.difference(displacement, point, bond)
            })
        };
        parallel::each(result, 256, |point, result| *result += at(point));
        elastic.around.families.share.complete(result, 1);
    }

    /// V α div of one point from its bond differences, m^D.
    pub fn of_differences<const D: usize>(
        &self,
        elastic: &Elastic<D>,
        point: usize,
        difference: impl Fn(usize) -> Vector<D>,
    ) -> f64 {
        let family = elastic.around.families.family(point);
        let sum: f64 = family
            .map(|bond| elastic.gradient.weight[bond].dot(&difference(bond)))
            .sum();
        self.weight[point] * sum
    }

    /// Adds Qᵀ p to `result` (shape `(n·D,)`, N): the push of the pressure on the solid.
    pub fn add_adjoint<const D: usize>(
        &self,
        elastic: &Elastic<D>,
        pressure: &[f64],
        result: &mut [f64],
    ) {
        let families = &elastic.around.families;
        let (weight, sums) = (&elastic.gradient.weight, elastic.weight_sums());
        let pairs = self.weight.iter().zip(pressure);
        let push: Vec<f64> = pairs.map(|(weight, pressure)| weight * pressure).collect();
        parallel::chunks(result, D, 256, |point, result| {
            let mut total = sums[point] * -push[point];
            for (owner, bond) in families.dual(point) {
                total += elastic.signed(bond, weight[bond]) * push[owner];
            }
            (0..D).for_each(|axis| result[axis] += total[axis]);
        });
        families.share.complete(result, D);
    }
}
