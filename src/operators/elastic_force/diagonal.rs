//! The diagonal of K, without K.

use crate::geometry::{Matrix, Vector};
use crate::operators::{Elastic, Lame};
use crate::parallel;

/// Largest diagonal entry of K among the components of every point, N/m, shape `(n,)`.
///
/// A point with weight g in the strain of a family and g̃ in its plain gradient adds V ((λ + μ) g_a² + μ g²) and
/// h (m − g̃ K g̃), m being ω V of its bond, or their sum for the owner. Families of layers count as their stiffest one.
pub(crate) fn diagonal<const D: usize>(elastic: &Elastic<D>) -> Vec<f64> {
    let around = &elastic.around;
    let families = &around.families;
    let shape = |point: usize| {
        around.inverse_shape[point]
            .try_inverse()
            .unwrap_or_else(Matrix::zeros)
    };
    let shapes: Vec<Matrix<D>> = parallel::map(around.inverse_shape.len(), shape);
    let entry = |owner: usize, strain: Vector<D>, plain: Vector<D>, measure: f64| -> Vector<D> {
        let Lame { lambda, mu } = elastic.lame[owner];
        let stiffer = elastic.stiffest(owner) / (lambda + 2.0 * mu);
        let volume = around.cloud.volume[owner] * stiffer;
        let held = measure - plain.dot(&(shapes[owner] * plain));
        let rest = volume * mu * strain.norm_squared() + elastic.hourglass(owner).1 * held;
        strain.map(|own| volume * (lambda + mu) * own * own + rest)
    };
    let at = |point: usize| -> f64 {
        let plain = &elastic.hourglass(point).0.weight;
        let family = families.family(point);
        let sum = |weight: &[Vector<D>]| -> Vector<D> { weight[family.clone()].iter().sum() };
        let measure: f64 = around.measure[family.clone()].iter().sum();
        let own = entry(point, sum(&elastic.gradient.weight), sum(plain), measure);
        let dual = families.dual(point).map(|(owner, bond)| {
            let strain = elastic.gradient.weight[bond];
            entry(owner, strain, plain[bond], around.measure[bond])
        });
        (own + dual.sum::<Vector<D>>()).max()
    };
    parallel::map(elastic.points(), at)
}
