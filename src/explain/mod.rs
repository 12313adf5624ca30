//! What a plan will do and cost, told before anything large is built.

mod text;

use perifrac_solvers::choose_by_size;
use serde::Serialize;

use crate::model::{ModelError, Sample, sample};
use crate::plan::{OperatorChoice, Plan, SchemeChoice, StepRule, TimeMode};

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
    /// Number of unknowns of the linear system.
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
    pub operator: Reason,
    /// Time scheme.
    pub scheme: Reason,
    /// Linear solver.
    pub solver: Reason,
    /// Estimated number of bonds.
    pub bonds: u64,
    /// Estimated nonzeros of the matrix.
    pub nonzeros: u64,
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

/// Estimated memory in bytes.
#[derive(Debug, Clone, Serialize)]
pub struct Memory {
    /// Bonds and their weights.
    pub bonds: u64,
    /// Stored gradients of the second hop.
    pub gradients: u64,
    /// Matrices.
    pub matrices: u64,
    /// Factor of the direct solver, if one is used.
    pub factor: u64,
    /// Fields and work vectors.
    pub fields: u64,
    /// All together.
    pub total: u64,
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

/// Explains a plan of dimension `D`.
///
/// # Errors
/// [`ModelError`] as building the model would give.
pub fn explain<const D: usize>(plan: &Plan) -> Result<Explanation, ModelError> {
    let sample = sample::<D>(plan)?;
    let nonzeros = sample.nonzeros * sample.points as f64;
    let solver = solver(plan, &sample);
    let names = plan.materials.iter().map(|material| material.name.clone());
    Ok(Explanation {
        case: plan.case.clone(),
        title: plan.title.clone(),
        dimension: D,
        points: sample.points,
        unknowns: sample.points,
        spacing: sample.spacing,
        horizon: sample.horizon,
        materials: names.zip(sample.per_material.iter().copied()).collect(),
        effects: effects(plan),
        operator: operator(plan, &sample),
        scheme: scheme(plan),
        bonds: (sample.bonds * sample.points as f64) as u64,
        nonzeros: nonzeros as u64,
        memory: memory::<D>(plan, &sample, solver.name.contains("llt")),
        solver,
        limits: limits(plan, &sample),
        numbers: numbers(plan, &sample),
        warnings: plan.warnings.clone(),
    })
}

fn reason(name: impl Into<String>, why: impl Into<String>) -> Reason {
    Reason {
        name: name.into(),
        why: why.into(),
    }
}

fn effects(plan: &Plan) -> Vec<Reason> {
    let mut effects = vec![reason("flow", "[flow] is there")];
    if plan.gravity.is_some() {
        effects.push(reason("gravity", "[gravity] is there"));
    }
    if !plan.wells.is_empty() {
        let names: Vec<&str> = plan.wells.iter().map(|well| well.name.as_str()).collect();
        effects.push(reason(
            "wells",
            format!("[wells] names {}", names.join(", ")),
        ));
    }
    effects
}

fn operator(plan: &Plan, sample: &Sample) -> Reason {
    let Some(flow) = &plan.flow else {
        return reason("none", "no [flow]");
    };
    let reach = match sample.second_hop {
        true => "two hops",
        false if flow.operator == OperatorChoice::Bond => "one hop, harmonic mean per bond",
        false => {
            "one hop: its second hop vanishes on isotropic families with this hourglass factor"
        }
    };
    let name = match flow.operator {
        OperatorChoice::Correspondence => "correspondence",
        OperatorChoice::Bond => "bond",
    };
    let gradient = if sample.corrected {
        ", divergence-consistent gradient"
    } else {
        ""
    };
    reason(name, format!("{reach}{gradient}"))
}

fn scheme(plan: &Plan) -> Reason {
    if plan.time.mode == TimeMode::Steady {
        return reason("steady", "time.mode = \"steady\": one solve, no time loop");
    }
    let steps = match (plan.scheme, plan.time.step) {
        (_, StepRule::Fixed(dt)) => format!("constant steps of {dt:.3e} s"),
        (SchemeChoice::Explicit, _) => {
            format!("steps of {} × the stability limit", plan.time.safety)
        }
        _ => format!(
            "adaptive steps, error of a step ≤ {:.1e} of the range",
            plan.time.tolerance
        ),
    };
    match plan.scheme.integrator() {
        None => reason("explicit forward-euler", steps),
        Some(integrator) => reason(
            format!("{} {}", plan.scheme.name(), integrator.name()),
            steps,
        ),
    }
}

fn solver(plan: &Plan, sample: &Sample) -> Reason {
    if plan.scheme == SchemeChoice::Explicit && plan.time.mode == TimeMode::Transient {
        return reason("none", "explicit steps solve no system");
    }
    if plan.solver.name() != "auto" {
        return reason(plan.solver.to_string(), "asked for");
    }
    match choose_by_size(sample.points, sample.nonzeros, plan.dimension) {
        Ok(choice) => reason(choice.spec.to_string(), choice.reason),
        Err(error) => reason("auto", error.to_string()),
    }
}

/// Fill of a factor with nested dissection per nonzero of the matrix, from measured factors: about
/// n log n in 2-D and n^(4/3) in 3-D.
fn factor_bytes(points: f64, nonzeros: f64, dimension: usize) -> f64 {
    let growth = if dimension == 2 {
        0.31 * points.log2()
    } else {
        0.14 * points.cbrt()
    };
    12.0 * nonzeros * growth.max(1.0)
}

fn memory<const D: usize>(plan: &Plan, sample: &Sample, direct: bool) -> Memory {
    let points = sample.points as f64;
    let bonds = sample.bonds * points;
    let implicit = plan.scheme != SchemeChoice::Explicit || plan.time.mode == TimeMode::Steady;
    let bond_bytes = 25.0 * bonds + points * (8.0 * (D * D + 1) as f64 + 20.0);
    let gradients = f64::from(sample.second_hop) * bonds * 8.0 * D as f64;
    let gradients = gradients * if sample.corrected { 2.0 } else { 1.0 };
    let matrices = sample.nonzeros * points * if implicit { 20.0 } else { 12.0 };
    let factor = if direct && implicit {
        factor_bytes(points, sample.nonzeros * points, D)
    } else {
        0.0
    };
    let fields = points * 8.0 * (2.0 * D as f64 + 16.0);
    Memory {
        bonds: bond_bytes as u64,
        gradients: gradients as u64,
        matrices: matrices as u64,
        factor: factor as u64,
        fields: fields as u64,
        total: (bond_bytes + gradients + matrices + factor + fields) as u64,
    }
}

fn limits(plan: &Plan, sample: &Sample) -> Vec<Limit> {
    if plan.time.mode == TimeMode::Steady {
        return Vec::new();
    }
    let steps = (plan.time.end / sample.explicit_limit).ceil() as u64;
    let (point, position) = &sample.limiter;
    vec![
        Limit {
            scheme: "explicit".to_owned(),
            dt: sample.explicit_limit,
            steps: Some(steps),
            limiter: format!(
                "diffusion at point {point} {position:?}: Δx²·s/κ is smallest there; the run itself \
                 uses the operator's own eigenvalue"
            ),
        },
        Limit {
            scheme: "implicit".to_owned(),
            dt: f64::INFINITY,
            steps: None,
            limiter: "none: accuracy alone".to_owned(),
        },
    ]
}

fn numbers(plan: &Plan, sample: &Sample) -> Vec<Number> {
    let number = |name: &str, value: f64, meaning: &str| Number {
        name: name.to_owned(),
        value,
        meaning: meaning.to_owned(),
    };
    let slowest = sample.extent.powi(2) / sample.diffusivity[0];
    let mut numbers = vec![
        number(
            "contrast",
            sample.mobility[1] / sample.mobility[0],
            "largest over smallest mobility",
        ),
        number(
            "horizon ratio",
            sample.horizon[1] / sample.spacing[1],
            "δ/Δx of the coarsest points",
        ),
        number(
            "grading",
            sample.spacing[1] / sample.spacing[0],
            "largest over smallest spacing",
        ),
    ];
    if plan.time.mode == TimeMode::Transient {
        numbers.push(number(
            "Fourier",
            plan.time.end / slowest,
            "end over diffusion time L²s/κ",
        ));
        let stiffness = plan.time.end / sample.explicit_limit;
        numbers.push(number(
            "stiffness",
            stiffness,
            "end over the explicit step limit",
        ));
    }
    numbers
}
