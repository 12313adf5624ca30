//! What the rock and its fluid are like.

use super::Resolver;
use crate::material::storage_coefficient;
use crate::plan::files::{Allowed, Property};
use crate::plan::types::{
    ElasticityPlan, FieldPlan, FluidPlan, GeometryPlan, MaterialPlan, PorousPlan, StoragePlan,
};
use crate::scene::{self, Dimension, Field, Quantity, ReadField, Spanned};

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
        let biot = &material.biot_coefficient;
        let biot = self.read(biot, Property::BIOT_COEFFICIENT, geometry)?;
        let energy = &material.fracture_energy;
        Some(MaterialPlan {
            name: name.to_owned(),
            region: material.region.as_ref().map(|region| region.resolved()),
            permeability,
            storage: self.storage(material, biot.as_ref(), geometry)?,
            elasticity: self.elasticity(material, geometry)?,
            density: self.any(&material.density, Property::DENSITY, geometry)?,
            fracture_energy: self.any(energy, Property::FRACTURE_ENERGY, geometry)?,
            biot_coefficient: biot,
        })
    }

    /// A field that may be drawn at random; within, `None` where it was not typed.
    fn any<D: Dimension>(
        &mut self,
        typed: &Option<Spanned<Field<Quantity<D>>>>,
        property: Property,
        geometry: Points<'_>,
    ) -> Option<Option<FieldPlan>> {
        match typed {
            Some(own) => self.field(own.typed(), property, geometry).map(Some),
            None => Some(None),
        }
    }

    /// A field that may come from a file; within, `None` where it was not typed.
    fn read<D: Dimension>(
        &mut self,
        typed: &Option<Spanned<ReadField<Quantity<D>>>>,
        property: Property,
        geometry: Points<'_>,
    ) -> Option<Option<FieldPlan>> {
        match typed {
            Some(own) => self.field(own.typed(), property, geometry).map(Some),
            None => Some(None),
        }
    }

    fn elasticity(
        &mut self,
        material: &scene::Material,
        geometry: Points<'_>,
    ) -> Option<Option<ElasticityPlan>> {
        let (modulus, ratio) = (&material.youngs_modulus, &material.poissons_ratio);
        let modulus = self.any(modulus, Property::YOUNGS_MODULUS, geometry)?;
        let ratio = self.read(ratio, Property::POISSONS_RATIO, geometry)?;
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
        if let Some(given) = self.any(&material.storage, Property::STORAGE, geometry)? {
            return Some(StoragePlan::Given(given));
        }
        let porosity = porosity_up_to(biot.and_then(FieldPlan::uniform));
        let porosity = self.any(&material.porosity, porosity, geometry)?;
        let rock = self.read(&material.bulk_modulus, Property::BULK_MODULUS, geometry)?;
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
