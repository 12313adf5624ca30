//! The model: a plan made concrete on a cloud. Pattern once, values as often as needed.

mod cloud;
mod error;
mod flow;
mod properties;
mod sample;

use std::sync::Arc;

pub use cloud::{build_cloud, build_families};
pub use error::ModelError;
pub use flow::{FixedPressure, FlowModel, exchange};
pub use sample::{Sample, sample};

use crate::geometry::{Cloud, Vector};
use crate::plan::{Plan, manufactured};
use crate::reference::ExactPressure;
use crate::report::Timers;

/// Everything a scheme needs.
pub struct Model<const D: usize> {
    /// The points.
    pub cloud: Arc<Cloud<D>>,
    /// Index into the plan's materials per point, shape `(n,)`.
    pub material: Vec<u16>,
    /// Permeability per point, m², shape `(n,)`.
    pub permeability: Vec<f64>,
    /// The flow problem.
    pub flow: FlowModel<D>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl<const D: usize> Model<D> {
    /// Builds cloud, families, operators and effects that the plan names.
    ///
    /// # Errors
    /// [`ModelError`], which says what in the plan does not fit.
    pub fn build(plan: &Plan, timers: &mut Timers) -> Result<Self, ModelError> {
        let Some(flow) = &plan.flow else {
            return Err(ModelError::NothingToDo);
        };
        let (cloud, table) = timers.time("cloud", || build_cloud::<D>(plan))?;
        let cloud = Arc::new(cloud);
        let families = timers.time("families", || build_families(plan, &cloud))?;
        let points = properties::assign(plan, &cloud, table)?;
        let mut warnings = Vec::new();
        let flow = timers.time("operators", || {
            FlowModel::build(plan, flow, &cloud, families, &points, &mut warnings)
        })?;
        let mut flow = timers.time("assembly", || flow.assemble(plan))?;
        if let Ok(Some(solution)) = manufactured(plan) {
            let exact = |x: &Vector<D>| solution.pressure(x.as_slice(), 0.0);
            flow.initial = cloud.position.iter().map(exact).collect();
        }
        Ok(Model {
            cloud,
            material: points.material,
            permeability: points.permeability,
            flow,
            warnings,
        })
    }
}
