//! Materials and permeabilities of the points.

use crate::geometry::Cloud;
use crate::material::log_normal;
use crate::plan::{PermeabilityPlan, Plan, PointTable};

use super::ModelError;

/// Properties per point.
pub struct Properties {
    /// Index into the plan's materials.
    pub material: Vec<u16>,
    /// Permeability, m².
    pub permeability: Vec<f64>,
    /// Storage coefficient, 1/Pa.
    pub storage: Vec<f64>,
}

const NONE: u16 = u16::MAX;

/// Gives every point its material and properties.
///
/// # Errors
/// [`ModelError`] for regions without points, points without material, and files that do not fit.
pub fn assign<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    table: Option<&PointTable>,
) -> Result<Properties, ModelError> {
    let material = match table.and_then(|table| table.material.as_ref()) {
        Some(names) => by_name(plan, names)?,
        None => by_region(plan, cloud)?,
    };
    let mut permeability = permeabilities(plan, cloud, &material)?;
    if let Some(values) = table.and_then(|table| table.permeability.as_ref()) {
        permeability.clone_from(values);
    }
    let storage = material
        .iter()
        .map(|&m| plan.materials[usize::from(m)].storage)
        .collect();
    Ok(Properties {
        material,
        permeability,
        storage,
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
    names.iter().map(index).collect()
}

fn by_region<const D: usize>(plan: &Plan, cloud: &Cloud<D>) -> Result<Vec<u16>, ModelError> {
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
    match material.iter().position(|&m| m == NONE) {
        None => Ok(material),
        Some(first) => Err(ModelError::NoMaterial {
            count: material.iter().filter(|&&m| m == NONE).count(),
            position: cloud.position[first].iter().copied().collect(),
        }),
    }
}

fn permeabilities<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    material: &[u16],
) -> Result<Vec<f64>, ModelError> {
    let mut permeability = vec![0.0; cloud.len()];
    for (number, plan) in plan.materials.iter().enumerate() {
        let values = match &plan.permeability {
            PermeabilityPlan::Uniform(value) => vec![*value; cloud.len()],
            PermeabilityPlan::Table { path, values } => {
                if values.len() != cloud.len() {
                    let (path, found) = (path.clone(), values.len());
                    return Err(ModelError::TableLength {
                        path,
                        found,
                        points: cloud.len(),
                    });
                }
                values.clone()
            }
            PermeabilityPlan::LogNormal {
                median,
                log10_std,
                decades,
                correlation_length,
                seed,
            } => log_normal(
                &cloud.position,
                *median,
                *log10_std,
                *decades,
                *correlation_length,
                *seed,
            ),
        };
        for ((own, value), _) in permeability
            .iter_mut()
            .zip(values)
            .zip(material)
            .filter(|(_, m)| usize::from(**m) == number)
        {
            *own = value;
        }
    }
    Ok(permeability)
}
