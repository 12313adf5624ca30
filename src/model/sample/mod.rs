//! What a model will cost, from families of a few points, before anything large is built.

mod cell;
mod coupled;
mod family;
mod outline;
mod rock;
mod width;

pub use coupled::CoupledSample;
pub use rock::Rock;

use self::cell::LocalCell;
use self::family::LocalFamily;
use self::outline::CloudOutline;
use super::fields::Fields;
use super::lattice::separates;
use super::operator_choice::{ChosenOperator, Form};
use super::properties::{self, Properties};
use super::{ModelError, build_cloud, fit};
use crate::geometry::{Cloud, GeometryError, Horizon, Sampler};
use crate::operators::WidthRange;
use crate::plan::capability::{System, systems};
use crate::plan::{FlowPlan, MechanicsPlan, Plan};

/// Averages over sampled points and extremes over all points.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Points of the cloud.
    pub points: usize,
    /// Whether the cloud was too large to be made, so that a small one stands for it.
    pub estimated: bool,
    /// Points along the edge of the smallest cross-section of the cloud.
    pub across: f64,
    /// Smallest and largest horizon, m.
    pub horizon: [f64; 2],
    /// Smallest and largest spacing, m.
    pub spacing: [f64; 2],
    /// Largest edge of the domain, m.
    pub extent: f64,
    /// Whether the spacing varies.
    pub irregular: bool,
    /// Points per material.
    pub per_material: Vec<usize>,
    /// Flow, if the plan names it.
    pub flow: Option<FlowSample>,
    /// Deformation, if the plan names it.
    pub solid: Option<SolidSample>,
    /// What couples the two, if the plan names it.
    pub coupling: Option<CoupledSample>,
    /// Effective widths of the families over all directions, if rock breaks.
    pub width: Option<WidthRange>,
    /// Per material in whose region what breaks varies, the rocks that are extreme; empty without such.
    pub rocks: Vec<Vec<Rock>>,
    /// Systems for which the points are a lattice that separates.
    pub separates: Vec<System>,
}

/// What flow costs.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowSample {
    /// The diffusion operator.
    pub operator: ChosenOperator,
    /// Bonds per point, images included.
    pub bonds: f64,
    /// Nonzeros per row of the matrix.
    pub nonzeros: f64,
    /// Whether some sampled family reaches a second hop.
    pub second_hop: bool,
    /// Whether the gradient will be made divergence-consistent.
    pub corrected: bool,
    /// Smallest and largest mobility, m²/(Pa s).
    pub mobility: [f64; 2],
    /// Smallest and largest diffusivity κ/s, m²/s.
    pub diffusivity: [f64; 2],
    /// Explicit step limit: smallest over all points with the sampled families' largest eigenvalue;
    /// with what a fixed-stress split adds to the storage.
    pub limit: PointLimit,
}

/// What deformation costs.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidSample {
    /// Bonds per point, images included.
    pub bonds: f64,
    /// Points that a point is coupled to, its own included.
    pub neighbours: f64,
    /// Whether the gradient will be made divergence-consistent.
    pub corrected: bool,
    /// Largest Poisson's ratio.
    pub poissons_ratio: f64,
    /// Largest over smallest shear modulus.
    pub contrast: f64,
    /// Largest (λ + 2μ)/μ.
    pub volume_stiffness: f64,
    /// Step limit by waves, where the density of every point is known.
    pub waves: Option<PointLimit>,
}

/// A largest step and the point that sets it.
#[derive(Debug, Clone, PartialEq)]
pub struct PointLimit {
    /// The step, s.
    pub dt: f64,
    /// The point.
    pub point: usize,
    /// Its position, m.
    pub position: Vec<f64>,
}

impl PointLimit {
    /// The smallest of the steps that `limit` gives for every point, s.
    fn smallest<const D: usize>(cloud: &Cloud<D>, limit: impl Fn(usize) -> f64) -> Self {
        let point = (0..cloud.len())
            .min_by(|&a, &b| limit(a).total_cmp(&limit(b)))
            .unwrap_or(0);
        PointLimit {
            dt: limit(point),
            point,
            position: cloud.position[point].iter().copied().collect(),
        }
    }
}

/// Largest over smallest of positive numbers.
pub(super) fn contrast(values: impl Iterator<Item = f64>) -> f64 {
    let start = (f64::INFINITY, 0.0_f64);
    let (low, high) = values.fold(start, |(low, high), v| (low.min(v), high.max(v)));
    high / low
}

const SAMPLES: usize = 48;
/// Bonds of a family from which on fewer are sampled.
const LARGE: usize = 150;
/// Share of the step of Eq. 60 that is taken (Eq. 61).
const WAVE_SHARE: f64 = 0.7;

/// Samples the model of a plan; a cloud that is too large to be made in about a second is estimated
/// from a small one like it.
///
/// # Errors
/// [`ModelError`] as building would give.
pub fn sample<const D: usize>(plan: &Plan) -> Result<Sample, ModelError> {
    if plan.flow.is_none() && plan.mechanics.is_none() {
        return Err(ModelError::NothingToDo);
    }
    let sample = match CloudOutline::<D>::of_large(plan)? {
        Some(outline) => estimated(plan, &outline)?,
        None => {
            let (cloud, table) = build_cloud::<D>(plan)?;
            fit::check(plan, &cloud)?;
            let points = properties::assign(plan, &cloud, table)?;
            sampled(plan, &cloud, &points, plan.horizon)?
        }
    };
    check_bonds(&sample)?;
    Ok(sample)
}

fn sampled<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    points: &Properties,
    horizon: Horizon,
) -> Result<Sample, ModelError> {
    let sampler = Sampler::new(cloud, horizon)?;
    let hourglass = plan.flow.as_ref().map_or(1.0, |flow| flow.hourglass);
    let chosen = (plan.flow.as_ref())
        .map(|flow| ChosenOperator::of(plan, flow, &points.permeability, cloud.irregular));
    let samples = sampled_points(cloud.len());
    let typical = samples.get(samples.len() / 2);
    let size = typical.map_or(0, |&point| sampler.family(point).len());
    // Large families cost more each, and differ less.
    let step = (size / LARGE).clamp(1, samples.len().div_ceil(3).max(1));
    let samples: Vec<usize> = samples.into_iter().step_by(step).collect();
    let families: Vec<LocalFamily> = (samples.iter())
        .map(|i| LocalFamily::new(plan, cloud, &sampler, *i, hourglass))
        .collect();
    let cells: Option<Vec<LocalCell>> = match chosen.as_ref().map(|chosen| chosen.form) {
        Some(Form::Path(cells)) => {
            let varies = contrast(points.permeability.iter().copied()) > 1.0;
            let cell = |point: &usize| LocalCell::new(cloud, &sampler, cells, *point, varies);
            Some(samples.iter().map(cell).collect())
        }
        _ => None,
    };
    let mut per_material = vec![0; plan.materials.len()];
    points
        .material
        .iter()
        .for_each(|&m| per_material[usize::from(m)] += 1);
    let seen = Seen {
        plan,
        cloud,
        points,
        families: &families,
        cells: cells.as_deref(),
    };
    Ok(Sample {
        points: cloud.len(),
        estimated: false,
        across: across(cloud),
        horizon: extremes(sampler.horizon().iter().copied()),
        spacing: extremes((0..cloud.len()).map(|i| cloud.spacing(i))),
        extent: cloud.domain.size().amax(),
        irregular: cloud.irregular,
        per_material,
        flow: (plan.flow.as_ref().zip(chosen)).map(|(flow, chosen)| seen.flow(flow, chosen)),
        solid: plan.mechanics.as_ref().map(|solid| seen.solid(solid)),
        coupling: plan.coupling.map(|_| seen.coupling()),
        width: width::range(plan, cloud, &sampler, points, &samples),
        rocks: rock::extremes(plan, points),
        separates: (systems(plan).into_iter())
            .filter(|system| separates(plan, cloud, points, *system).is_ok())
            .collect(),
    })
}

/// The sample of the cloud that stands in, scaled to the true one.
fn estimated<const D: usize>(plan: &Plan, outline: &CloudOutline<D>) -> Result<Sample, ModelError> {
    let small = outline.stand_in(plan.horizon)?;
    let points = properties::assign_roughly(plan, &small.places)?;
    let sample = sampled(plan, &small.cells, &points, small.horizon)?;
    let more = outline.count / sample.points as f64;
    let spacing = outline.extremes();
    // Spacings of the small cloud are all the same: mean ones, so many times coarser.
    let finer = spacing[0] / outline.spacing() / small.coarser;
    let limit = |limit: PointLimit, power: i32| PointLimit {
        dt: limit.dt * finer.powi(power),
        position: small.places.position[limit.point].iter().copied().collect(),
        point: (limit.point as f64 * more) as usize,
    };
    let horizon = match plan.horizon {
        Horizon::Radius(radius) => [radius, radius],
        _ => spacing.map(|spacing| sample.horizon[0] / sample.spacing[0] * spacing),
    };
    Ok(Sample {
        points: outline.count as usize,
        estimated: true,
        across: sample.across * small.coarser,
        horizon,
        spacing,
        extent: small.places.domain.size().amax(),
        irregular: sample.irregular,
        per_material: (sample.per_material.iter())
            .map(|&count| (count as f64 * more).round() as usize)
            .collect(),
        flow: sample.flow.map(|flow| FlowSample {
            limit: limit(flow.limit, 2),
            ..flow
        }),
        solid: sample.solid.map(|solid| SolidSample {
            waves: solid.waves.map(|waves| limit(waves, 1)),
            ..solid
        }),
        coupling: sample.coupling.map(|coupling| CoupledSample {
            limit: limit(coupling.limit, 2),
            oscillation: coupling.oscillation
                * (spacing[1] / outline.spacing() / small.coarser).powi(2),
            ..coupling
        }),
        width: sample.width,
        rocks: sample.rocks,
        separates: sample.separates,
    })
}

/// Bonds are numbered by 32 bits; building would find out only at its end.
fn check_bonds(sample: &Sample) -> Result<(), ModelError> {
    let flow = sample.flow.as_ref().map_or(0.0, |flow| flow.bonds);
    let solid = sample.solid.as_ref().map_or(0.0, |solid| solid.bonds);
    let bonds = flow.max(solid) * sample.points as f64;
    match bonds <= f64::from(u32::MAX) {
        true => Ok(()),
        false => Err(ModelError::Geometry(GeometryError::TooLarge {
            what: "bonds",
            count: bonds as usize,
        })),
    }
}

/// What all samples are taken from.
struct Seen<'a, const D: usize> {
    plan: &'a Plan,
    cloud: &'a Cloud<D>,
    points: &'a Properties,
    families: &'a [LocalFamily],
    /// With the path operator.
    cells: Option<&'a [LocalCell]>,
}

impl<const D: usize> Seen<'_, D> {
    /// κ of a point, m²/(Pa s).
    fn mobility(&self, point: usize) -> f64 {
        self.points.permeability[point] / self.plan.fluid.viscosity
    }

    fn flow(&self, flow: &FlowPlan, operator: ChosenOperator) -> FlowSample {
        let (cloud, families) = (self.cloud, self.families);
        let corrected = operator.form == Form::Correspondence
            && flow.corrects_gradient(cloud.irregular, cloud.domain.planes);
        let own_hop = families.iter().any(|family| !family.one_hop);
        let second_hop = corrected || operator.form == Form::Correspondence && own_hop;
        let hops = |family: &LocalFamily| match second_hop {
            true => family.two_hops,
            false => family.hops,
        };
        let [bonds, nonzeros, eigenvalue] = match self.cells {
            Some(cells) => [
                mean(cells, |cell| cell.bonds),
                mean(cells, |cell| cell.neighbours),
                cells.iter().map(|cell| cell.eigenvalue).fold(0.0, f64::max),
            ],
            None => [
                mean(families, |family| family.bonds),
                mean(families, hops),
                families.iter().map(|f| f.eigenvalue).fold(0.0, f64::max),
            ],
        };
        let limit = |i: usize| {
            let diffusivity = self.mobility(i) / self.explicit_storage(i);
            2.0 * cloud.spacing(i).powi(2) / (diffusivity * eigenvalue)
        };
        let points = 0..cloud.len();
        let diffusivity = |i: usize| self.mobility(i) / self.points.storage[i];
        FlowSample {
            bonds,
            nonzeros,
            operator,
            second_hop,
            corrected,
            mobility: extremes(points.clone().map(|i| self.mobility(i))),
            diffusivity: extremes(points.map(diffusivity)),
            limit: PointLimit::smallest(cloud, limit),
        }
    }

    fn solid(&self, mechanics: &MechanicsPlan) -> SolidSample {
        let cloud = self.cloud;
        let ratio = |lame: &crate::operators::Lame| 0.5 * lame.lambda / (lame.lambda + lame.mu);
        SolidSample {
            bonds: mean(self.families, |family| family.solid_bonds),
            neighbours: mean(self.families, |family| family.two_hops),
            corrected: mechanics.corrects_gradient(cloud.irregular, cloud.domain.planes),
            contrast: contrast(self.points.lame.iter().map(|lame| lame.mu)),
            volume_stiffness: (self.points.lame.iter())
                .map(|lame| lame.volume_stiffness())
                .fold(1.0, f64::max),
            poissons_ratio: self.points.lame.iter().map(ratio).fold(0.0, f64::max),
            waves: self.waves(),
        }
    }

    /// Eqs. 60 and 61 with the undrained modulus λ + 2μ + α²/s where fluid resists.
    fn waves(&self) -> Option<PointLimit> {
        let fields = Fields {
            plan: self.plan,
            cloud: self.cloud,
            material: &self.points.material,
        };
        // Told even where no effect needs it, if it is known.
        let density = fields.needed(true, "density", |own| own.density.as_ref());
        let density = density.ok()?;
        let step = |i: usize| {
            let fluid = match self.plan.coupling {
                Some(_) => self.points.biot_coefficient[i].powi(2) / self.points.storage[i],
                None => 0.0,
            };
            let modulus = self.oedometer_modulus(i) + fluid;
            WAVE_SHARE * self.cloud.spacing(i) * (density[i] / modulus).sqrt()
        };
        Some(PointLimit::smallest(self.cloud, step))
    }

    /// λ + 2μ of a point, Pa.
    fn oedometer_modulus(&self, point: usize) -> f64 {
        let lame = &self.points.lame[point];
        lame.lambda + 2.0 * lame.mu
    }
}

/// Mean of a count over samples.
fn mean<T>(samples: &[T], count: impl Fn(&T) -> usize) -> f64 {
    let sum: f64 = samples.iter().map(|sample| count(sample) as f64).sum();
    sum / samples.len().max(1) as f64
}

/// Points spread evenly over the cloud's order.
fn sampled_points(count: usize) -> Vec<usize> {
    let samples = SAMPLES.min(count);
    (0..samples)
        .map(|k| (2 * k + 1) * count / (2 * samples))
        .collect()
}

/// Points along the edge of the smallest cross-section: its extent over the mean spacing.
fn across<const D: usize>(cloud: &Cloud<D>) -> f64 {
    let size = cloud.domain.size();
    let spacing = (size.iter().product::<f64>() / cloud.len() as f64).powf(1.0 / D as f64);
    let face = size.iter().product::<f64>() / size.amax();
    face.powf(1.0 / (D as f64 - 1.0)) / spacing
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, 0.0], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}
