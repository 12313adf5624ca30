//! What a plan will do and cost, told before anything large is built.

mod choices;
mod effects;
mod limits;
mod numbers;
mod scheme;
mod size;
#[cfg(test)]
mod tests;
mod text;

use serde::Serialize;

pub use choices::{CHOICES, Choice, Choices, choice};
pub use text::bytes;

use crate::model::{Model, ModelError, Sample, sample, width_doubts};
use crate::plan::Plan;
use crate::plan::capability::System;
use crate::report::Timers;

/// The explanation of a plan; printed as text or JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Explanation {
    /// Name of the case.
    pub case: String,
    /// Its title.
    pub title: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Number of points.
    pub points: usize,
    /// Whether the cloud is too large to be made here, so that a small one like it was sampled.
    pub estimated: bool,
    /// Number of unknowns of all fields.
    pub unknowns: usize,
    /// Smallest and largest spacing, m.
    pub spacing: [f64; 2],
    /// Smallest and largest horizon, m.
    pub horizon: [f64; 2],
    /// Points per material.
    pub materials: Vec<(String, usize)>,
    /// What runs and why.
    pub effects: Vec<Reason>,
    /// Diffusion operator and how far it reaches.
    pub operator: Option<Reason>,
    /// Elastic operator and how far it reaches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elasticity: Option<Reason>,
    /// Time scheme.
    pub scheme: Reason,
    /// Linear solver.
    pub solver: Reason,
    /// Estimated number of bonds; those of flow, if there is flow.
    pub bonds: u64,
    /// Estimated nonzeros of the operators of flow and of mechanics.
    pub nonzeros: u64,
    /// Estimated sizes of the matrices: the operators, and what a scheme puts together from both.
    pub matrices: Vec<MatrixSize>,
    /// Estimated memory, bytes.
    pub memory: Memory,
    /// Limits of the time step.
    pub limits: Vec<Limit>,
    /// Dimensionless numbers.
    pub numbers: Vec<Number>,
    /// Doubts.
    pub warnings: Vec<String>,
}

/// Something chosen, and why.
#[derive(Debug, Clone, Serialize)]
pub struct Reason {
    /// What.
    pub name: String,
    /// Why.
    pub why: String,
}

/// Estimated size of a matrix.
#[derive(Debug, Clone, Serialize)]
pub struct MatrixSize {
    /// What it belongs to.
    pub name: &'static str,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Nonzeros.
    pub nonzeros: u64,
    /// Whether systems with it are solved.
    pub solved: bool,
    /// Memory of pattern and values, bytes.
    pub bytes: u64,
    /// Memory of its factor or of the levels of multigrid, bytes; 0 without.
    pub factor: u64,
    /// Operations of one factorisation; 0 without a factor.
    pub factor_flops: f64,
}

/// Estimated memory in bytes.
#[derive(Debug, Clone, Serialize)]
pub struct Memory {
    /// Bonds and their weights.
    pub bonds: u64,
    /// Stored gradients of the second hop.
    pub gradients: u64,
    /// Matrices.
    pub matrices: u64,
    /// Factors of the direct solvers, if any are used.
    pub factor: u64,
    /// Fields and work vectors.
    pub fields: u64,
    /// All together.
    pub total: u64,
    /// What the program takes at its highest: with copies of what is being put together.
    pub peak: u64,
}

/// A limit of the time step.
#[derive(Debug, Clone, Serialize)]
pub struct Limit {
    /// The scheme it binds.
    pub scheme: String,
    /// The limit, s.
    pub dt: f64,
    /// Steps to the end at this limit.
    pub steps: Option<u64>,
    /// What sets it.
    pub limiter: String,
}

/// A dimensionless number.
#[derive(Debug, Clone, Serialize)]
pub struct Number {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// What it tells.
    pub meaning: String,
}

/// Explains a plan.
///
/// # Errors
/// [`ModelError`] as building the model would give.
pub fn explain(plan: &Plan) -> Result<Explanation, ModelError> {
    match plan.dimension {
        2 => explain_in::<2>(plan),
        _ => explain_in::<3>(plan),
    }
}

fn explain_in<const D: usize>(plan: &Plan) -> Result<Explanation, ModelError> {
    let sample = sample::<D>(plan)?;
    let built = doubts_of_model::<D>(plan, &sample)?;
    let matrices = size::matrices(plan, &sample);
    let held = matrices
        .iter()
        .filter(|m| m.name != System::Monolithic.name());
    let fields = usize::from(sample.flow.is_some()) + D * usize::from(sample.solid.is_some());
    let bonds = match (&sample.flow, &sample.solid) {
        (Some(flow), _) => flow.bonds,
        (None, solid) => solid.as_ref().map_or(0.0, |solid| solid.bonds),
    };
    let names = plan.materials.iter().map(|material| material.name.clone());
    Ok(Explanation {
        case: plan.case.clone(),
        title: plan.title.clone(),
        dimension: D,
        points: sample.points,
        estimated: sample.estimated,
        unknowns: fields * sample.points,
        spacing: sample.spacing,
        horizon: sample.horizon,
        materials: names.zip(sample.per_material.iter().copied()).collect(),
        effects: effects::effects(plan),
        operator: effects::operator(&sample),
        elasticity: effects::elasticity(plan, &sample),
        scheme: scheme::scheme(plan),
        bonds: (bonds * sample.points as f64) as u64,
        nonzeros: held.map(|matrix| matrix.nonzeros).sum(),
        memory: size::memory(plan, &sample, &matrices),
        matrices,
        solver: scheme::solver(plan, &sample),
        limits: limits::limits(plan, &sample),
        numbers: numbers::numbers(plan, &sample),
        warnings: warnings(plan, &sample, built),
    })
}

/// Points up to which a cloud is built to find what its operators and loads object to.
const BUILT: usize = 5000;

/// Doubts of the model itself, where points are uneven and few: voids, bounds and moments show there only.
fn doubts_of_model<const D: usize>(
    plan: &Plan,
    sample: &Sample,
) -> Result<Option<Vec<String>>, ModelError> {
    if !sample.irregular || sample.points > BUILT {
        return Ok(None);
    }
    let model = Model::<D>::build(plan, &mut Timers::default())?;
    Ok(Some(model.warnings))
}

/// Doubts of the plan, and those that need the cloud.
fn warnings(plan: &Plan, sample: &Sample, built: Option<Vec<String>>) -> Vec<String> {
    let sampled = || {
        let (horizon, spacing) = (sample.horizon[0], sample.spacing[0]);
        let widths = width_doubts(plan, sample.irregular, horizon, spacing);
        let operator = (sample.flow.as_ref()).and_then(|flow| flow.operator.doubt.clone());
        widths.into_iter().chain(operator).collect()
    };
    let cloud = built.unwrap_or_else(sampled);
    plan.warnings.iter().cloned().chain(cloud).collect()
}

fn reason(name: impl Into<String>, why: impl Into<String>) -> Reason {
    Reason {
        name: name.into(),
        why: why.into(),
    }
}
