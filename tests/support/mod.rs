//! What the integration tests share: bundled cases run through the library, as the program does.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::path::Path;

use perifrac::model::{FlowModel, Model};
use perifrac::plan::{Plan, resolve};
use perifrac::report::Timers;
use perifrac::run::{Interrupt, RunError, Summary, run};
use perifrac::schemes::State;
use perifrac::{cases, scene};

/// Plan of a bundled case with `--set` values.
pub fn plan(case: &str, overrides: &[&str]) -> Plan {
    let text = cases::find(case).expect("bundled").scene;
    plan_of(text, overrides)
}

/// Plan of a variant of a bundled case with `--set` values.
pub fn plan_of_variant(case: &str, variant: &str, overrides: &[&str]) -> Plan {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    let case = cases::find(case).expect("bundled");
    let layers = case.layers(Some(variant)).expect("a variant");
    let layers: Vec<(&str, &str)> = layers.iter().map(|(n, text)| (&**n, *text)).collect();
    let loaded = scene::load_layers(&layers, Path::new(""), &overrides)
        .unwrap_or_else(|errors| panic!("{errors}"));
    resolve(&loaded, case.name).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Plan of a scene text with `--set` values.
pub fn plan_of(text: &str, overrides: &[&str]) -> Plan {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    let loaded = scene::load_str("test", text, Path::new(""), &overrides)
        .unwrap_or_else(|errors| panic!("{errors}"));
    resolve(&loaded, "test").unwrap_or_else(|errors| panic!("{errors}"))
}

/// Runs a plan without writing anything.
pub fn try_run(plan: &Plan) -> Result<(Summary, State), RunError> {
    run(plan, None, &mut (), &Interrupt::default())
}

/// Runs a bundled case without writing anything.
pub fn run_case(case: &str, overrides: &[&str]) -> (Summary, State) {
    try_run(&plan(case, overrides)).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a scene text without writing anything.
pub fn run_text(text: &str, overrides: &[&str]) -> (Summary, State) {
    try_run(&plan_of(text, overrides)).unwrap_or_else(|error| panic!("{error}"))
}

/// Pressures at the probes of a 2-D plan at its end.
pub fn probe_values(plan: &Plan) -> Vec<f64> {
    let (_, state) = try_run(plan).unwrap_or_else(|error| panic!("{error}"));
    let model = model::<2>(plan);
    let flow = model.flow.expect("the plan names flow");
    flow.pressures_at(&state.pressure, state.time, &model.places.probes)
}

/// The model of a plan.
pub fn model<const D: usize>(plan: &Plan) -> Model<D> {
    Model::build(plan, &mut Timers::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The flow part of the model of a plan.
pub fn flow_model<const D: usize>(plan: &Plan) -> FlowModel<D> {
    model(plan).flow.expect("the plan names flow")
}

/// Observed order from errors at successively halved spacings or steps.
pub fn orders(errors: &[f64]) -> Vec<f64> {
    errors
        .windows(2)
        .map(|pair| (pair[0] / pair[1]).log2())
        .collect()
}

/// Largest difference of two fields.
pub fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Smallest and largest value.
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
            (l.min(v), h.max(v))
        })
}

/// A unit pressure drop over a unit square of unit mobility, with `points` across: the outflow is 1.
pub fn square(points: usize) -> String {
    unit(&[points, points])
}

/// The same over a unit square or cube, with so many `points` along the axes.
pub fn unit(points: &[usize]) -> String {
    let size = vec![1; points.len()];
    format!(
        r#"title = "unit"
[geometry]
type = "lattice"
size = {size:?}
points = {points:?}
seed = 3
[fluid]
viscosity = 1
[materials.rock]
permeability = 1
storage = 1
[flow.boundary.left]
pressure = 1
[flow.boundary.right]
pressure = 0
[time]
mode = "steady"
"#
    )
}
