//! Hard cases: stiff contrasts, huge and tiny steps, unstable explicit steps.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "../support/mod.rs"]
mod support;

mod audits;
mod fracture;
mod fracture_flow;
mod ladder;
mod poroelastic;

use perifrac::run::RunError;
use perifrac::schemes::StepError;
use support::{extremes, plan, run_case, try_run};

const SMALL: [&str; 2] = ["geometry.points=[50, 50]", "output.times=[]"];

/// Explicit run with a step of `factor` times the printed limit.
fn explicit(factor: f64) -> Result<perifrac::run::Summary, RunError> {
    let common = [&SMALL[..], &["scheme.name=explicit"]].concat();
    let probe = [&common[..], &["time.end=1e-4"]].concat();
    let limit = run_case("five-spot", &probe).0.limit.expect("explicit").dt;
    let (step, end) = (
        format!("time.step={}", factor * limit),
        format!("time.end={}", 3e3 * limit),
    );
    try_run(&plan("five-spot", &[&common[..], &[&step, &end]].concat())).map(|(summary, _)| summary)
}

#[test]
fn explicit_flow_is_stable_just_below_its_printed_limit() {
    let summary = explicit(0.99).unwrap();
    assert!(summary.warnings.is_empty());
    // The corner keeps its exact steady value to a few per cent after 3000 steps.
    assert!(
        summary.pressure_range.unwrap()[1] < 9e6,
        "{:?}",
        summary.pressure_range
    );
}

#[test]
fn explicit_flow_above_its_limit_is_reported_as_unstable() {
    match explicit(1.3) {
        Err(RunError::Step {
            source: StepError::Unstable { growth, .. },
            last_output,
            ..
        }) => {
            assert!(growth > 1.5);
            assert_eq!(last_output, Some(0.0), "the start was written");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_limit_scales_with_storage_and_spacing_and_against_permeability() {
    let limit = |overrides: &[&str]| {
        let common = ["scheme.name=explicit", "time.end=1e-7", "output.times=[]"];
        run_case("five-spot", &[&common[..], overrides].concat())
            .0
            .limit
            .unwrap()
            .dt
    };
    let base = limit(&["geometry.points=[20, 20]"]);
    // λ_max = 16/3 κ/(s Δx²) between cells that touch, with 2/3 and 1/6 (docs/theory.md).
    let theory = 2.0 * 1e-11 * 0.05_f64.powi(2) / (16.0 / 3.0 * 1e-10);
    assert!(
        (base / theory - 1.0).abs() < 0.02,
        "{base:.3e} {theory:.3e}"
    );
    let finer = limit(&["geometry.points=[40, 40]"]);
    assert!((base / finer / 4.0 - 1.0).abs() < 0.02);
    let storage = limit(&["geometry.points=[20, 20]", "materials.rock.storage=1e-10"]);
    assert!((storage / base / 10.0 - 1.0).abs() < 0.01);
    let tight = limit(&[
        "geometry.points=[20, 20]",
        "materials.rock.permeability=1e-12",
    ]);
    assert!((base / tight / 10.0 - 1.0).abs() < 0.01);
}

#[test]
fn implicit_flow_is_stable_and_monotone_from_tiny_to_huge_steps() {
    // Δt from 1e-4 to 1e8 of the explicit limit; a drop from 1 to 0 must stay between them.
    for integrator in ["tr-bdf2", "backward-euler"] {
        for step in ["1e-8", "1e-4", "1e0", "1e4"] {
            let integrator = format!("time.integrator={integrator}");
            let (step, end) = (
                format!("time.step={step}"),
                format!("time.end=2{}", &step[1..]),
            );
            let overrides = ["output.times=[]", &integrator, &step, &end];
            let (summary, state) = run_case("two-layer", &overrides);
            assert_eq!(summary.steps, 2);
            assert_eq!(
                summary.counters.solver.factorisations, 1,
                "one for a constant step"
            );
            let (low, high) = extremes(&state.pressure);
            assert!(low.is_finite() && high.is_finite());
            if integrator.contains("backward") {
                assert!(low >= -1e-10 && high <= 1.0 + 1e-10, "{step}: {low} {high}");
            } else {
                // TR-BDF2 is L-stable but not positive: bounded, and free of growth.
                assert!(low > -0.2 && high < 1.2, "{step}: {low} {high}");
            }
        }
    }
}

#[test]
fn adaptive_runs_keep_to_the_bounds_on_channel_and_heterogeneous() {
    let cases = [
        ("channel", "geometry.points=[51, 51]", 0.0, 1e6),
        ("heterogeneous", "geometry.points=[40, 40]", 1e6, 2e6),
    ];
    for (case, grid, low, high) in cases {
        for mode in ["steady", "transient"] {
            let mode = format!("time.mode={mode}");
            let start = if case == "heterogeneous" {
                "flow.initial_pressure=1e6"
            } else {
                "flow.initial_pressure=0"
            };
            let region =
                r#"materials.channel.region={type="box", min=[0.2, 0.491], max=[0.8, 0.509]}"#;
            let mut overrides = vec![grid, mode.as_str(), start, "output.times=[]"];
            if case == "channel" {
                overrides.push(region);
            }
            let (summary, state) = run_case(case, &overrides);
            let (least, most) = extremes(&state.pressure);
            let slack = 1e-10 * (high - low);
            assert!(
                least >= low - slack && most <= high + slack,
                "{case} {mode}: {least} {most}"
            );
            assert!(
                summary.balance.mass <= 1e-10,
                "{case} {mode}: {}",
                summary.balance.mass
            );
        }
    }
}

#[test]
fn both_operators_survive_every_contrast_on_the_channel() {
    for operator in ["bond", "correspondence"] {
        for contrast in ["1e-27", "1e-15", "1e-7", "1e-3"] {
            let operator = format!("flow.operator={operator}");
            let channel = format!("materials.channel.permeability={contrast}");
            let region =
                r#"materials.channel.region={type="box", min=[0.2, 0.491], max=[0.8, 0.509]}"#;
            let common = ["geometry.points=[51, 51]", "time.mode=steady", region];
            let overrides = [&common[..], &[&operator, &channel]].concat();
            let (summary, state) = match try_run(&plan("channel", &overrides)) {
                Ok(done) => done,
                // At 1e12 inside the domain the pressure itself cannot hold the differences that
                // drive the flux; a refusal by name is right, a wrong answer would not be.
                Err(RunError::Step {
                    source: StepError::Solve(_),
                    ..
                }) if contrast == "1e-3" => continue,
                Err(error) => panic!("{operator} {channel}: {error}"),
            };
            let (low, high) = extremes(&state.pressure);
            assert!(
                low > -1e5 && high < 1.1e6,
                "{operator} {channel}: {low} {high}"
            );
            assert!(summary.outflow["right"] > 0.0);
        }
    }
}

#[test]
fn nearly_no_storage_is_the_steady_state_at_once() {
    let tight = [
        "materials.left.storage=1e-20",
        "materials.right.storage=1e-20",
        "output.times=[]",
    ];
    let (_, at_once) = run_case("two-layer", &tight);
    let (_, steady) = run_case("two-layer", &["time.mode=steady"]);
    assert!(support::largest_difference(&at_once.pressure, &steady.pressure) < 1e-9);
}

#[test]
fn a_sealed_domain_without_storage_is_refused_by_name() {
    let tight = [&SMALL[..], &["materials.rock.storage=1e-27"]].concat();
    let error = try_run(&plan("five-spot", &tight)).unwrap_err();
    assert!(
        matches!(
            &error,
            RunError::Step {
                source: StepError::Solve(_),
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_sealed_domain_with_a_net_source_has_no_steady_state() {
    let text = perifrac::cases::find("five-spot").unwrap().scene;
    let text = text.replace("[reference]\ntype = \"five-spot\"\n", "");
    let unbalanced = [
        "geometry.points=[20, 20]",
        "time.mode=steady",
        "wells.producer.rate=-5e-4",
    ];
    let error = try_run(&support::plan_of(&text, &unbalanced)).unwrap_err();
    let named = matches!(&error, RunError::Step { source: StepError::NoSteadyState { net, .. }, .. } if (net - 1.25e-4).abs() < 1e-9);
    assert!(named, "{error}");
}
