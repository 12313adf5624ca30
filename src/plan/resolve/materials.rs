//! What the rock and its fluid are like.

use super::Resolver;
use crate::material::{Elasticity, storage_coefficient};
use crate::plan::types::{FluidPlan, GeometryPlan, MaterialPlan};
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
