//! What one sampled family costs and how fast it exchanges.

use std::collections::BTreeSet;

use crate::geometry::{Cloud, Matrix, Sampler, Side, Vector};
use crate::plan::{Plan, Support};

/// The family of one sampled point.
pub(super) struct LocalFamily {
    /// Bonds, images included.
    pub(super) bonds: usize,
    /// Bonds without images beyond the one-sided planes of the solid.
    pub(super) solid_bonds: usize,
    /// Points within one hop, its own included.
    pub(super) hops: usize,
    /// Points within two hops, its own included.
    pub(super) two_hops: usize,
    /// Whether the second hop of the flow operator vanishes.
    pub(super) one_hop: bool,
    /// Largest eigenvalue of the operator on an endless cloud of such families, in units of the
    /// squared spacing and the mobility.
    pub(super) eigenvalue: f64,
}

impl LocalFamily {
    /// Looks up the family of `point`; the flow operator has the coefficient `hourglass`.
    pub(super) fn new<const D: usize>(
        plan: &Plan,
        cloud: &Cloud<D>,
        sampler: &Sampler<'_, D>,
        point: usize,
        hourglass: f64,
    ) -> Self {
        let family = sampler.family(point);
        let mut hops: BTreeSet<usize> = family.iter().map(|(j, _, _)| *j).collect();
        hops.insert(point);
        let two_hops = match hops.len() > MOST_HOPS {
            true => (hops.len() << D).min(cloud.len()),
            false => second_hops(sampler, &hops),
        };
        let bonds: Vec<(Vector<D>, f64)> = family
            .iter()
            .map(|(j, _, xi)| {
                let weight = plan.influence.weight(xi.norm(), sampler.horizon()[point]);
                (*xi, weight * cloud.volume[*j])
            })
            .collect();
        let shape: Matrix<D> = bonds.iter().map(|(xi, w)| xi * xi.transpose() * *w).sum();
        let bracket = Matrix::identity() - shape * (2.0 * hourglass / shape.trace());
        LocalFamily {
            bonds: family.len(),
            solid_bonds: solid_bonds(plan, cloud, point, &bonds),
            hops: hops.len(),
            two_hops,
            one_hop: bracket.amax() < 1e-11,
            eigenvalue: symbol(&bonds, &shape, &bracket, hourglass, cloud.spacing(point)),
        }
    }
}

/// Points within one hop from which on those within two are estimated, as a ball of twice the radius:
/// counting takes the square of this number.
const MOST_HOPS: usize = 200;
/// Bonds from which on the eigenvalue is taken for its bound.
const MOST_BONDS: usize = 2000;

fn second_hops<const D: usize>(sampler: &Sampler<'_, D>, hops: &BTreeSet<usize>) -> usize {
    let mut second = hops.clone();
    for &j in hops {
        second.extend(sampler.family(j).into_iter().map(|(k, _, _)| k));
    }
    second.len()
}

/// Bonds whose ends do not lie beyond a plane on which forces alone act: there the solid has no
/// images.
fn solid_bonds<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    point: usize,
    bonds: &[(Vector<D>, f64)],
) -> usize {
    let Some(mechanics) = plan.mechanics.as_ref().filter(|_| cloud.domain.planes) else {
        return bonds.len();
    };
    let one_sided = |side: &Side| {
        let support = &mechanics.sides[side.index()];
        matches!(support, Support::Free | Support::Traction(_))
    };
    let open: Vec<Side> = Side::all(D).filter(one_sided).collect();
    let kept = |(xi, _): &&(Vector<D>, f64)| {
        let end = cloud.position[point] + xi;
        let beyond =
            |side: &Side| side.outward() * (end[side.axis] - cloud.domain.plane(*side)) > 0.0;
        !open.iter().any(beyond)
    };
    bonds.iter().filter(kept).count()
}

/// Largest Fourier symbol of the correspondence operator over wave vectors on a grid.
fn symbol<const D: usize>(
    bonds: &[(Vector<D>, f64)],
    shape: &Matrix<D>,
    bracket: &Matrix<D>,
    hourglass: f64,
    spacing: f64,
) -> f64 {
    let inverse = shape.try_inverse().filter(|_| bonds.len() <= MOST_BONDS);
    let Some(inverse) = inverse else {
        return 8.0;
    };
    let value = |wave: &Vector<D>| {
        let (mut even, mut odd) = (0.0, Vector::<D>::zeros());
        for (xi, weight) in bonds {
            let phase = wave.dot(xi);
            even += weight * (1.0 - phase.cos());
            odd += xi * (weight * phase.sin());
        }
        let slope = inverse * odd;
        4.0 * hourglass / shape.trace() * even + slope.dot(&(bracket * slope))
    };
    largest_over_waves(spacing, value) * spacing * spacing
}

/// Largest value of a symbol over wave vectors on a grid up to the shortest waves of a spacing.
pub(super) fn largest_over_waves<const D: usize>(
    spacing: f64,
    symbol: impl Fn(&Vector<D>) -> f64,
) -> f64 {
    let steps = 12_usize;
    let waves = (0..(steps + 1).pow(D as u32)).map(|mut index| {
        Vector::<D>::from_fn(|_, _| {
            let k = index % (steps + 1);
            index /= steps + 1;
            std::f64::consts::PI * k as f64 / steps as f64 / spacing
        })
    });
    waves.map(|wave| symbol(&wave)).fold(0.0, f64::max)
}
