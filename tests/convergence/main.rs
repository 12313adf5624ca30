//! Observed orders in space and time.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "../support/mod.rs"]
mod support;

mod poroelastic;

use support::{largest_difference, orders, run_case};

#[test]
fn five_spot_is_second_order_in_space() {
    let errors: Vec<f64> = [25, 50, 100]
        .map(|n| {
            let grid = format!("geometry.points=[{n}, {n}]");
            run_case("five-spot", &[&grid, "time.mode=steady"]).0.errors["pressure"].max
        })
        .to_vec();
    println!("five-spot errors {errors:?}, orders {:?}", orders(&errors));
    assert!(
        orders(&errors).iter().all(|&order| order >= 1.9),
        "{errors:?}"
    );
    assert!(errors[2] < 2e-5);
}

/// Root mean square errors of the steady manufactured solution at halved spacings.
fn manufactured(geometries: &[String], overrides: &[&str]) -> Vec<f64> {
    let text = perifrac::cases::find("manufactured").unwrap().scene;
    // Without output, whose places are those of the plane.
    let head = text.split("[output]").next().unwrap();
    let text = [head, "[reference]\ntype = \"manufactured\"\n"].concat();
    geometries
        .iter()
        .map(|geometry| {
            let overrides = [&[geometry.as_str(), "time.mode=steady"], overrides].concat();
            let (summary, _) = support::run_text(&text, &overrides);
            summary.errors["pressure"].l2
        })
        .collect()
}

#[track_caller]
fn assert_orders(name: &str, errors: &[f64], least: f64) {
    println!("{name}: errors {errors:?}, orders {:?}", orders(errors));
    assert!(
        orders(errors).iter().all(|&order| order >= least),
        "{name}: {errors:?}"
    );
}

#[test]
fn manufactured_solution_on_lattices() {
    let plane = [10, 20, 40]
        .map(|n| format!(r#"geometry={{type="lattice", size=[1, 1], points=[{n}, {n}]}}"#));
    assert_orders("plane", &manufactured(&plane, &[]), 1.9);
    let space = [6, 12, 24]
        .map(|n| format!(r#"geometry={{type="lattice", size=[1, 1, 1], points=[{n}, {n}, {n}]}}"#));
    assert_orders("space", &manufactured(&space, &[]), 1.9);
}

/// Spacing that grows threefold along x and shrinks along y.
fn tensor_graded() -> [String; 3] {
    [1.0, 2.0, 4.0].map(|n: f64| {
        let (a, b) = (0.04 / n, 0.12 / n);
        format!(
            "geometry={{type='graded', axes=[[{{length=1, spacing=[{a}, {b}]}}], \
             [{{length=1, spacing=[{b}, {a}]}}]]}}"
        )
    })
}

/// One quarter of the square, or one eighth of the cube, at half the spacing.
fn blocks(dimension: usize, coarsest: f64) -> [String; 3] {
    let all = |value: &str| vec![value; dimension].join(", ");
    [1.0, 2.0, 4.0].map(|n: f64| {
        let spacing = 1.0 / (coarsest * n);
        let (size, min, max) = (all("1"), all("0"), all("0.49"));
        format!(
            "geometry={{type='blocks', size=[{size}], spacing={spacing}, refine=[{{levels=1, \
             region={{type='box', min=[{min}], max=[{max}]}}}}]}}"
        )
    })
}

#[test]
fn the_consistent_gradient_is_second_order_on_graded_clouds() {
    let horizon = "horizon={ratio=2.2}";
    let tensor = tensor_graded();
    let consistent = manufactured(&tensor, &[horizon]);
    assert_orders("tensor grading", &consistent, 1.9);
    let plain = manufactured(&tensor, &[horizon, "flow.gradient=plain"]);
    println!(
        "tensor grading, plain gradient: {plain:?}, orders {:?}",
        orders(&plain)
    );
    assert!(
        plain[2] > 3.0 * consistent[2],
        "the plain gradient is worse"
    );
}

#[test]
fn orders_on_graded_clouds_with_a_fixed_number_of_neighbours() {
    // Families of 15 neighbours change shape from point to point, which costs part of an order.
    assert_orders(
        "tensor grading, 15 neighbours",
        &manufactured(&tensor_graded(), &[]),
        1.3,
    );
}

#[test]
fn manufactured_solution_on_blocks() {
    assert_orders(
        "blocks in the plane",
        &manufactured(&blocks(2, 8.0), &["horizon={ratio=2.2}"]),
        1.9,
    );
    assert_orders(
        "blocks in space",
        &manufactured(&blocks(3, 4.0), &["horizon={ratio=2.2}"]),
        1.9,
    );
}

/// Differences to a run with very small steps on the same cloud, so that only time errors remain.
fn time_errors(scheme: &[&str], steps: &[f64]) -> Vec<f64> {
    let grid = "geometry.points=[12, 12]";
    let (_, exact) = run_case("manufactured", &[grid, "time.step=2.5e-4"]);
    steps
        .iter()
        .map(|step| {
            let step = format!("time.step={step}");
            let (_, state) = run_case("manufactured", &[&[grid, &step], scheme].concat());
            largest_difference(&exact.pressure, &state.pressure)
        })
        .collect()
}

#[test]
fn backward_euler_is_first_and_tr_bdf2_second_order_in_time() {
    let steps = [0.02, 0.01, 0.005];
    let euler = time_errors(&["time.integrator=backward-euler"], &steps);
    println!("backward Euler: {euler:?}, orders {:?}", orders(&euler));
    assert!(
        orders(&euler)
            .iter()
            .all(|order| (0.9..1.1).contains(order)),
        "{euler:?}"
    );
    let second = time_errors(&["time.integrator=tr-bdf2"], &steps);
    println!("TR-BDF2: {second:?}, orders {:?}", orders(&second));
    assert!(
        orders(&second)
            .iter()
            .all(|order| (1.9..2.1).contains(order)),
        "{second:?}"
    );
}

#[test]
fn a_tighter_tolerance_gives_a_smaller_error_at_a_known_rate() {
    let grid = ["geometry.points=[12, 12]", "time.end=0.5"];
    let (_, exact) = run_case("manufactured", &[&grid[..], &["time.step=2.5e-4"]].concat());
    let text = perifrac::cases::find("manufactured")
        .unwrap()
        .scene
        .replace("step = 0.005\n", "");
    let adaptive = |tolerance: &str| {
        let tolerance = format!("time.tolerance={tolerance}");
        let overrides = [&grid[..], &[&tolerance]].concat();
        let (summary, state) = support::run_text(&text, &overrides);
        (
            largest_difference(&exact.pressure, &state.pressure),
            summary.steps,
        )
    };
    let ((loose, few), (tight, many)) = (adaptive("1e-3"), adaptive("1e-6"));
    // The global error of a second-order scheme falls as the tolerance to the power 2/3.
    assert!(tight < loose * 0.05, "{loose:.1e} → {tight:.1e}");
    assert!(many > 4 * few, "{few} → {many} steps");
}
