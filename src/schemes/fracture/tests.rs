//! Rows that are kept change the way to equilibrium, not the equilibrium.

use std::path::Path;

use super::*;
use crate::plan::{DescentSettings, Plan, resolve};
use crate::report::Timers;
use crate::scene::load_str;
use crate::schemes::descent::TangentMatrix;

fn plan() -> Plan {
    let text = include_str!("../../../cases/notched-tension/scene.toml");
    let small = [
        "geometry.points=[20, 20]",
        "horizon={length_scale_ratio=0.5}",
        "damage.model=paper",
        "damage.length_scale=0.2 mm",
        "damage.tolerance=1e-8",
    ];
    let loaded = load_str("notch", text, Path::new(""), &small.map(str::to_owned));
    resolve(&loaded.unwrap(), "notch").unwrap()
}

/// State after some damage, and how many families were filled.
fn pulled(times: &[f64], kept: f64) -> (State, u64) {
    let plan = plan();
    let model = Model::<2>::build(&plan, &mut Timers::default()).unwrap();
    let mut damage = plan.damage.unwrap();
    damage.descent.refill_threshold = kept;
    let mut solver = Fracture::new(&plan.fracture_demand(), &model, damage).unwrap();
    let mut state = State::initial(&model);
    for time in times {
        state.time = *time;
        solver.equilibrate(&model, &mut state).unwrap();
        crate::schemes::advance(&model, &mut state);
    }
    (state, solver.linear.tangent.refilled)
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

fn largest(field: &[f64]) -> f64 {
    field.iter().fold(0.0_f64, |m, u| m.max(u.abs()))
}

#[test]
fn the_full_refill_gives_the_same_field_with_more_work() {
    let run = |kept| pulled(&[1500.0, 2500.0, 3000.0], kept);
    let ((sparing, few), (full, many)) =
        (run(DescentSettings::default().refill_threshold), run(0.0));
    let apart = apart(&full.displacement, &sparing.displacement);
    let largest = largest(&full.displacement);
    assert!(apart < 1e-5 * largest, "{apart} of {largest}");
    // The first fill is of all families.
    assert!(3 * few < 2 * many, "{few} {many}");
}

/// The exact tangent is the derivative of the force, hourglass energy in the driving one included.
#[test]
fn the_exact_tangent_is_the_derivative_of_the_force() {
    let plan = plan();
    let model = Model::<2>::build(&plan, &mut Timers::default()).unwrap();
    let solid = model.solid.as_ref().unwrap();
    let damage = solid.damage.as_ref().unwrap();
    let mut state = State::initial(&model);
    // Rough and large enough that damage is well under way.
    let size = state.displacement.len();
    for (k, u) in state.displacement.iter_mut().enumerate() {
        *u = 4e-7 * (0.7 * k as f64).sin() + 2e-6 * (k / 40) as f64 / 20.0;
    }
    let view = state.view();
    let fields = view.damage(&[]);
    let response_at = |u: &[f64]| solid.response(u, &state.walls, fields).unwrap();
    let force = |u: &[f64]| solid.elastic.gather(&response_at(u).forces);
    let response = response_at(&state.displacement);
    assert!(response.damage.iter().any(|s| *s > 0.2));
    let settings = DescentSettings {
        refill_threshold: 0.0,
        ..DescentSettings::default()
    };
    let mut tangent = TangentMatrix::new(solid, &settings);
    tangent.update(solid, damage, fields, &response, TangentKind::Consistent);
    let direction: Vec<f64> = (0..size).map(|k| (1.3 * k as f64).cos()).collect();
    let by = 1e-12;
    let moved = |sign: f64| {
        let pairs = state.displacement.iter().zip(&direction);
        force(&pairs.map(|(u, d)| u + sign * by * d).collect::<Vec<f64>>())
    };
    let (ahead, back) = (moved(1.0), moved(-1.0));
    let mut product = vec![0.0; size];
    perifrac_solvers::multiply(tangent.matrix.view(), &direction, &mut product);
    let largest = product.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    for (k, p) in product.iter().enumerate() {
        let slope = (ahead[k] - back[k]) / (2.0 * by);
        assert!((slope - p).abs() < 1e-4 * largest, "{k}: {slope} and {p}");
    }
}
