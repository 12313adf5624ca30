//! Balances of bodies with inertia: energy to the order of the scheme, momentum to rounding, while loads
//! act and after they have ended.

use perifrac::report::Balance;
use perifrac::run::RunError;
use perifrac::schemes::{Conserved, StepError};

use crate::support::{plan_of, run_text, try_run};

/// A bar that a pulse sets in motion and that is left to itself from t = 2 on; waves take 1 to run
/// along it.
pub const BAR: &str = r#"
title = "bar"
[geometry]
type = "lattice"
size = [1, 0.25]
points = [32, 8]
[materials.rock]
youngs_modulus = 2.5
poissons_ratio = 0.25
density = 3
[mechanics]
mode = "dynamic"
[mechanics.boundary.left]
clamped = true
[mechanics.boundary.right]
traction = [{ time = [0, 1, 2], value = [0, 1, 0] }, 0]
[scheme]
name = "explicit"
[time]
end = 5
[output]
"#;

fn balance(text: &str, overrides: &[&str]) -> Balance {
    let overrides = [&["time.step=0.01"][..], overrides].concat();
    run_text(text, &overrides).0.balance
}

/// Of three steps, each half of the one before, the ratios of the errors at one time.
fn ratios(text: &str, overrides: &[&str], step: f64) -> [f64; 2] {
    let error = |halvings: i32| {
        let step = format!("time.step={}", step * 0.5_f64.powi(halvings));
        let own = balance(text, &[overrides, &[step.as_str()]].concat());
        assert!(own.momentum.unwrap() < 1e-8, "{own:?}");
        own.energy_error.unwrap()
    };
    let errors = [0, 1, 2].map(error);
    println!("{overrides:?}: {errors:?}");
    [errors[0] / errors[1], errors[1] / errors[2]]
}

#[test]
fn total_energy_is_kept_to_second_order_after_a_load_has_ended() {
    for ratio in ratios(BAR, &[], 0.01) {
        assert!((3.7..4.3).contains(&ratio), "{ratio}");
    }
}

#[test]
fn the_work_of_loads_of_walls_and_of_fluid_is_counted() {
    let load = ["time.end=1.5"];
    let wall = [
        "time.end=1.5",
        "mechanics.boundary.right={displacement=[{time=[0, 1, 2], value=[0, 0.1, 0]}, 0]}",
    ];
    let fluid = [
        "time.end=1.5",
        "time.integrator=backward-euler",
        "scheme.name=semi-implicit",
        "fluid.viscosity=1",
        "materials.rock.permeability=0.01",
        "materials.rock.storage=1",
        "materials.rock.biot_coefficient=0.8",
        "flow.boundary.right.pressure={time=[0, 1], value=[0, 1]}",
        "coupling.undrained_start=false",
    ];
    for overrides in [&load[..], &wall[..], &fluid[..]] {
        let own = balance(BAR, overrides);
        assert!(own.work.unwrap().abs() > 1e-3, "{own:?}");
        assert!(own.energy_error.unwrap() < 2e-2, "{own:?}");
        for ratio in ratios(BAR, overrides, 0.01) {
            assert!((3.5..4.5).contains(&ratio), "{ratio}: {overrides:?}");
        }
    }
}

/// Energies at two times 5000 steps apart, free of loads: the sum differs by what a step leaves, not by
/// what 5000 of them do.
#[test]
fn energy_does_not_drift_over_thousands_of_steps() {
    let after = |end: &str| {
        let own = balance(BAR, &[end]);
        let total = own.kinetic.unwrap() + own.energy.unwrap();
        assert!(own.kinetic.unwrap() > 0.0 && total > 0.0);
        (total, own.energy_error.unwrap(), own.momentum.unwrap())
    };
    let ((early, ..), (late, error, momentum)) = (after("time.end=5"), after("time.end=55"));
    println!("{early} {late} {error} {momentum}");
    assert!((late / early - 1.0).abs() < 5e-3, "{early} {late}");
    assert!(error < 5e-3 && momentum < 1e-8, "{error} {momentum}");
}

/// The scale of the forces outlasts the load at rest too.
#[test]
fn a_load_that_ends_leaves_a_body_at_rest_balanced() {
    let rest = [
        "mechanics.mode=quasi-static",
        "scheme.name=implicit",
        "time.step=0.5",
    ];
    let own = balance(BAR, &rest);
    assert!(own.momentum.unwrap() < 1e-8, "{own:?}");
    assert!(own.kinetic.is_none());
}

#[test]
fn a_step_above_the_limit_is_refused_by_the_balance_of_energy() {
    let plan = plan_of(BAR, &["time.step=0.06", "time.end=20"]);
    let Err(RunError::Step { source, .. }) = try_run(&plan) else {
        panic!("unstable steps went on");
    };
    assert!(
        matches!(
            source,
            StepError::Unbalanced {
                quantity: Conserved::Energy,
                ..
            }
        ),
        "{source}"
    );
}
