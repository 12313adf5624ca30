//! What the rock and its fluid are like.

use super::Resolver;
use crate::material::storage_coefficient;
use crate::plan::files::{Allowed, Property};
use crate::plan::types::{
    ElasticityPlan, FieldPlan, FluidPlan, GeometryPlan, MaterialPlan, PorousPlan, StoragePlan,
};
use crate::scene::{self, Dimension, Typed};

/// Where a material is read: the points it is for.
type Points<'a> = Option<&'a GeometryPlan>;

impl Resolver<'_> {
    pub(super) fn material(
        &mut self,
        name: &str,
        material: &scene::Material,
        geometry: Points<'_>,
    ) -> Option<MaterialPlan> {
        let permeability = match &material.permeability {
            Some(field) => Some(self.permeability(field, geometry)?),
            None => None,
        };
        let biot = material.biot_coefficient.as_ref().map(|own| own.typed());
        let biot = self.given(biot, Property::BIOT_COEFFICIENT, geometry)?;
        let energy = material.fracture_energy.as_ref().map(|own| own.typed());
        let density = material.density.as_ref().map(|own| own.typed());
        Some(MaterialPlan {
            name: name.to_owned(),
            region: material.region.as_ref().map(|region| region.resolved()),
            permeability,
            storage: self.storage(material, biot.as_ref(), geometry)?,
            elasticity: self.elasticity(material, geometry)?,
            density: self.given(density, Property::DENSITY, geometry)?,
            fracture_energy: self.given(energy, Property::FRACTURE_ENERGY, geometry)?,
            biot_coefficient: biot,
        })
    }

    /// The values of a property; within, `None` where it was not typed.
    fn given<D: Dimension>(
        &mut self,
        typed: Option<Typed<'_, D>>,
        property: Property,
        geometry: Points<'_>,
    ) -> Option<Option<FieldPlan>> {
        match typed {
            Some(typed) => self.field(typed, property, geometry).map(Some),
            None => Some(None),
        }
    }

    fn elasticity(
        &mut self,
        material: &scene::Material,
        geometry: Points<'_>,
    ) -> Option<Option<ElasticityPlan>> {
        let modulus = material.youngs_modulus.as_ref().map(|own| own.typed());
        let ratio = material.poissons_ratio.as_ref().map(|own| own.typed());
        let modulus = self.given(modulus, Property::YOUNGS_MODULUS, geometry)?;
        let ratio = self.given(ratio, Property::POISSONS_RATIO, geometry)?;
        Some(modulus.zip(ratio).map(|(modulus, ratio)| ElasticityPlan {
            youngs_modulus: modulus,
            poissons_ratio: ratio,
        }))
    }

    /// Storage of a material. A steady run needs none; there it only weighs how a sealed part shares a
    /// constant, evenly by volume.
    fn storage(
        &mut self,
        material: &scene::Material,
        biot: Option<&FieldPlan>,
        geometry: Points<'_>,
    ) -> Option<StoragePlan> {
        let storage = material.storage.as_ref().map(|own| own.typed());
        if let Some(given) = self.given(storage, Property::STORAGE, geometry)? {
            return Some(StoragePlan::Given(given));
        }
        let porosity = material.porosity.as_ref().map(|own| own.typed());
        let allowed = porosity_up_to(biot.and_then(FieldPlan::uniform));
        let porosity = self.given(porosity, allowed, geometry)?;
        let rock = material.bulk_modulus.as_ref().map(|own| own.typed());
        let rock = self.given(rock, Property::BULK_MODULUS, geometry)?;
        let parts = porosity.zip(biot.cloned()).zip(rock);
        let Some(((porosity, biot_coefficient), bulk_modulus)) = parts else {
            return Some(StoragePlan::Given(FieldPlan::Uniform(1.0)));
        };
        let fluid = (self.loaded.scene.fluid.as_ref()).and_then(|fluid| fluid.bulk_modulus);
        let porous = PorousPlan {
            porosity,
            biot_coefficient,
            bulk_modulus,
            fluid: fluid.map_or(f64::INFINITY, |modulus| modulus.value()),
        };
        Some(match porous.uniform() {
            Some(storage) => StoragePlan::Given(FieldPlan::Uniform(storage)),
            None => StoragePlan::Porous(porous),
        })
    }
}

/// Porosities up to the Biot coefficient, where that is one value.
fn porosity_up_to(biot: Option<f64>) -> Property {
    match biot {
        None => Property::POROSITY,
        Some(biot) => Property {
            allowed: Allowed::Share {
                most: biot,
                why: "the Biot coefficient must not be below the porosity (Eq. 38)",
            },
            ..Property::POROSITY
        },
    }
}

impl PorousPlan {
    /// Storage, 1/Pa, where all that it is made of is the same everywhere.
    fn uniform(&self) -> Option<f64> {
        Some(storage_coefficient(
            self.porosity.uniform()?,
            self.biot_coefficient.uniform()?,
            self.bulk_modulus.uniform()?,
            self.fluid,
        ))
    }
}

pub(super) fn fluid(scene: &scene::Scene) -> FluidPlan {
    let fluid = scene.fluid.as_ref();
    FluidPlan {
        viscosity: fluid.map_or(1.0, |fluid| fluid.viscosity.value()),
        density: fluid.map_or(1000.0, |fluid| fluid.density.value()),
    }
}
