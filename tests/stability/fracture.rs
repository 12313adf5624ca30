//! Rock that breaks: unloading, growth within one step, next to no stiffness left. A run ends in balance, or it says why it does not.

use perifrac::plan::{DamageMethod, Plan, StepRule};
use perifrac::run::RunError;
use perifrac::schemes::{State, StepError};

use crate::support::{model, plan_of_variant, try_run};

const QUICK: [&str; 4] = [
    "output.plots=false",
    "output.times=[]",
    "geometry.points=[20, 20]",
    "damage.length_scale=0.1333333 mm",
];

fn notch(overrides: &[&str]) -> Plan {
    plan_of_variant(
        "notched-tension",
        "paper",
        &[&QUICK[..], overrides].concat(),
    )
}

fn with_step(mut plan: Plan, step: f64) -> Plan {
    plan.time.step = StepRule::Fixed(step);
    plan.time.max_step = None;
    plan
}

fn finite(state: &State) -> bool {
    let fields = [&state.displacement, &state.history, &state.pressure];
    fields
        .iter()
        .all(|field| field.iter().all(|value| value.is_finite()))
}

/// Largest difference of the displacements above and below the middle, relative to the largest one.
fn unevenness(plan: &Plan, state: &State) -> f64 {
    let cloud = model::<2>(plan).cloud;
    let middle = 0.5 * cloud.position.iter().map(|p| p[1]).fold(0.0, f64::max)
        + 0.5
            * cloud
                .position
                .iter()
                .map(|p| p[1])
                .fold(f64::INFINITY, f64::min);
    let key = |x: f64, y: f64| ((x * 1e6).round() as i64, (y * 1e6).round() as i64);
    let places = cloud.position.iter().enumerate();
    let index: std::collections::BTreeMap<_, _> =
        places.map(|(i, p)| (key(p[0], p[1] - middle), i)).collect();
    let u = &state.displacement;
    let largest = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let places = cloud.position.iter().enumerate();
    let apart = places.map(|(i, p)| {
        let j = index[&key(p[0], middle - p[1])];
        (u[2 * i] - u[2 * j])
            .abs()
            .max((u[2 * i + 1] + u[2 * j + 1]).abs())
    });
    apart.fold(0.0, f64::max) / largest
}

/// The whole specimen breaks within the only step there is.
#[test]
fn a_step_that_breaks_the_whole_specimen_ends_in_balance() {
    let plan = with_step(notch(&["damage.residual_stiffness=1e-9"]), 6000.0);
    let (summary, state) = try_run(&plan).unwrap();
    assert!(finite(&state));
    assert_eq!(summary.steps, 1);
    let results = summary.results.unwrap();
    assert!(results.crack_length > 1e-4, "{results:?}");
    let (momentum, energy) = (
        summary.balance.momentum.unwrap(),
        summary.balance.energy.unwrap(),
    );
    // What still holds is little, so the imbalance is told relative to it.
    assert!(momentum.is_finite() && energy.is_finite() && energy > 0.0);
    // Far from the force of an unbroken specimen at that displacement.
    let elastic = results.initial_stiffness.unwrap() * 6e-3;
    assert!(results.peak_force.unwrap() <= elastic);
}

#[test]
fn unloading_heals_nothing_and_reloading_breaks_nothing_more() {
    let cycle = "mechanics.boundary.top={displacement = [0, {time = [0, 1, 2, 3], \
                 value = [0, 3.5e-6, 1e-6, 3.5e-6]}]}";
    let run = |end: &str| {
        try_run(&with_step(
            notch(&[cycle, end, "time.first_step=0.5", "time.max_step=0.5"]),
            0.5,
        ))
        .unwrap()
    };
    let (loaded, once) = run("time.end=1");
    let (unloaded, back) = run("time.end=2");
    let (_, again) = run("time.end=3");
    let [first, second] = [loaded, unloaded].map(|summary| summary.results.unwrap());
    assert!((first.dissipated_energy / second.dissipated_energy - 1.0).abs() < 1e-12);
    assert!(
        back.history
            .iter()
            .zip(&once.history)
            .all(|(after, before)| after >= before)
    );
    let grown = again
        .history
        .iter()
        .zip(&once.history)
        .map(|(a, b)| (a - b).abs() / (b + 1e3));
    assert!(grown.fold(0.0, f64::max) < 1e-3);
}

/// The tangents differ, the equilibrium does not.
#[test]
fn newton_and_alternate_minimisation_find_the_same_state() {
    let run = |method| {
        let mut plan = with_step(notch(&["time.end=3000", "damage.tolerance=1e-7"]), 1500.0);
        plan.damage.as_mut().unwrap().method = method;
        try_run(&plan).unwrap()
    };
    let (auto, first) = run(DamageMethod::Auto);
    let (alternate, second) = run(DamageMethod::Alternate);
    let largest = first
        .displacement
        .iter()
        .fold(0.0_f64, |m, u| m.max(u.abs()));
    let pairs = first.displacement.iter().zip(&second.displacement);
    let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-4 * largest, "{apart} of {largest}");
    let [auto, alternate] = [auto, alternate].map(|summary| summary.counters.newton_iterations);
    assert!(auto < alternate, "{auto} {alternate}");
}

#[test]
fn too_few_iterations_are_named_and_nothing_is_accepted() {
    let plan = with_step(notch(&["damage.iterations=3"]), 6000.0);
    let Err(RunError::Step { source, .. }) = try_run(&plan) else {
        panic!("three iterations cannot break a specimen");
    };
    assert!(matches!(source, StepError::DamageNotConverged { residual, .. } if residual > 1e-4));
    assert!(source.to_string().contains("damage.iterations"));
}

/// What is pumped in is in the crack, in the pores, or gone through the sides.
#[test]
fn injection_balances_mass_and_forces() {
    let quick = [
        "output.plots=false",
        "time.end=0.02",
        "time.max_step=0.02",
        "geometry.spacing=0.04",
    ];
    let (summary, state) = try_run(&plan_of_variant("injection-rate", "smoke", &quick)).unwrap();
    assert!(finite(&state));
    assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
    assert!(summary.balance.momentum.unwrap() < 1e-4);
    let results = summary.results.unwrap();
    assert!(
        results.peak_injection_pressure.unwrap() > 1e4,
        "{results:?}"
    );
}

/// A crack that grows into another one: where bonds counted for the opening by thresholds, passes went
/// round in circles; now they are few in every step.
#[test]
fn a_crack_that_grows_takes_few_passes_a_step() {
    let quick = [
        "output.plots=false",
        "materials.rock.fracture_energy=20",
        "cracks.main.injection={rate = \"3e-3 m^2/s\", at = [0, 0.48]}",
        "cracks.vertical.points=[[0.3, 0.3], [0.3, 0.66]]",
        "time.end=0.2",
    ];
    let plan = plan_of_variant("natural-fractures", "smoke", &quick);
    let (summary, state) = try_run(&plan).unwrap();
    assert!(finite(&state));
    assert!(summary.balance.mass < 1e-10, "{}", summary.balance.mass);
    // 0.15 m and 0.36 m are there from the start, 0.15 m lie between them.
    let results = summary.results.unwrap();
    assert!(
        (0.58..0.70).contains(&results.crack_length),
        "{}",
        results.crack_length
    );
    let uneven = unevenness(&plan, &state);
    assert!(uneven < 1e-4, "{uneven}");
    let passes = summary.counters.coupling_iterations;
    assert!(
        passes <= 10 * summary.steps,
        "{passes} in {}",
        summary.steps
    );
}

/// A hundred times the step of the case.
#[test]
fn a_step_a_hundred_times_longer_ends_in_balance_or_is_named() {
    let quick = ["output.plots=false", "geometry.spacing=0.04"];
    match try_run(&with_step(
        plan_of_variant("injection-rate", "smoke", &quick),
        0.4,
    )) {
        Ok((summary, state)) => {
            assert!(finite(&state));
            assert!(summary.balance.mass < 1e-6 && summary.balance.momentum.unwrap() < 1e-4);
        }
        Err(error) => assert!(error.to_string().contains("damage.iterations"), "{error}"),
    }
}

/// Turns agree with both at once where the pressure is prescribed. The load stays below the one at which the crack
/// runs, past which the two may stop at different states of balance.
#[test]
fn fields_in_turns_agree_with_both_at_once_under_a_prescribed_pressure() {
    let run = |scheme: &str| {
        let quick = ["output.plots=false", "time.end=440 s", scheme];
        try_run(&plan_of_variant("pressurised-notch", "smoke", &quick)).unwrap()
    };
    let (_, turns) = run("scheme.name=staggered");
    let (_, both) = run("scheme.name=monolithic");
    let largest = both
        .displacement
        .iter()
        .fold(0.0_f64, |m, u| m.max(u.abs()));
    let pairs = both.displacement.iter().zip(&turns.displacement);
    let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-3 * largest, "{apart} of {largest}");
}

/// Algorithm 2 with the same forces: another way to the same equilibrium. The load stays below the
/// one at which the crack runs, past which the two may stop at different states of balance.
#[test]
fn dynamic_relaxation_weakens_the_same_rock() {
    let run = |scheme: &str| {
        let quick = [
            "time.end=3000",
            "damage.tolerance=1e-6",
            "scheme.adr_tolerance=1e-6",
            scheme,
        ];
        let (summary, state) = try_run(&with_step(notch(&quick), 1000.0)).unwrap();
        let dissipated = summary.results.unwrap().dissipated_energy;
        (summary.counters, dissipated, state.displacement)
    };
    let (counters, by_relaxation, first) = run("scheme.name=explicit");
    let (_, by_newton, second) = run("scheme.name=implicit");
    assert!(counters.relaxation_iterations > 100);
    assert!(by_newton > 0.0);
    assert!(
        (by_relaxation / by_newton - 1.0).abs() < 1e-3,
        "{by_relaxation} against {by_newton}"
    );
    let largest = second.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let pairs = first.iter().zip(&second);
    let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-3 * largest, "{apart} of {largest}");
}
