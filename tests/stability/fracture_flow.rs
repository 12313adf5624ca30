//! Fluid in rock that breaks, under all schemes: what is full, closed, cut off or conducts ten thousand
//! million times as well as the rock.

use perifrac::plan::{Plan, StepRule};
use perifrac::run::{RunError, Summary};
use perifrac::schemes::{State, StepError};

use crate::support::{extremes, largest_difference, plan_of_variant, try_run};

/// A crack that fluid is pumped into, 288 points, in the model of the paper.
fn pumped(overrides: &[&str]) -> Plan {
    let quick = [
        "output.plots=false",
        "geometry.spacing=0.04",
        "flow.operator=bond",
        "fracture_flow.storage=1e-10",
        "damage.model=paper",
        "damage.length_scale=0.03",
        "damage.normalise=true",
    ];
    plan_of_variant("injection-rate", "smoke", &[&quick[..], overrides].concat())
}

fn with_step(mut plan: Plan, step: f64, steps: usize) -> Plan {
    plan.time.step = StepRule::Fixed(step);
    plan.time.max_step = None;
    plan.time.end = step * steps as f64;
    plan
}

/// Largest difference of the displacements, relative to the largest one.
fn apart(found: &(Summary, State), reference: &(Summary, State)) -> f64 {
    largest_difference(&found.1.displacement, &reference.1.displacement) / size(reference)
}

fn size((_, state): &(Summary, State)) -> f64 {
    let largest = state.displacement.iter().map(|u| u.abs());
    largest.fold(0.0, f64::max)
}

#[test]
fn a_pumped_crack_is_the_same_in_turns_and_both_at_once() {
    let run = |scheme: &str| try_run(&pumped(&["time.end=0.2", scheme])).unwrap();
    let both = run("scheme.name=monolithic");
    let turns = run("scheme.name=staggered");
    assert!(apart(&turns, &both) < 1e-4, "{}", apart(&turns, &both));
    let (summary, steps) = (&turns.0, turns.0.steps);
    assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
    let passes = summary.counters.coupling_iterations;
    assert!(passes <= 40 * steps, "{passes} passes in {steps} steps");
}

/// In large first steps opening and flow throw each other back and forth: passes of full length run in
/// circles and never end, at any step.
#[test]
fn passes_that_run_in_circles_are_shortened_until_they_meet() {
    let run = |scheme: &str| {
        let plan = plan_of_variant(
            "natural-fractures",
            "smoke",
            &[
                "output.plots=false",
                "geometry.spacing=0.04",
                "damage.length_scale=0.12",
                "damage.largest_increment=0.6",
                "time.end=0.1",
                "time.first_step=0.02",
                "time.max_step=0.2",
                // Steps as large as these are what it takes.
                "time.tolerance=3e-2",
                scheme,
            ],
        );
        try_run(&plan).unwrap()
    };
    let (both, turns) = (run("scheme.name=monolithic"), run("scheme.name=staggered"));
    assert!(apart(&turns, &both) < 1e-4, "{}", apart(&turns, &both));
    let (steps, rejected) = (turns.0.steps, turns.0.counters.rejected);
    assert_eq!((steps, rejected), (both.0.steps, both.0.rejected));
    let passes = turns.0.counters.coupling_iterations;
    assert!(passes <= 30 * steps, "{passes} passes in {steps} steps");
}

/// A closed crack that nothing presses takes next to nothing up before it opens: the first pass goes far out, and what it
/// found was the scale by which the next ones were in balance.
#[test]
fn a_closed_crack_is_filled_by_the_first_step_that_ends_the_run() {
    let set = [
        "output.plots=false",
        "time.first_step=0.1 s",
        "time.end=0.1 s",
    ];
    let plan = plan_of_variant("kgd-toughness", "smoke", &set);
    let (summary, _) = try_run(&plan).unwrap();
    let volume = summary.results.as_ref().unwrap().crack_volume.unwrap();
    assert!((volume / 2.5e-6 - 1.0).abs() < 1e-5, "{volume}");
    let (steps, rejected) = (summary.steps, summary.counters.rejected);
    assert!(steps <= 24 && rejected <= 8, "{steps} and {rejected}");
}

/// Where two principal stresses are nearly equal in rock that breaks the axes turn faster than the stress.
#[test]
fn normals_that_turn_with_the_stress_belong_to_the_tangent() {
    let plan = plan_of_variant("two-cracks", "smoke", &["output.plots=false"]);
    let (summary, _) = try_run(&plan).unwrap();
    let (steps, passes) = (summary.steps, summary.counters.coupling_iterations);
    assert!(passes <= 13 * steps, "{passes} passes in {steps} steps");
}

/// What `plan` says of the solver is what runs, and flexible GMRES asked for finds the same with a start that has no
/// fluid, whose matrix is of another kind.
#[test]
fn the_solver_of_a_crack_is_the_one_of_the_plan_or_the_one_that_is_asked_for() {
    let run = |set: &[&str]| {
        let set = [&["output.plots=false", "time.end=0.05 s"], set].concat();
        try_run(&plan_of_variant("kgd-toughness", "smoke", &set)).unwrap()
    };
    let (direct, asked) = (run(&[]), run(&["solver.name=fgmres:preconditioner=schur"]));
    assert_eq!(direct.0.solver.as_deref(), Some("faer-ldlt"));
    assert_eq!(
        asked.0.solver.as_deref(),
        Some("fgmres:preconditioner=schur")
    );
    assert!(apart(&asked, &direct) < 1e-3, "{}", apart(&asked, &direct));
}

/// Algorithm 3 with the compliance of the fracture: of first order in the step.
#[test]
fn lagging_schemes_come_to_the_monolithic_pressure_as_steps_shrink() {
    let run = |scheme: &str, split: usize| {
        // Relaxed to 1e-5 the second step is as far off as the audit allows, 1.1 % of the fluid for 1 %.
        let plan = pumped(&[scheme, "scheme.adr_tolerance=3e-6"]);
        try_run(&with_step(plan, 1e-4 / split as f64, 40 * split)).unwrap()
    };
    let exact = run("scheme.name=monolithic", 5);
    for scheme in ["scheme.name=semi-implicit", "scheme.name=explicit"] {
        let [coarse, fine] = [1, 5].map(|split| {
            let found = run(scheme, split);
            assert_eq!(found.0.steps as usize, 40 * split);
            (apart(&found, &exact), found.0.balance.mass)
        });
        assert!(
            coarse.0 < 0.05 && fine.0 < 0.02,
            "{scheme}: {coarse:?} {fine:?}"
        );
        // What passes leave, a thousandth of the fluid in each step, does not shrink with the step.
        assert!(
            fine.0 < 0.6 * coarse.0 && fine.1 < 1e-2,
            "{scheme}: {coarse:?} {fine:?}"
        );
    }
}

/// The coupling as Algorithm 3 writes it: a full crack yields hundreds of times as much as its fluid.
#[test]
fn the_coupling_of_the_paper_is_refused_by_name_in_a_full_crack() {
    for scheme in ["explicit", "semi-implicit", "staggered"] {
        let scheme = format!("scheme.name={scheme}");
        let plan = with_step(pumped(&["scheme.relaxation=0", &scheme]), 1e-4, 10);
        let Err(RunError::Step { source, .. }) = try_run(&plan) else {
            panic!("{scheme}: lagged strain cannot be stable here");
        };
        assert!(
            matches!(source, StepError::FractureUnstable { strength, .. } if strength > 100.0),
            "{source}"
        );
    }
}

/// The compliance raises the limit of explicit steps, and they follow the crack as it opens.
#[test]
fn explicit_steps_keep_below_a_limit_that_falls_as_the_crack_opens() {
    let run = |end: &str| {
        let short = [
            "scheme.name=explicit",
            "time.first_step=0.001",
            "time.max_step=0.01",
        ];
        try_run(&pumped(&[&short[..], &[end]].concat())).unwrap()
    };
    let (early, _) = run("time.end=0.004");
    let (late, state) = run("time.end=0.01");
    let [first, last] = [&early, &late].map(|summary| summary.limit.as_ref().unwrap().dt);
    assert!(last < first, "{first} {last}");
    assert!(extremes(&state.pressure).1.is_finite());
    assert!(late.steps as f64 > 0.01 / first, "{} steps", late.steps);
}

/// The pressure in a crack rises and falls: what opened closes again, and nothing heals.
#[test]
fn a_crack_that_closes_conducts_like_the_rock_again() {
    let cycle = |end: &str| {
        let pressure = "cracks.main={kind = \"damaged\", points = [[0, 0.48], [0.15, 0.48]], \
                        pressure = {time = [0, 0.1, 0.2, 0.6], value = [0, 1.2e5, 0, 0]}}";
        let plan = pumped(&[pressure, end, "time.first_step=0.02", "time.max_step=0.02"]);
        try_run(&plan).unwrap()
    };
    let (open, closed) = (cycle("time.end=0.1"), cycle("time.end=0.6"));
    assert!(
        size(&open) > 1e-5 && size(&closed) < 0.05 * size(&open),
        "{} {}",
        size(&open),
        size(&closed)
    );
    let pairs = closed.1.history.iter().zip(&open.1.history);
    assert!(pairs.into_iter().all(|(after, before)| after >= before));
    assert!(closed.0.balance.mass < 1e-6, "{}", closed.0.balance.mass);
}

#[test]
fn a_fracture_that_conducts_1e10_times_as_well_keeps_bounds_and_mass() {
    let pressure =
        "cracks.main={kind = \"damaged\", points = [[0, 0.48], [0.15, 0.48]], pressure = 1e5}";
    for contrast in ["1e-8 m^2", "1e-5 m^2", "1e-2 m^2"] {
        let permeability = format!("fracture_flow.permeability={contrast:?}");
        let plan = pumped(&[pressure, &permeability, "time.end=0.1"]);
        let (summary, state) = try_run(&plan).unwrap();
        let (low, high) = extremes(&state.pressure);
        assert!(
            low > -1e-3 * high && high <= 1e5 * (1.0 + 1e-6),
            "{contrast}: {low} {high}"
        );
        assert!(
            summary.balance.mass < 1e-6,
            "{contrast}: {}",
            summary.balance.mass
        );
    }
}

/// A crack round a single point leaves it no bond: refused before anything is assembled.
#[test]
fn a_point_that_loses_all_its_bonds_is_named() {
    let around = "cracks.box={points = [[0.7e-3, 0.7e-3], [0.75e-3, 0.7e-3], [0.75e-3, 0.75e-3], \
                  [0.7e-3, 0.75e-3], [0.7e-3, 0.7e-3]]}";
    let plan = plan_of_variant(
        "notched-tension",
        "smoke",
        &["output.plots=false", "geometry.points=[20, 20]", around],
    );
    let error = try_run(&plan).err().map(|error| error.to_string());
    let error = error.unwrap_or_default();
    assert!(
        error.contains("singular shape tensor") && error.contains("0.000725"),
        "{error}"
    );
}
