//! What a plan says about the rock.

use super::{DamagePlan, Plan};
use crate::geometry::Shape;
use crate::material::{DamageModel, Elasticity};

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
    pub storage: f64,
    /// Elastic constants of the drained rock; always there if there is mechanics.
    pub elasticity: Option<Elasticity>,
    /// Biot coefficient α; always there if flow and mechanics are coupled.
    pub biot_coefficient: Option<f64>,
    /// Density of the rock with its fluid, kg/m³; always there if its weight or inertia acts.
    pub density: Option<f64>,
    /// Energy G_c that a crack takes per area, J/m²; always there if rock can break.
    pub fracture_energy: Option<f64>,
}

/// Where a permeability comes from.
#[derive(Debug, Clone)]
pub enum PermeabilityPlan {
    /// One value, m².
    Uniform(f64),
    /// Values from a file.
    Table {
        /// The file, for messages.
        path: String,
        /// Values, m², x fastest.
        values: Vec<f64>,
        /// Cells along each axis of an array that is laid over the domain; `None` for one value per point of
        /// the cloud.
        cells: Option<Vec<usize>>,
    },
    /// A tensor in the plane.
    Tensor {
        /// Largest principal permeability, m².
        largest: f64,
        /// Components xx, yy and xy in units of it.
        shape: [f64; 3],
    },
    /// Log-normal field.
    LogNormal {
        /// Median, m².
        median: f64,
        /// Standard deviation of the decimal logarithm.
        log10_std: f64,
        /// Total range in decades, to which values are clipped; infinite for none.
        decades: f64,
        /// Correlation length, m; `None` for independent points.
        correlation_length: Option<f64>,
        /// Seed.
        seed: u64,
    },
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
}

/// Positive values with their logarithms stretched about the middle of their range, until the largest is
/// `contrast` times the smallest; `None` if they are all the same.
pub fn with_contrast(values: &[f64], contrast: f64) -> Option<Vec<f64>> {
    let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
    let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
    let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (middle, stretch) = (0.5 * (low + high), contrast.ln() / (high - low));
    let stretched = logs
        .iter()
        .map(|log| (middle + stretch * (log - middle)).exp());
    (high > low).then(|| stretched.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contrast_keeps_the_middle_and_the_order_of_values() {
        let stretched = with_contrast(&[1.0, 1e2, 1e4], 1e8).unwrap();
        for (found, wanted) in stretched.iter().zip([1e-2, 1e2, 1e6]) {
            assert!((found / wanted - 1.0).abs() < 1e-13);
        }
        let turned = with_contrast(&[1.0, 1e2, 1e4], 1e-4).unwrap();
        assert!((turned[0] / 1e4 - 1.0).abs() < 1e-13 && (turned[2] - 1.0).abs() < 1e-13);
        assert!(with_contrast(&[3.0, 3.0], 10.0).is_none());
    }
}
