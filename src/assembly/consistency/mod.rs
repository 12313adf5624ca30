//! The divergence-consistent gradient: corrected weights whose column sums vanish inside.
//!
//! Where the spacing varies the area vectors of the plain gradient do not vanish, so a uniform flux
//! or stress is out of balance ("ghost forces"). The weights are corrected on the same bonds,
//! (C f)_i = Σ_b ω V_j (R λ)_b (f_j − f_i), with one multiplier field λ per component from
//! A λ = t − Gᵀ V 1, A = Rᵀ D(V_i ω V_j) R the hourglass matrix. R λ is orthogonal to linear
//! functions, so G + C stays exact for them.
//!
//! Column sums are taken in the cloud continued across its planes, each component with the parity
//! of its own linear function: odd across planes normal to it, even across the others. For flow the
//! correction is then a property of the geometry alone; boundary terms of a field's parity stay what
//! they are on a lattice. For a displacement the normal derivative of each component takes that
//! component's parity, which is odd across clamped planes too.

mod multipliers;
mod planes;
mod targets;

use std::sync::Arc;

use perifrac_solvers::{SolveError, SpecError};

pub(crate) use planes::{Planes, natural_extension};
pub(crate) use targets::{boundary_layer, side_layer, surface_layer};

use super::{Pattern, PatternError};
use crate::geometry::{Side, Vector, Voids};
use crate::operators::{
    Gradient, Hourglass, MirrorContinuation, Neighbourhood, column_sums, family_gradient,
};

/// What the correction achieved.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Consistency {
    /// Largest column sum before, relative to the face of a cell.
    pub before: f64,
    /// Largest deviation of a column sum from its target after, relative to the face of a cell.
    pub after: f64,
    /// Largest ratio of a family's correction to its plain weights; beyond about one half the
    /// corrected gradient is no longer trustworthy.
    pub ratio: f64,
    /// Points that feel the free surface of a void and keep their own column sums.
    pub surface_points: usize,
    /// Families that keep the plain weights, because the correction would exceed them.
    pub plain_families: usize,
    /// The first of them.
    #[serde(skip)]
    pub first_plain: Option<usize>,
}

/// Why the gradient could not be made divergence-consistent.
#[derive(Debug, thiserror::Error)]
pub enum ConsistencyError {
    /// A cloud without boundary planes has no known boundary layer.
    #[error(
        "the divergence-consistent gradient needs the boundary planes of the cloud; give \
         geometry.bounds, or set flow.gradient = \"plain\""
    )]
    NoPlanes,
    /// The multipliers could not be computed.
    #[error("the divergence-consistent gradient could not be computed: {0}")]
    Solve(#[from] SolveError),
    /// The solver is not there.
    #[error(transparent)]
    Solver(#[from] SpecError),
    /// The hourglass matrix is too large.
    #[error(transparent)]
    Pattern(#[from] PatternError),
}

/// Corrects the plain gradient of `around`.
///
/// # Errors
/// [`ConsistencyError`] for a cloud without planes, or if a solve fails.
pub(crate) fn consistent_gradient<const D: usize>(
    around: &Arc<Neighbourhood<D>>,
    planes: &Planes,
) -> Result<(Gradient<D>, Consistency), ConsistencyError> {
    if !around.cloud.domain.planes {
        return Err(ConsistencyError::NoPlanes);
    }
    let plain = Arc::new(Gradient::plain(around));
    let form = Hourglass::new(around.clone(), plain.clone());
    let pattern = Pattern::new(&form)?;
    let mut corrected = plain.weight.clone();
    let voids = Voids::find(&around.cloud);
    let mut quality = Consistency::default();
    let mut wanted = Vec::new();
    for axis in 0..D {
        let natural = natural_extension(around, axis, planes);
        let sums = component_sums(around, &natural, &plain.weight, axis);
        let unseen = targets::null_functions(around, axis, planes);
        // The area of a one-sided plane is normal to it: the other components have no layer there.
        let normal = |side: &Side| side.axis == axis && planes.one_sided[side.index()];
        let sides: Vec<Side> = Side::all(D).filter(normal).collect();
        let layer = targets::layer(around, &sides, &voids);
        let totals = targets::totals(around, &sides, &voids);
        let target = targets::targets(&unseen, &totals, &layer, &sums);
        let rhs: Vec<f64> = target.iter().zip(&sums).map(|(t, s)| t - s).collect();
        quality.before = quality.before.max(relative(around, &rhs));
        let shift = multipliers::shift(unseen.is_empty());
        let lambda = multipliers::multipliers(&form, &natural, &pattern, &rhs, shift)?;
        add_correction(around, &natural, &lambda, axis, &mut corrected);
        wanted.push((natural, target));
    }
    let free: Vec<Side> = Side::all(D)
        .filter(|side| planes.one_sided[side.index()])
        .collect();
    let known = boundary_layer(around, &free);
    fall_back(around, &plain.weight, &known, &mut corrected, &mut quality);
    for (axis, (natural, target)) in wanted.iter().enumerate() {
        let after = component_sums(around, natural, &corrected, axis);
        let left: Vec<f64> = after.iter().zip(target).map(|(s, t)| s - t).collect();
        quality.after = quality.after.max(relative(around, &left));
    }
    if !voids.is_empty() {
        let feels = targets::layer(around, &[], &voids);
        quality.surface_points = feels.iter().filter(|feels| **feels).count();
    }
    Ok((Gradient { weight: corrected }, quality))
}

/// Column sums of one component of the gradient.
fn component_sums<const D: usize>(
    around: &Neighbourhood<D>,
    natural: &MirrorContinuation<D>,
    weight: &[Vector<D>],
    axis: usize,
) -> Vec<f64> {
    let own = |a: usize, bond: usize| if a == axis { weight[bond][a] } else { 0.0 };
    let sign = |_: usize, bond: usize| natural.sign(around.families.image(bond));
    let sums = column_sums(around, own, sign);
    sums.into_iter().map(|sum| sum[axis]).collect()
}

/// Largest entry relative to the face of the point's cell.
fn relative<const D: usize>(around: &Neighbourhood<D>, sums: &[f64]) -> f64 {
    let face = |point: usize| around.cloud.volume[point] / around.cloud.spacing(point);
    sums.iter()
        .enumerate()
        .map(|(point, sum)| sum.abs() / face(point))
        .fold(0.0, f64::max)
}

/// Adds ω V_j (R λ)_b to one component of the weights.
fn add_correction<const D: usize>(
    around: &Neighbourhood<D>,
    natural: &MirrorContinuation<D>,
    lambda: &[f64],
    axis: usize,
    weight: &mut [Vector<D>],
) {
    let families = &around.families;
    for owner in 0..around.len() {
        let difference = |b: usize| {
            natural.sign(families.image(b)) * lambda[families.neighbour(b)] - lambda[owner]
        };
        let slope = family_gradient(around, owner, difference);
        for bond in families.family(owner) {
            let residual = difference(bond) - slope.dot(&around.bond_vector(owner, bond));
            weight[bond][axis] += around.measure[bond] * residual;
        }
    }
}

/// First moment of a family, over that of its distances, from which it is one-sided: 0.48 beside a flat
/// surface, 0.1 typically and 0.25 at most on lattices jittered by 0.4.
const ONE_SIDED: f64 = 0.3;

/// Gives the plain weights back to one-sided families whose correction exceeds them: what was to be
/// corrected there is a free surface that was not found. Generated clouds fill their domain and have none, and
/// families beside free sides, which are `known`, are one-sided by right.
fn fall_back<const D: usize>(
    around: &Neighbourhood<D>,
    plain: &[Vector<D>],
    known: &[bool],
    corrected: &mut [Vector<D>],
    quality: &mut Consistency,
) {
    let norm = |weights: &mut dyn Iterator<Item = Vector<D>>| -> f64 {
        weights.map(|w| w.norm_squared()).sum::<f64>().sqrt()
    };
    for (owner, known) in known.iter().enumerate() {
        let family = around.families.family(owner);
        let change = norm(&mut family.clone().map(|b| corrected[b] - plain[b]));
        let ratio = change / norm(&mut family.clone().map(|b| plain[b]));
        let suspect = !around.cloud.filled && !known;
        if ratio > 1.0 && suspect && one_sidedness(around, owner) > ONE_SIDED {
            corrected[family.clone()].copy_from_slice(&plain[family]);
            if around.families.share.owns(owner) {
                quality.plain_families += 1;
                quality.first_plain.get_or_insert(owner);
            }
        } else {
            quality.ratio = quality.ratio.max(ratio);
        }
    }
    let mut families = [quality.plain_families as f64];
    around.families.share.sum(&mut families);
    quality.plain_families = families[0] as usize;
}

/// |Σ ω V ξ| over Σ ω V |ξ|.
fn one_sidedness<const D: usize>(around: &Neighbourhood<D>, owner: usize) -> f64 {
    let (mut moment, mut whole) = (Vector::<D>::zeros(), 0.0);
    for bond in around.families.family(owner) {
        let xi = around.bond_vector(owner, bond);
        moment += xi * around.measure[bond];
        whole += xi.norm() * around.measure[bond];
    }
    moment.norm() / whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::lattice;
    use crate::geometry::{Cloud, Families, Horizon, Influence, horizons};

    /// A square with a hole whose neighbours claim so much room that it cannot be found.
    #[test]
    fn one_sided_families_stay_plain_where_the_correction_would_exceed_them() {
        let mut cloud = lattice(Vector::<2>::zeros(), Vector::repeat(1.0), [20, 20]).unwrap();
        let hole = |x: &Vector<2>| (x - Vector::repeat(0.5)).norm() < 0.2;
        cloud.position.retain(|x| !hole(x));
        cloud.volume.truncate(cloud.position.len());
        cloud.cell = vec![Vector::repeat(0.4); cloud.position.len()];
        let corrected = |filled: bool| {
            let cloud = Arc::new(Cloud {
                filled,
                ..cloud.clone()
            });
            let horizon = horizons(&cloud, Horizon::Neighbours(15)).unwrap();
            let families = Arc::new(Families::search(&cloud, horizon).unwrap());
            let around = Neighbourhood::new(cloud, families, Influence::default()).unwrap();
            let around = Arc::new(around);
            let planes = Planes::natural(&[false; 4]);
            let (gradient, quality) = consistent_gradient(&around, &planes).unwrap();
            (gradient, quality, Gradient::plain(&around), around)
        };
        let (_, mended, _, _) = corrected(true);
        assert!(
            mended.ratio > 1.0 && mended.plain_families == 0,
            "{mended:?}"
        );
        let (gradient, quality, plain, around) = corrected(false);
        assert!(quality.plain_families > 20, "{quality:?}");
        let first = around.families.family(quality.first_plain.unwrap());
        assert!(gradient.weight[first.clone()] == plain.weight[first]);
    }
}
