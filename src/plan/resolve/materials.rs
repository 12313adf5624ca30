//! What the rock and its fluid are like.

use super::Resolver;
use crate::material::{Elasticity, storage_coefficient};
use crate::plan::files::{check_length, read_permeability};
use crate::plan::types::{FluidPlan, GeometryPlan, MaterialPlan, PermeabilityPlan};
use crate::scene;

impl Resolver<'_> {
    pub(super) fn material(
        &mut self,
        name: &str,
        material: &scene::Material,
        geometry: Option<&GeometryPlan>,
    ) -> Option<MaterialPlan> {
        let permeability = match &material.permeability {
            Some(field) => Some(self.permeability(field, geometry)?),
            None => None,
        };
        Some(MaterialPlan {
            name: name.to_owned(),
            region: material.region.as_ref().map(|region| region.resolved()),
            permeability,
            storage: storage(&self.loaded.scene, material),
            elasticity: elasticity(material),
            biot_coefficient: material.biot_coefficient.map(|value| value.value()),
            density: material.density.map(|value| value.value()),
            fracture_energy: material.fracture_energy.map(|value| value.value()),
        })
    }

    fn permeability(
        &mut self,
        field: &scene::PermeabilityField,
        geometry: Option<&GeometryPlan>,
    ) -> Option<PermeabilityPlan> {
        Some(match field {
            scene::PermeabilityField::Value(value) => PermeabilityPlan::Uniform(value.value()),
            scene::PermeabilityField::File(file) => self.permeability_file(file, geometry)?,
            scene::PermeabilityField::Distribution(field) => PermeabilityPlan::LogNormal {
                median: field.median.value(),
                log10_std: field.log10_std.value(),
                decades: field
                    .decades
                    .map_or(f64::INFINITY, |decades| decades.value()),
                correlation_length: field.correlation_length.map(|length| length.value()),
                seed: field.seed,
            },
        })
    }

    fn permeability_file(
        &mut self,
        file: &scene::PermeabilityFile,
        geometry: Option<&GeometryPlan>,
    ) -> Option<PermeabilityPlan> {
        let path = self.loaded.path(&file.file);
        let column = file.column.as_ref().map(|column| column.value.as_str());
        let cells = geometry.and_then(GeometryPlan::cells);
        let points = geometry.and_then(GeometryPlan::count);
        let read = read_permeability(&path, column)
            .and_then(|table| match geometry {
                Some(_) => table.in_point_order(&path, cells.as_deref()),
                // The fault of the geometry is told; its points are not known.
                None => Ok(table.values),
            })
            .and_then(|values| {
                check_length(&file.file, values.len(), points.unwrap_or(values.len()))?;
                Ok(values)
            });
        match read {
            Ok(values) => Some(PermeabilityPlan::Table {
                path: file.file.value.clone(),
                values,
            }),
            Err(error) => self.fault(file.file.span, error),
        }
    }
}

pub(super) fn fluid(scene: &scene::Scene) -> FluidPlan {
    let fluid = scene.fluid.as_ref();
    FluidPlan {
        viscosity: fluid.map_or(1.0, |fluid| fluid.viscosity.value()),
        density: fluid.map_or(1000.0, |fluid| fluid.density.value()),
    }
}

fn elasticity(material: &scene::Material) -> Option<Elasticity> {
    Some(Elasticity {
        youngs_modulus: material.youngs_modulus?.value(),
        poissons_ratio: material.poissons_ratio?.value(),
    })
}

/// Storage of a material. A steady run needs none; there it only weighs how a sealed part shares a
/// constant, evenly by volume.
fn storage(scene: &scene::Scene, material: &scene::Material) -> f64 {
    match material.storage() {
        None => 1.0,
        Some(scene::Storage::Given(storage)) => storage,
        Some(scene::Storage::Derived {
            porosity,
            biot_coefficient,
            bulk_modulus,
        }) => {
            let fluid = scene.fluid.as_ref().and_then(|fluid| fluid.bulk_modulus);
            let fluid = fluid.map_or(f64::INFINITY, |modulus| modulus.value());
            storage_coefficient(porosity, biot_coefficient, bulk_modulus, fluid)
        }
    }
}
