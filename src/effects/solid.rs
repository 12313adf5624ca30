//! Loads on the solid: tractions on sides, body forces, weight.

use super::cracks::crack_pressures;
use super::side_area::acting_area;
use super::{Counted, Effect, EffectError, own, vector};
use crate::assembly::{Planes, natural_extension, side_layer};
use crate::geometry::{Matrix, Side, Vector};
use crate::load::Load;
use crate::operators::{Elastic, column_sums, face_areas};
use crate::plan::{MechanicsPlan, Plan, Support, TractionPlan};

/// Everything loads on the solid may look at while they are built.
pub(crate) struct SolidContext<'a, const D: usize> {
    /// The plan.
    pub plan: &'a Plan,
    /// Its mechanics.
    pub mechanics: &'a MechanicsPlan,
    /// The elastic operator.
    pub elastic: &'a Elastic<D>,
    /// Bulk density per point, kg/m³; empty where no effect needs it.
    pub density: &'a [f64],
    /// Points per crack that are damaged from the start.
    pub bands: &'a [Vec<u32>],
}

type Build<const D: usize> = fn(&SolidContext<'_, D>) -> Result<Vec<Box<dyn Effect>>, EffectError>;

/// Every load with the function that builds it, or nothing if the plan does not name it.
fn registry<const D: usize>() -> [Build<D>; 6] {
    [
        tractions,
        loads,
        body_force,
        weight,
        crack_pressures,
        own::of_solid,
    ]
}

/// Builds the loads the plan names and no others.
///
/// # Errors
/// [`EffectError`] if a named load does not fit the cloud.
pub(crate) fn build_solid<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Counted>, EffectError> {
    let mut effects = Vec::new();
    for build in registry() {
        effects.extend(build(context)?.into_iter().map(Counted::new));
    }
    Ok(effects)
}

/// A force field that scales with one load over time.
pub(super) struct SolidLoad {
    pub(super) name: &'static str,
    /// Unknown and its force per unit of the load.
    pub(super) share: Vec<(u32, f64)>,
    pub(super) load: Load,
}

impl Effect for SolidLoad {
    fn name(&self) -> &'static str {
        self.name
    }

    fn add_rate(&self, time: f64, force: &mut [f64]) {
        let load = self.load.at(time);
        for &(unknown, share) in &self.share {
            force[unknown as usize] += share * load;
        }
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.load.breakpoints().to_vec()
    }

    fn bytes(&self) -> usize {
        self.share.len() * size_of::<(u32, f64)>()
    }
}

/// Area of a one-sided side per point, spread over its layer as the discrete divergence theorem
/// asks for, shape `(n,)`, m^(D−1).
///
/// A uniform stress is then in equilibrium with its traction to rounding error.
pub(crate) fn side_areas<const D: usize>(elastic: &Elastic<D>, side: Side) -> Vec<f64> {
    let around = &elastic.around;
    let natural = natural_extension(around, side.axis, &Planes::of(&elastic.extension));
    let weight = |axis: usize, bond: usize| match axis == side.axis {
        true => elastic.gradient.weight[bond][axis],
        false => 0.0,
    };
    let sums = column_sums(around, weight, |_, bond| {
        natural.sign(around.families.image(bond))
    });
    // Faces of cracks near the side are no part of it.
    let faces = face_areas(around, 0..u16::MAX, |_, image| natural.sign(image));
    let near = side_layer(around, side);
    let face = |point: usize| faces.as_ref().map_or(0.0, |faces| faces[point][side.axis]);
    let area = |(point, sum): (usize, &Vector<D>)| match near[point] {
        true => side.outward() * (sum[side.axis] - face(point)),
        false => 0.0,
    };
    sums.iter().enumerate().map(area).collect()
}

/// The areas of a side that is loaded, shape `(n,)`, m^(D−1).
///
/// # Errors
/// [`EffectError::SideArea`] if they add up to another area than that of the side.
pub(crate) fn loaded_side<const D: usize>(
    elastic: &Elastic<D>,
    side: Side,
) -> Result<Vec<f64>, EffectError> {
    let mut area = side_areas(elastic, side);
    let cloud = &elastic.around.cloud;
    let found = area.iter().sum();
    let acting = acting_area(cloud, side, found)?;
    if !cloud.filled || cloud.outline.is_some() {
        area.iter_mut().for_each(|area| *area *= acting / found);
    }
    Ok(area)
}

fn traction<const D: usize>(
    name: &'static str,
    area: &[f64],
    components: &[Load],
) -> Vec<Box<dyn Effect>> {
    let acts = |load: &&(usize, &Load)| load.1.values().iter().any(|v| v.abs() > 0.0);
    let largest = area.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    components
        .iter()
        .enumerate()
        .collect::<Vec<_>>()
        .iter()
        .filter(acts)
        .map(|(axis, load)| {
            let share = area
                .iter()
                .enumerate()
                .filter(|(_, a)| a.abs() > 1e-14 * largest)
                .map(|(point, a)| ((point * D + axis) as u32, *a))
                .collect();
            Box::new(SolidLoad {
                name,
                share,
                load: (*load).clone(),
            }) as Box<dyn Effect>
        })
        .collect()
}

fn tractions<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let mut effects = Vec::new();
    for side in Side::all(D) {
        if let Support::Traction(components) = &context.mechanics.sides[side.index()] {
            let area = loaded_side(context.elastic, side)?;
            effects.extend(traction::<D>("traction", &area, components));
        }
    }
    Ok(effects)
}

fn loads<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let mut effects = Vec::new();
    for load in &context.mechanics.loads {
        let area = loaded_area(context.elastic, load)?;
        effects.extend(traction::<D>("loads", &area, &load.traction));
    }
    Ok(effects)
}

/// Area of the part of a side that a load names, per point.
fn loaded_area<const D: usize>(
    elastic: &Elastic<D>,
    load: &TractionPlan,
) -> Result<Vec<f64>, EffectError> {
    let mut area = loaded_side(elastic, load.side)?;
    let cloud = &elastic.around.cloud;
    if let Some(region) = &load.region {
        let plane = cloud.domain.plane(load.side);
        for (own, x) in area.iter_mut().zip(&cloud.position) {
            let mut foot = *x;
            foot[load.side.axis] = plane;
            if !region.contains(foot.as_slice()) {
                *own = 0.0;
            }
        }
    }
    match area.iter().sum::<f64>() > 0.0 {
        true => Ok(area),
        false => Err(EffectError::EmptyLoad {
            name: load.name.clone(),
            side: load.side.name(),
        }),
    }
}

/// Forces that do not change in time.
struct ConstantForce {
    name: &'static str,
    force: Vec<f64>,
}

impl Effect for ConstantForce {
    fn name(&self) -> &'static str {
        self.name
    }

    fn add_rate(&self, _time: f64, force: &mut [f64]) {
        force
            .iter_mut()
            .zip(&self.force)
            .for_each(|(total, own)| *total += own);
    }

    fn bytes(&self) -> usize {
        8 * self.force.len()
    }
}

fn constant(name: &'static str, force: Vec<f64>) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    Ok(vec![Box::new(ConstantForce { name, force })])
}

fn body_force<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(body) = &context.mechanics.body_force else {
        return Ok(Vec::new());
    };
    let volume = &context.elastic.around.cloud.volume;
    constant(
        "body-force",
        volume
            .iter()
            .flat_map(|v| body.iter().map(move |b| b * v))
            .collect(),
    )
}

fn weight<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(gravity) = &context.plan.gravity else {
        return Ok(Vec::new());
    };
    let acceleration: Vector<D> = vector(&gravity.acceleration);
    let masses = context
        .density
        .iter()
        .zip(&context.elastic.around.cloud.volume);
    let force = masses.flat_map(|(d, v)| (0..D).map(move |axis| d * v * acceleration[axis]));
    constant("weight", force.collect())
}

/// −Bᵀ V σ⁰: the force of a stress per point that is there before anything strains, shape `(n·D,)`, N.
pub(crate) fn initial_force<const D: usize>(
    elastic: &Elastic<D>,
    stress: &[Matrix<D>],
) -> Vec<f64> {
    let families = &elastic.around.families;
    let forces: Vec<Vector<D>> = (0..elastic.points())
        .flat_map(|owner| {
            let pull = stress[owner] * -elastic.around.cloud.volume[owner];
            families
                .family(owner)
                .map(move |bond| pull * elastic.gradient.weight[bond])
        })
        .collect();
    elastic.gather(&forces)
}

/// Symmetric tensor from xx, yy, zz, xy, yz, xz.
pub(crate) fn tensor<const D: usize>(components: &[f64; 6]) -> Matrix<D> {
    Matrix::from_fn(|a, b| match (a.min(b), a.max(b)) {
        (a, b) if a == b => components[a],
        (0, 1) => components[3],
        (1, _) => components[4],
        _ => components[5],
    })
}
