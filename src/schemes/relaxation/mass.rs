//! The fictitious mass of dynamic relaxation.

use crate::model::SolidModel;
use crate::operators::diagonal;
use crate::schemes::limits::largest_eigenvalue_of;

/// Share of the mass in excess of what stability without damping needs: the damping as printed needs 1.17 at its
/// bound, and the estimate of the eigenvalue is good to a per cent.
const SAFETY: f64 = 1.2;

/// Mass per point with which a pseudo-step of one is stable, N/m, shape `(n,)`: the diagonal of K times a quarter of
/// the largest eigenvalue that K has in units of its diagonal.
pub(super) fn fictitious_mass<const D: usize>(solid: &SolidModel<D>) -> Vec<f64> {
    let mut mass = diagonal(&solid.elastic);
    let scale: Vec<f64> = mass.iter().map(|own| own.sqrt().recip()).collect();
    let mut scaled = vec![0.0; solid.unknowns()];
    let largest = largest_eigenvalue_of(solid.unknowns(), |x| {
        let unknowns = x.iter().zip(&mut scaled).enumerate();
        unknowns.for_each(|(k, (x, own))| *own = x * scale[k / D]);
        let mut product = vec![0.0; x.len()];
        solid.multiply(&scaled, &mut product);
        let unknowns = product.iter_mut().enumerate();
        unknowns.for_each(|(k, own)| *own *= scale[k / D]);
        product
    });
    mass.iter_mut()
        .for_each(|own| *own *= 0.25 * SAFETY * largest);
    mass
}
