//! Observed orders in space and time.

#[path = "../support/mod.rs"]
mod support;

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
    assert!(orders(&errors).iter().all(|&order| order >= 1.9), "{errors:?}");
    assert!(errors[2] < 2e-5);
}

/// Root mean square errors of the steady manufactured solution at halved spacings.
fn manufactured(geometries: &[String]) -> Vec<f64> {
    let text = perifrac::cases::find("manufactured").unwrap().scene;
    // Without output, whose places are those of the plane.
    let text = [text.split("[output]").next().unwrap(), "[reference]\ntype = \"manufactured\"\n"].concat();
    geometries
        .iter()
        .map(|geometry| {
            let (summary, _) = support::run_text(&text, &[geometry, "time.mode=steady"]);
            summary.errors["pressure"].l2
        })
        .collect()
}

#[track_caller]
fn assert_second_order(name: &str, errors: &[f64]) {
    println!("{name}: errors {errors:?}, orders {:?}", orders(errors));
    assert!(orders(errors).iter().all(|&order| order >= 1.8), "{name}: {errors:?}");
}

#[test]
fn manufactured_solution_on_lattices() {
    let plane = [10, 20, 40].map(|n| {
        format!(r#"geometry={{type="lattice", size=[1, 1], points=[{n}, {n}]}}"#)
    });
    assert_second_order("plane", &manufactured(&plane));
    let space = [6, 12, 24].map(|n| {
        format!(r#"geometry={{type="lattice", size=[1, 1, 1], points=[{n}, {n}, {n}]}}"#)
    });
    assert_second_order("space", &manufactured(&space));
}

#[test]
fn manufactured_solution_on_graded_clouds() {
    let tensor = [1.0, 2.0, 4.0].map(|n: f64| {
        let (a, b) = (0.04 / n, 0.12 / n);
        format!(
            r#"geometry={{type="graded", axes=[[{{length=1, spacing=[{a}, {b}]}}], [{{length=1, spacing=[{b}, {a}]}}]]}}"#
        )
    });
    assert_second_order("tensor grading", &manufactured(&tensor));
    let blocks = [8.0, 16.0, 32.0].map(|n: f64| {
        let spacing = 1.0 / n;
        format!(
            r#"geometry={{type="blocks", size=[1, 1], spacing={spacing}, refine=[{{levels=1, region={{type="box", min=[0, 0], max=[0.49, 0.49]}}}}]}}"#
        )
    });
    assert_second_order("blocks", &manufactured(&blocks));
    let solid = [4.0, 8.0, 16.0].map(|n: f64| {
        let spacing = 1.0 / n;
        format!(
            r#"geometry={{type="blocks", size=[1, 1, 1], spacing={spacing}, refine=[{{levels=1, region={{type="box", min=[0, 0, 0], max=[0.49, 0.49, 0.49]}}}}]}}"#
        )
    });
    assert_second_order("blocks in space", &manufactured(&solid));
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
    assert!(orders(&euler).iter().all(|order| (0.9..1.1).contains(order)), "{euler:?}");
    let second = time_errors(&["time.integrator=tr-bdf2"], &steps);
    println!("TR-BDF2: {second:?}, orders {:?}", orders(&second));
    assert!(orders(&second).iter().all(|order| (1.9..2.1).contains(order)), "{second:?}");
}

#[test]
fn a_tighter_tolerance_gives_a_smaller_error_at_a_known_rate() {
    let grid = ["geometry.points=[12, 12]", "time.end=0.5"];
    let (_, exact) = run_case("manufactured", &[&grid[..], &["time.step=2.5e-4"]].concat());
    let text = perifrac::cases::find("manufactured").unwrap().scene.replace("step = 0.005\n", "");
    let adaptive = |tolerance: &str| {
        let tolerance = format!("time.tolerance={tolerance}");
        let overrides = [&grid[..], &[&tolerance]].concat();
        let (summary, state) = support::run_text(&text, &overrides);
        (largest_difference(&exact.pressure, &state.pressure), summary.steps)
    };
    let ((loose, few), (tight, many)) = (adaptive("1e-3"), adaptive("1e-6"));
    // The global error of a second-order scheme falls as the tolerance to the power 2/3.
    assert!(tight < loose * 0.05, "{loose:.1e} → {tight:.1e}");
    assert!(many > 4 * few, "{few} → {many} steps");
}
