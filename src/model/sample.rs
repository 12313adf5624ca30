//! What a model will cost, from families of a few points, before anything large is built.

use std::collections::BTreeSet;

use super::{ModelError, build_cloud, properties};
use crate::geometry::{Cloud, Matrix, Sampler, Vector};
use crate::plan::{OperatorChoice, Plan};

/// Averages over sampled points and extremes over all points.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Points of the cloud.
    pub points: usize,
    /// Bonds per point, images included.
    pub bonds: f64,
    /// Nonzeros per row of the flow matrix.
    pub nonzeros: f64,
    /// Whether some sampled family reaches a second hop.
    pub second_hop: bool,
    /// Whether the gradient will be made divergence-consistent.
    pub corrected: bool,
    /// Smallest and largest horizon, m.
    pub horizon: [f64; 2],
    /// Smallest and largest spacing, m.
    pub spacing: [f64; 2],
    /// Smallest and largest mobility, m²/(Pa s).
    pub mobility: [f64; 2],
    /// Smallest and largest diffusivity κ/s, m²/s.
    pub diffusivity: [f64; 2],
    /// Largest edge of the domain, m.
    pub extent: f64,
    /// Explicit step limit, s: smallest over all points with the sampled families' largest
    /// eigenvalue.
    pub explicit_limit: f64,
    /// The point with the smallest limit and its position, m.
    pub limiter: (usize, Vec<f64>),
    /// Points per material.
    pub per_material: Vec<usize>,
}

const SAMPLES: usize = 48;

/// Samples the model of a plan.
///
/// # Errors
/// [`ModelError`] as building would give.
pub fn sample<const D: usize>(plan: &Plan) -> Result<Sample, ModelError> {
    let flow = plan.flow.as_ref().ok_or(ModelError::NothingToDo)?;
    let (cloud, table) = build_cloud::<D>(plan)?;
    let points = properties::assign(plan, &cloud, table)?;
    let sampler = Sampler::new(&cloud, plan.horizon)?;
    let chosen: Vec<usize> = sampled_points(cloud.len());
    let corrected = flow.corrects_gradient(cloud.irregular, cloud.domain.planes);
    let bond = flow.operator == OperatorChoice::Bond;
    let families: Vec<LocalFamily> = chosen
        .iter()
        .map(|&i| LocalFamily::new(plan, &cloud, &sampler, i, flow.hourglass))
        .collect();
    let second_hop = !bond && (corrected || families.iter().any(|family| !family.one_hop));
    let mean = |value: &dyn Fn(&LocalFamily) -> f64| {
        families.iter().map(value).sum::<f64>() / families.len().max(1) as f64
    };
    let eigenvalue = families.iter().map(|f| f.eigenvalue).fold(0.0, f64::max);
    let mobility: Vec<f64> = points
        .permeability
        .iter()
        .map(|k| k / plan.fluid.viscosity)
        .collect();
    let diffusivity: Vec<f64> = mobility
        .iter()
        .zip(&points.storage)
        .map(|(k, s)| k / s)
        .collect();
    let limit = |i: usize| 2.0 * cloud.spacing(i).powi(2) / (diffusivity[i] * eigenvalue);
    let limiter = (0..cloud.len())
        .min_by(|&a, &b| limit(a).total_cmp(&limit(b)))
        .unwrap_or(0);
    let mut per_material = vec![0; plan.materials.len()];
    points
        .material
        .iter()
        .for_each(|&m| per_material[usize::from(m)] += 1);
    Ok(Sample {
        points: cloud.len(),
        bonds: mean(&|family| family.bonds as f64),
        nonzeros: mean(&|f| if second_hop { f.two_hops } else { f.hops } as f64),
        second_hop,
        corrected: corrected && !bond,
        horizon: extremes(sampler.horizon().iter().copied()),
        spacing: extremes((0..cloud.len()).map(|i| cloud.spacing(i))),
        mobility: extremes(mobility.iter().copied()),
        diffusivity: extremes(diffusivity.iter().copied()),
        extent: cloud.domain.size().amax(),
        explicit_limit: limit(limiter),
        limiter: (limiter, cloud.position[limiter].iter().copied().collect()),
        per_material,
    })
}

/// Points spread evenly over the cloud's order.
fn sampled_points(count: usize) -> Vec<usize> {
    let samples = SAMPLES.min(count);
    (0..samples)
        .map(|k| (2 * k + 1) * count / (2 * samples))
        .collect()
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, 0.0], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}

struct LocalFamily {
    bonds: usize,
    hops: usize,
    two_hops: usize,
    one_hop: bool,
    /// Largest eigenvalue of the operator on an endless cloud of such families, in units of the
    /// squared spacing and the mobility.
    eigenvalue: f64,
}

impl LocalFamily {
    fn new<const D: usize>(
        plan: &Plan,
        cloud: &Cloud<D>,
        sampler: &Sampler<'_, D>,
        point: usize,
        hourglass: f64,
    ) -> Self {
        let family = sampler.family(point);
        let mut hops: BTreeSet<usize> = family.iter().map(|(j, _, _)| *j).collect();
        hops.insert(point);
        let second: BTreeSet<usize> = hops
            .iter()
            .flat_map(|&j| sampler.family(j))
            .map(|(k, _, _)| k)
            .chain(hops.clone())
            .collect();
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
            hops: hops.len(),
            two_hops: second.len(),
            one_hop: bracket.amax() < 1e-11,
            eigenvalue: symbol(&bonds, &shape, &bracket, hourglass, cloud.spacing(point)),
        }
    }
}

/// Largest Fourier symbol of the correspondence operator over wave vectors on a grid.
fn symbol<const D: usize>(
    bonds: &[(Vector<D>, f64)],
    shape: &Matrix<D>,
    bracket: &Matrix<D>,
    hourglass: f64,
    spacing: f64,
) -> f64 {
    let Some(inverse) = shape.try_inverse() else {
        return 8.0;
    };
    let steps = 12_usize;
    let mut largest = 0.0_f64;
    for mut index in 0..(steps + 1).pow(D as u32) {
        let wave = Vector::<D>::from_fn(|_, _| {
            let k = index % (steps + 1);
            index /= steps + 1;
            std::f64::consts::PI * k as f64 / steps as f64 / spacing
        });
        let (mut even, mut odd) = (0.0, Vector::<D>::zeros());
        for (xi, weight) in bonds {
            let phase = wave.dot(xi);
            even += weight * (1.0 - phase.cos());
            odd += xi * (weight * phase.sin());
        }
        let slope = inverse * odd;
        let value = 4.0 * hourglass / shape.trace() * even + slope.dot(&(bracket * slope));
        largest = largest.max(value);
    }
    largest * spacing * spacing
}
