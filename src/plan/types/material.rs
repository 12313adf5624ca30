//! What a plan says about the rock.

use crate::geometry::Shape;
use crate::material::Elasticity;

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
    /// One value per point of the cloud, m², from a file.
    Table {
        /// The file, for messages.
        path: String,
        /// Values, m².
        values: Vec<f64>,
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
