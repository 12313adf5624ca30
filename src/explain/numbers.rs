//! Numbers that tell how hard a plan is.

use super::Number;
use crate::model::{CoupledSample, FlowSample, Sample};
use crate::plan::{Plan, TimeMode};

/// Poisson's ratio above which the rock counts as nearly incompressible.
const NEARLY_INCOMPRESSIBLE: f64 = 0.45;

/// Numbers of the plan; those of time only where it passes.
pub(super) fn numbers(plan: &Plan, sample: &Sample) -> Vec<Number> {
    let mut numbers = Vec::new();
    if let Some(flow) = &sample.flow {
        let contrast = flow.mobility[1] / flow.mobility[0];
        numbers.push(number(
            "contrast",
            contrast,
            "largest over smallest mobility",
        ));
    }
    numbers.push(number(
        "horizon ratio",
        sample.horizon[1] / sample.spacing[1],
        "δ/Δx of the coarsest points",
    ));
    numbers.push(number(
        "grading",
        sample.spacing[1] / sample.spacing[0],
        "largest over smallest spacing",
    ));
    let ratio = (sample.solid.as_ref()).map_or(0.0, |solid| solid.poissons_ratio);
    if ratio > NEARLY_INCOMPRESSIBLE {
        numbers.push(number(
            "Poisson's ratio",
            ratio,
            "the largest: nearly incompressible",
        ));
    }
    if let (Some(flow), TimeMode::Transient) = (&sample.flow, plan.time.mode) {
        numbers.extend(transient(plan, sample, flow));
        numbers.extend(sample.coupling.iter().flat_map(coupled));
    }
    numbers
}

fn transient(plan: &Plan, sample: &Sample, flow: &FlowSample) -> [Number; 2] {
    let (slowest, meaning) = match &sample.coupling {
        None => (flow.diffusivity[0], "end over diffusion time L²s/κ"),
        Some(coupling) => (
            coupling.consolidation[0],
            "end over consolidation time L²/c_v",
        ),
    };
    let fourier = plan.time.end / (sample.extent.powi(2) / slowest);
    let stiffness = plan.time.end / flow.limit.dt;
    [
        number("Fourier", fourier, meaning),
        number("stiffness", stiffness, "end over the explicit step limit"),
    ]
}

fn coupled(coupling: &CoupledSample) -> [Number; 4] {
    [
        number(
            "coupling strength",
            coupling.strength,
            "largest τ = α²/(s(λ + 2μ)); lagged strain alone diverges above 1",
        ),
        number(
            "loading efficiency",
            coupling.loading_efficiency,
            "largest undrained pressure per load, α/(s(λ + 2μ) + α²)",
        ),
        number(
            "c_v",
            coupling.consolidation[1],
            "largest consolidation coefficient κ/(s + α²/(λ + 2μ)), m²/s",
        ),
        number(
            "oscillation step",
            coupling.oscillation,
            "Δx²/(6 c_v), s; a shorter step after a sudden load makes the pressure overshoot",
        ),
    ]
}

fn number(name: &str, value: f64, meaning: &str) -> Number {
    Number {
        name: name.to_owned(),
        value,
        meaning: meaning.to_owned(),
    }
}
