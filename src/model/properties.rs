//! Materials and properties of the points.

use std::borrow::Cow;

use crate::geometry::{Cloud, Vector};
use crate::operators::{Lame, PlaneTensor};
use crate::plan::{FieldPlan, MaterialPlan, PermeabilityPlan, Plan, PointTable};

use super::ModelError;
use super::fields::Fields;

/// Properties per point.
pub(crate) struct Properties {
    /// Index into the plan's materials.
    pub material: Vec<u16>,
    /// Permeability, m²; the largest principal one where it is a tensor.
    pub permeability: Vec<f64>,
    /// Tensor per unit of the permeability; empty where no material has any.
    pub tensor: Vec<PlaneTensor>,
    /// Storage coefficient, 1/Pa.
    pub storage: Vec<f64>,
    /// Elastic constants; empty without mechanics.
    pub lame: Vec<Lame>,
    /// Biot's coefficient; empty without coupling.
    pub biot_coefficient: Vec<f64>,
    /// Bulk density, kg/m³; empty where no effect needs it.
    pub density: Vec<f64>,
    /// Fracture energy G_c, J/m²; empty without damage.
    pub fracture_energy: Vec<f64>,
}

const NONE: u16 = u16::MAX;

/// Gives every point its material and properties.
///
/// # Errors
/// [`ModelError`] for regions without points, points without material, and files that do not fit.
pub(crate) fn assign<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    table: Option<&PointTable>,
) -> Result<Properties, ModelError> {
    let material = match table.and_then(|table| table.material.as_ref()) {
        Some(names) => by_name(plan, names)?,
        None => by_region(plan, cloud)?,
    };
    assigned(plan, cloud, table, material)
}

/// Gives the points of a cloud that stands for a finer one materials and properties: regions that it is
/// too coarse for are left out, and gaps between regions get the first material.
///
/// # Errors
/// [`ModelError::MissingProperty`].
pub(crate) fn assign_roughly<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
) -> Result<Properties, ModelError> {
    let material = |x: &Vector<D>| material_at(plan, x).unwrap_or(0);
    let material = cloud.position.iter().map(material).collect();
    assigned(plan, cloud, None, material)
}

/// The material of a place: the last one whose region holds it, else the one without a region.
pub(crate) fn material_at<const D: usize>(plan: &Plan, x: &Vector<D>) -> Option<u16> {
    let holds = |own: &MaterialPlan| match &own.region {
        Some(region) => region.contains(x.as_slice()),
        None => false,
    };
    let background = || plan.materials.iter().position(|m| m.region.is_none());
    let last = plan.materials.iter().rposition(holds);
    last.or_else(background).map(|k| k as u16)
}

fn assigned<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    table: Option<&PointTable>,
    material: Vec<u16>,
) -> Result<Properties, ModelError> {
    let fields = Fields {
        plan,
        cloud,
        material: &material,
    };
    let mut permeability = match plan.flow {
        Some(_) => permeabilities(&fields)?,
        None => Vec::new(),
    };
    if let Some(values) = table.and_then(|table| table.permeability.as_ref()) {
        permeability.clone_from(values);
    }
    let mechanics = plan.mechanics.as_ref();
    let heavy = mechanics.is_some_and(|m| m.inertia || plan.gravity.is_some());
    let (coupled, breaks) = (plan.coupling.is_some(), plan.damage.is_some());
    Ok(Properties {
        permeability,
        tensor: tensors(plan, &material),
        storage: fields.storage()?,
        lame: match mechanics {
            Some(_) => fields.lame()?,
            None => Vec::new(),
        },
        biot_coefficient: fields.needed(coupled, "biot_coefficient", |own| {
            own.biot_coefficient.as_ref()
        })?,
        density: fields.needed(heavy, "density", |own| own.density.as_ref())?,
        fracture_energy: fields.needed(breaks, "fracture_energy", |own| {
            own.fracture_energy.as_ref()
        })?,
        material,
    })
}

fn by_name(plan: &Plan, names: &[String]) -> Result<Vec<u16>, ModelError> {
    let index = |name: &String| {
        let found = plan
            .materials
            .iter()
            .position(|material| material.name == *name);
        found
            .map(|k| k as u16)
            .ok_or_else(|| ModelError::UnknownMaterial { name: name.clone() })
    };
    if let Some(own) = plan.materials.iter().find(|own| own.region.is_some()) {
        let material = own.name.clone();
        return Err(ModelError::UnusedRegion { material });
    }
    names.iter().map(index).collect()
}

fn by_region<const D: usize>(plan: &Plan, cloud: &Cloud<D>) -> Result<Vec<u16>, ModelError> {
    let mut everywhere = plan.materials.iter().filter(|m| m.region.is_none());
    if let (Some(first), Some(second)) = (everywhere.next(), everywhere.next()) {
        let (first, second) = (first.name.clone(), second.name.clone());
        return Err(ModelError::UntoldMaterial { first, second });
    }
    let background = plan.materials.iter().position(|m| m.region.is_none());
    let mut material = vec![background.map_or(NONE, |k| k as u16); cloud.len()];
    for (number, plan) in plan.materials.iter().enumerate() {
        let Some(region) = &plan.region else { continue };
        let mut found = false;
        for (own, x) in material.iter_mut().zip(&cloud.position) {
            if region.contains(x.as_slice()) {
                *own = number as u16;
                found = true;
            }
        }
        if !found {
            return Err(ModelError::EmptyRegion {
                material: plan.name.clone(),
            });
        }
    }
    let empty = |(number, own): &(usize, &MaterialPlan)| {
        own.region.is_some() && !material.contains(&(*number as u16))
    };
    if let Some((_, own)) = plan.materials.iter().enumerate().find(empty) {
        let material = own.name.clone();
        return Err(ModelError::CoveredRegion { material });
    }
    match material.iter().position(|&m| m == NONE) {
        None => Ok(material),
        Some(first) => Err(ModelError::NoMaterial {
            count: material.iter().filter(|&&m| m == NONE).count(),
            position: cloud.position[first].iter().copied().collect(),
        }),
    }
}

/// Permeability of every point, of tensors the largest one, m².
fn permeabilities<'a, const D: usize>(fields: &Fields<'a, D>) -> Result<Vec<f64>, ModelError> {
    let field = |own: &'a MaterialPlan| match &own.permeability {
        // Without flow there is none, and none is read.
        None => Cow::Owned(FieldPlan::Uniform(0.0)),
        Some(PermeabilityPlan::Field(field)) => Cow::Borrowed(field),
        Some(PermeabilityPlan::Tensor { largest, .. }) => Cow::Owned(FieldPlan::Uniform(*largest)),
    };
    let materials = fields.plan.materials.iter();
    let all: Vec<Cow<'_, FieldPlan>> = materials.map(field).collect();
    fields.spread(&all.iter().map(AsRef::as_ref).collect::<Vec<_>>())
}

/// Tensor of every point in units of its permeability.
fn tensors(plan: &Plan, material: &[u16]) -> Vec<PlaneTensor> {
    if !plan.has_tensors() {
        return Vec::new();
    }
    let shape = |own: &MaterialPlan| match own.permeability {
        Some(PermeabilityPlan::Tensor { shape, .. }) => shape,
        _ => [1.0, 1.0, 0.0],
    };
    let shapes: Vec<PlaneTensor> = plan.materials.iter().map(shape).collect();
    material.iter().map(|&m| shapes[usize::from(m)]).collect()
}
