//! What a plan says about the rock.

use super::{DamagePlan, FieldPlan, Plan};
use crate::geometry::Shape;
use crate::material::{DamageModel, Elasticity, storage_coefficient};

/// A material and where it is.
#[derive(Debug, Clone)]
pub struct MaterialPlan {
    /// Name in the scene.
    pub name: String,
    /// Region; `None` for the background.
    pub region: Option<Shape>,
    /// Permeability; always there if there is flow.
    pub permeability: Option<PermeabilityPlan>,
    /// Storage coefficient s in 1/Pa, given or from Eq. 38; 1 where nothing needs it.
    pub storage: StoragePlan,
    /// Elastic constants of the drained rock; always there if there is mechanics.
    pub elasticity: Option<ElasticityPlan>,
    /// Biot coefficient α; always there if flow and mechanics are coupled.
    pub biot_coefficient: Option<FieldPlan>,
    /// Density of the rock with its fluid, kg/m³; always there if its weight or inertia acts.
    pub density: Option<FieldPlan>,
    /// Energy G_c that a crack takes per area, J/m²; always there if rock can break.
    pub fracture_energy: Option<FieldPlan>,
}

impl MaterialPlan {
    /// The elastic constants, if they are the same everywhere in the material.
    pub fn uniform_elasticity(&self) -> Option<Elasticity> {
        self.elasticity.as_ref()?.uniform()
    }
}

/// Where a permeability comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum PermeabilityPlan {
    /// The same in all directions, m².
    Field(FieldPlan),
    /// A tensor in the plane.
    Tensor {
        /// Largest principal permeability, m².
        largest: f64,
        /// Components xx, yy and xy in units of it.
        shape: [f64; 3],
    },
}

impl PermeabilityPlan {
    /// The permeability, m², if it is the same everywhere and in all directions.
    pub fn uniform(&self) -> Option<f64> {
        match self {
            Self::Field(field) => field.uniform(),
            Self::Tensor { .. } => None,
        }
    }
}

/// Where the storage of a material comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum StoragePlan {
    /// Storage coefficient, 1/Pa: given, or from Eq. 38 where all in it is the same everywhere.
    Given(FieldPlan),
    /// From Eq. 38 point by point.
    Porous(PorousPlan),
}

impl StoragePlan {
    /// The coefficient, 1/Pa, if it is the same everywhere in the material.
    pub fn uniform(&self) -> Option<f64> {
        match self {
            Self::Given(field) => field.uniform(),
            Self::Porous(_) => None,
        }
    }

    /// Smallest coefficient to be expected, 1/Pa, see [`FieldPlan::range`].
    pub fn least(&self) -> f64 {
        match self {
            Self::Given(field) => field.range()[0],
            Self::Porous(porous) => porous.least(),
        }
    }
}

/// What Eq. 38 makes storage of, where some of it varies.
#[derive(Debug, Clone, PartialEq)]
pub struct PorousPlan {
    /// Porosity n.
    pub porosity: FieldPlan,
    /// Biot coefficient α.
    pub biot_coefficient: FieldPlan,
    /// Bulk modulus of the rock, Pa.
    pub bulk_modulus: FieldPlan,
    /// Bulk modulus of the fluid, Pa; infinite where it has none.
    pub fluid: f64,
}

impl PorousPlan {
    /// Smallest storage in the box of all ranges, 1/Pa; porosities above the Biot coefficient left out.
    fn least(&self) -> f64 {
        let ranges = [&self.porosity, &self.biot_coefficient, &self.bulk_modulus];
        let ranges = ranges.map(FieldPlan::range);
        let corner = |k: usize| {
            let [n, alpha, rock] = std::array::from_fn(|axis| ranges[axis][k >> axis & 1]);
            storage_coefficient(n.min(alpha), alpha, rock, self.fluid)
        };
        (0..8).map(corner).fold(f64::INFINITY, f64::min)
    }
}

/// Elastic constants of a material.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticityPlan {
    /// Young's modulus E, Pa.
    pub youngs_modulus: FieldPlan,
    /// Poisson's ratio ν.
    pub poissons_ratio: FieldPlan,
}

impl ElasticityPlan {
    /// The constants, if they are the same everywhere in the material.
    pub fn uniform(&self) -> Option<Elasticity> {
        Some(Elasticity {
            youngs_modulus: self.youngs_modulus.uniform()?,
            poissons_ratio: self.poissons_ratio.uniform()?,
        })
    }

    /// The softest rocks to be expected: the smallest modulus with the smallest and the largest ratio.
    pub fn softest(&self) -> [Elasticity; 2] {
        let youngs_modulus = self.youngs_modulus.range()[0];
        self.poissons_ratio
            .range()
            .map(|poissons_ratio| Elasticity {
                youngs_modulus,
                poissons_ratio,
            })
    }
}

impl Plan {
    /// Whether cracks hold fluid of their own, beside that in the pores: flow in fractures of the split model.
    pub fn has_crack_fluid(&self) -> bool {
        let split = |damage: &DamagePlan| damage.model == DamageModel::Split;
        self.fracture_flow.is_some() && self.damage.as_ref().is_some_and(split)
    }

    /// Whether flow meets a permeability that is a tensor.
    pub fn has_tensors(&self) -> bool {
        let is_tensor =
            |own: &MaterialPlan| matches!(own.permeability, Some(PermeabilityPlan::Tensor { .. }));
        self.flow.is_some() && self.materials.iter().any(is_tensor)
    }

    /// Whether elastic constants vary within a material.
    pub fn has_elastic_fields(&self) -> bool {
        let varies = |own: &ElasticityPlan| own.uniform().is_none();
        let mut elastic = (self.materials.iter()).filter_map(|own| own.elasticity.as_ref());
        elastic.any(varies)
    }
}
