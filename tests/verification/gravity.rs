//! Gravity: a hydrostatic column is at rest, and a tilted pressure is not.

use perifrac::geometry::Vector;

use crate::support::{flow_model, plan_of, run_text, try_run};

const TANK: &str = r#"
title = "tank"
[geometry]
type = "lattice"
size = [2, 1]
points = [20, 10]
[fluid]
viscosity = 1e-3
density = 1000
[materials.sand]
permeability = 1e-12
storage = 1e-9
[materials.clay]
permeability = 1e-16
storage = 1e-9
region = { type = "box", min = [0.5, 0.2], max = [1.2, 0.6] }
[gravity]
acceleration = [0, -9.81]
[flow]
initial_pressure = 1e5
hydrostatic_start = true
[time]
end = 1000
"#;

fn largest_velocity(overrides: &[&str]) -> f64 {
    let plan = plan_of(TANK, overrides);
    let (_, state) = try_run(&plan).unwrap();
    let velocity = flow_model::<2>(&plan).velocity(&state.pressure, state.time);
    velocity
        .iter()
        .map(|v: &Vector<2>| v.norm())
        .fold(0.0, f64::max)
}

/// Darcy velocity that the weight alone would drive: κ ρ g.
const FREE_FALL: f64 = 1e-12 / 1e-3 * 9810.0;

#[test]
fn a_hydrostatic_column_in_layered_rock_stays_at_rest() {
    let sealed: [&str; 0] = [];
    let open_top = ["flow.boundary.top={pressure=1e5}"];
    let open_side = ["flow.boundary.left={pressure=1e5, hydrostatic=true}"];
    for overrides in [&sealed[..], &open_top, &open_side] {
        for operator in ["path", "bond", "correspondence"] {
            let operator = &*format!("flow.operator={operator}");
            let velocity = largest_velocity(&[overrides, &[operator]].concat());
            assert!(
                velocity < 1e-11 * FREE_FALL,
                "{overrides:?} {operator}: {velocity:.1e}"
            );
        }
    }
}

#[test]
fn a_uniform_start_falls_towards_the_hydrostatic_state() {
    let flat = [
        "flow.hydrostatic_start=false",
        "time.end=1e-3",
        "time.step=1e-3",
    ];
    assert!(largest_velocity(&flat) > 0.5 * FREE_FALL);
    let settled = ["flow.hydrostatic_start=false", "time.end=1e9"];
    assert!(largest_velocity(&settled) < 1e-6 * FREE_FALL);
    // Nothing moves any more, and all that the balance of a long step finds is rounding: it costs no steps.
    let (summary, _) = run_text(TANK, &settled);
    assert!(
        summary.steps < 600 && summary.rejected < 30 && summary.balance.mass < 1e-5,
        "{} steps, {} rejected, {:?}",
        summary.steps,
        summary.rejected,
        summary.balance
    );
}

#[test]
fn a_uniform_pressure_on_a_vertical_side_is_warned_about() {
    let (summary, _) = run_text(TANK, &["flow.boundary.left={pressure=1e5}", "time.end=1"]);
    assert!(
        summary
            .warnings
            .iter()
            .any(|w| w.contains("hydrostatic = true")),
        "{summary:?}"
    );
    assert!(
        summary.balance.mass < 1e-10,
        "seepage is part of the balance"
    );
}
