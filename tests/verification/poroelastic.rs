//! Terzaghi's and Mandel's problems with all schemes.

use perifrac::run::{RunError, Summary};
use perifrac::schemes::{self, State, StepError};

use crate::stages::SQUARE;
use crate::support::{model, plan, plan_of, probe_values, run_case, run_text, try_run};

/// Relative L2 error (norm over norm) of a field at all outputs.
fn norms(summary: &Summary, field: &str) -> Vec<f64> {
    summary
        .errors_over_time
        .iter()
        .map(|at| at.errors[field].l2_over_norm)
        .collect()
}

#[track_caller]
fn assert_below(summary: &Summary, bar: f64) {
    for field in ["pressure", "displacement"] {
        let errors = norms(summary, field);
        println!("{} {} {field}: {errors:?}", summary.case, summary.scheme);
        assert_eq!(errors.len(), 3, "15, 30 and 60 s");
        assert!(
            errors.iter().all(|error| *error <= bar),
            "{field}: {errors:?}"
        );
    }
}

#[test]
fn terzaghi_monolithic_and_staggered_at_15_30_and_60_s() {
    let (monolithic, _) = run_case("terzaghi", &["time.tolerance=1e-3"]);
    assert_below(&monolithic, 1e-3);
    assert!(monolithic.balance.mass < 1e-12 && monolithic.balance.momentum.unwrap() < 1e-11);
    let staggered = [
        "scheme.name=staggered",
        "time.tolerance=2e-3",
        "time.first_step=0.1",
    ];
    let (staggered, _) = run_case("terzaghi", &staggered);
    assert_below(&staggered, 1e-3);
    assert!(
        staggered.balance.mass < 1e-7,
        "{:.1e}",
        staggered.balance.mass
    );
    assert_eq!(staggered.counters.mechanics.unwrap().factorisations, 1);
}

#[test]
fn terzaghi_on_graded_clouds_with_the_consistent_gradient() {
    for case in ["terzaghi-graded", "terzaghi-tensor"] {
        let (consistent, _) = run_case(case, &["time.step=2"]);
        assert_below(&consistent, 1.5e-3);
        let plain = [
            "mechanics.gradient=plain",
            "flow.gradient=plain",
            "time.step=2",
        ];
        let (plain, _) = run_case(case, &plain);
        let (with, without) = (
            norms(&consistent, "displacement"),
            norms(&plain, "displacement"),
        );
        println!(
            "{case} plain: u {without:?}, p {:?}",
            norms(&plain, "pressure")
        );
        assert!(without[2] > 3.0 * with[2], "{without:?} {with:?}");
    }
}

#[test]
fn a_column_in_space_consolidates_like_one_in_the_plane() {
    let (summary, _) = run_case("column-3d", &[]);
    for field in ["pressure", "displacement"] {
        let errors = norms(&summary, field);
        println!("column-3d {field}: {errors:?}");
        assert!(
            errors.iter().all(|error| *error < 2e-3),
            "{field}: {errors:?}"
        );
    }
}

const COARSE: [&str; 2] = ["geometry.spacing=0.5", "output.times=[\"15 s\", \"30 s\"]"];

/// Norm of the difference over the norm, of pressure and of displacement.
fn difference(a: &State, b: &State) -> [f64; 2] {
    [
        (&a.pressure, &b.pressure),
        (&a.displacement, &b.displacement),
    ]
    .map(|(a, b)| {
        let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        perifrac_solvers::norm2(&change) / perifrac_solvers::norm2(b)
    })
}

#[test]
fn explicit_with_the_fixed_stress_term_reproduces_the_field() {
    let (_, reference) = run_case(
        "terzaghi",
        &[&COARSE[..], &["time.tolerance=1e-5"]].concat(),
    );
    for scheme in ["scheme.name=explicit", "scheme.name=semi-implicit"] {
        let (summary, state) = run_case("terzaghi", &[&COARSE[..], &[scheme]].concat());
        let apart = difference(&state, &reference);
        println!(
            "{}: p and u apart {apart:?}, errors {:?}",
            summary.scheme, summary.errors
        );
        assert!(apart.iter().all(|apart| *apart < 1e-2), "{apart:?}");
        assert!(summary.balance.momentum.unwrap() < 1e-4);
    }
}

/// Theory, section 16: with lagged strain alone the amplification is −τ = −15.15.
#[test]
fn the_form_of_the_paper_is_reported_as_unstable() {
    let paper = [
        &COARSE[..],
        &["scheme.name=explicit", "scheme.relaxation=0"],
    ]
    .concat();
    match try_run(&plan("terzaghi", &paper)) {
        Err(RunError::Step {
            source,
            last_output,
            ..
        }) => {
            let StepError::CouplingUnstable {
                strength,
                relaxation,
                ..
            } = source
            else {
                panic!("{source}");
            };
            assert!((strength - 15.1515).abs() < 1e-3 && relaxation == 0.0);
            assert_eq!(last_output, Some(0.0), "the output before is kept");
        }
        other => panic!("{:?}", other.map(|(summary, _)| summary.errors)),
    }
    for scheme in ["scheme.name=staggered", "scheme.name=semi-implicit"] {
        let lagged = [&COARSE[..], &[scheme, "scheme.relaxation=0"]].concat();
        let error = try_run(&plan("terzaghi", &lagged)).map(|_| ()).unwrap_err();
        let named = matches!(
            &error,
            RunError::Step {
                source: StepError::CouplingDiverged { .. },
                ..
            }
        );
        assert!(named, "{error}");
    }
}

#[test]
fn mandel_pressure_and_its_rise_above_the_undrained_one() {
    // p(0⁺) and p at t = 0.01, 0.05, 0.1, 0.3 in the middle (exact series).
    let exact = [0.502936501, 0.427684405, 0.293181580, 0.062790296];
    for scheme in ["monolithic", "staggered"] {
        let name = format!("scheme.name={scheme}");
        let ends = [0.01, 0.05, 0.1, 0.3];
        for (end, exact) in ends.into_iter().zip(exact) {
            let end = format!("time.end={end}");
            let overrides = [
                name.as_str(),
                &end,
                "output.times=[]",
                "time.tolerance=1e-3",
                "output.probes.centre.at=[0, 0.05]",
            ];
            let plan = plan("mandel", &overrides);
            let found = probe_values(&plan)[0];
            println!("mandel {scheme} {end}: {found:.6} against {exact:.6}");
            assert!(
                (found - exact).abs() < 0.01 * exact,
                "{end}: {found} {exact}"
            );
        }
        // The undrained start, before the rise.
        let plan = plan(
            "mandel",
            &[&name, "time.end=1e-9", "time.step=1e-9", "output.times=[]"],
        );
        let (summary, _) = try_run(&plan).unwrap();
        let highest = summary.pressure_range.unwrap()[1];
        assert!((highest - 0.4795204795).abs() < 1e-3, "{highest}");
        assert!(exact[0] > 1.04 * highest);
    }
}

#[test]
fn the_explicit_schemes_find_mandel_too() {
    let overrides = [
        "scheme.name=semi-implicit",
        "time.end=0.1",
        "output.times=[]",
    ];
    let (summary, _) = run_case(
        "mandel",
        &[&overrides[..], &["geometry.spacing=0.025"]].concat(),
    );
    assert!(
        summary.errors["pressure"].l2_over_norm < 1e-2,
        "{:?}",
        summary.errors
    );
}

#[test]
fn one_factorisation_at_constant_steps_whatever_their_number() {
    let text = perifrac::cases::find("terzaghi").unwrap().scene;
    let text = text.split("[reference]").next().unwrap();
    let common = ["geometry.spacing=0.5", "output.times=[]", "time.step=1"];
    let ramp = "mechanics.boundary.left.traction=[{time=[0, 10], value=[0, 1e4]}, 0]";
    let from_rest = [&common[..], &["coupling.undrained_start=false", ramp]].concat();
    for integrator in ["backward-euler", "tr-bdf2"] {
        for scheme in ["monolithic", "staggered"] {
            let (name, integrator) = (
                format!("scheme.name={scheme}"),
                format!("time.integrator={integrator}"),
            );
            let own = [name.as_str(), integrator.as_str()];
            let (summary, _) = run_text(text, &[&from_rest[..], &own].concat());
            let counters = &summary.counters;
            assert_eq!(
                (counters.steps, counters.solver.factorisations),
                (60, 1),
                "{own:?}"
            );
            let solid = counters
                .mechanics
                .as_ref()
                .map(|solid| solid.factorisations);
            assert_eq!(solid, (scheme == "staggered").then_some(1), "{own:?}");
            // The undrained start has no flow: one matrix more, and none for the staggered scheme.
            let (summary, _) = run_text(text, &[&common[..], &own].concat());
            let more = u64::from(scheme == "monolithic");
            assert_eq!(summary.counters.solver.factorisations, 1 + more, "{own:?}");
        }
    }
}

/// Theory, section 16: the disagreement of flow and mechanics shrinks by (β − b)/(S + β + d) per pass. One
/// mode of a strip that is sealed and held all around, b = α²/M and d = Δt κ k² of that mode.
#[test]
fn fixed_stress_contracts_as_its_fourier_factor() {
    let strip = r#"
title = "one mode"
[geometry]
type = "lattice"
size = [1, 0.1]
points = [80, 8]
[fluid]
viscosity = 1
[materials.rock]
youngs_modulus = 1
poissons_ratio = 0
biot_coefficient = 1
permeability = 1
storage = 0.2
[flow]
[mechanics.boundary.left]
roller = true
[mechanics.boundary.right]
roller = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.top]
roller = true
[coupling]
undrained_start = false
[scheme]
name = "staggered"
acceleration = "none"
coupling_tolerance = 1e-6
[time]
end = 0.01
step = 0.01
integrator = "backward-euler"
[wells.source]
at = [0.2, 0.05]
rate = 1
radius = 0.15
[wells.sink]
at = [0.8, 0.05]
rate = -1
radius = 0.15
"#;
    let (summary, _) = run_text(strip, &[]);
    let found = summary.coupling.unwrap().contraction.unwrap();
    // M = E = 1, β = α²/(λ + μ) = 2, b = 1; source and sink excite k = π most, and 3π.
    let factor = |k: f64| (2.0 - 1.0) / (0.2 + 2.0 + 0.01 * k * k);
    let pi = std::f64::consts::PI;
    println!(
        "contraction {found:.3}, factor of the first mode {:.3}",
        factor(pi)
    );
    assert!(
        found < factor(pi) * 1.02 && found > factor(7.0 * pi),
        "{found}"
    );
}

#[test]
fn a_coupled_scene_says_how_strongly_it_is_coupled() {
    let (summary, _) = run_case("terzaghi", &[&COARSE[..], &["time.step=1"]].concat());
    let coupling = summary.coupling.unwrap();
    // By hand: τ = α² A/s = 15.1515, c_v = 0.3752345216; Eq. 71 with ½ and Δx = 0.5.
    assert!((coupling.strength - 15.151515).abs() < 1e-5);
    assert!((coupling.consolidation - 0.3752345216).abs() < 1e-9);
    assert!((coupling.step_limit - 0.5 * 0.25 / 0.3752345216).abs() < 1e-9);
    let fields: Vec<_> = summary.counters.field_bytes.keys().collect();
    assert_eq!(fields, ["displacement", "pressure"]);
}

/// What points of prescribed pressure take in is part of the balance, strain content included.
#[test]
fn mass_is_balanced_with_prescribed_pressures_inside() {
    let text = perifrac::cases::find("terzaghi").unwrap().scene;
    let text = text.split("[output]").next().unwrap();
    let region = r#"flow.regions=[{region={type="box", min=[7, 0], max=[8, 1]}, pressure={time=[0, 30], value=[5000, 9000]}}]"#;
    let common = ["geometry.spacing=0.5", region];
    for (scheme, bar) in [("monolithic", 1e-11), ("staggered", 1e-7)] {
        let scheme = format!("scheme.name={scheme}");
        for integrator in ["time.integrator=tr-bdf2", "time.integrator=backward-euler"] {
            for stabilisation in ["coupling.stabilisation=0", "coupling.stabilisation=0.5"] {
                let own = [
                    scheme.as_str(),
                    integrator,
                    "time.tolerance=1e-2",
                    stabilisation,
                ];
                let (summary, _) = run_text(text, &[&common[..], &own].concat());
                println!("{own:?}: {:?}", summary.balance);
                assert!(
                    summary.balance.fixed != 0.0 && summary.balance.mass < bar,
                    "{own:?}"
                );
            }
        }
    }
}

#[test]
fn mass_is_balanced_with_prescribed_pressures_inside_and_inertia() {
    let text = perifrac::cases::find("terzaghi").unwrap().scene;
    let text = text.split("[output]").next().unwrap();
    let region = r#"flow.regions=[{region={type="box", min=[7, 0], max=[8, 1]}, pressure=5000}]"#;
    let inertia = [
        "mechanics.mode=dynamic",
        "materials.rock.density=2000",
        "time={end=0.05}",
    ];
    let common = [&["geometry.spacing=0.5", region][..], &inertia].concat();
    for scheme in ["explicit", "semi-implicit"] {
        let name = format!("scheme.name={scheme}");
        let own = [name.as_str(), "time.integrator=backward-euler"];
        let (summary, _) = run_text(text, &[&common[..], &own].concat());
        println!("{scheme}: {:?}", summary.balance);
        assert!(
            summary.balance.fixed != 0.0 && summary.balance.mass < 1e-11,
            "{scheme}"
        );
    }
}

#[test]
fn mass_is_balanced_with_prescribed_pressures_inside_and_no_mechanics() {
    let text = perifrac::cases::find("two-layer").unwrap().scene;
    let text = text.split("[output]").next().unwrap();
    let region = r#"flow.regions=[{region={type="box", min=[0.4, 0], max=[0.6, 0.25]}, pressure={time=[0, 0.1], value=[0.3, 0.9]}}]"#;
    for scheme in ["scheme.name=implicit", "scheme.name=explicit"] {
        let own = ["materials.left.permeability=2", region, scheme];
        let (summary, _) = run_text(text, &own);
        println!("{scheme}: {:?}", summary.balance);
        assert!(
            summary.balance.fixed != 0.0 && summary.balance.mass < 1e-11,
            "{scheme}"
        );
    }
}

/// A square between two rollers under tractions on the two other sides from t = 0 on, with fluid that is under
/// pressure already. Drained strain by hand: E ε_x = (1 + ν)((1 − ν) σ'_x − ν σ'_y) with σ' = σ + p.
#[test]
fn a_drained_start_is_the_equilibrium_at_the_pressure_that_is_given() {
    let drained = [
        "flow.initial_pressure=1 MPa",
        "coupling.undrained_start=false",
        "time.end=1e-3 s",
    ];
    for scheme in ["monolithic", "staggered", "semi-implicit", "explicit"] {
        let name = format!("scheme.name={scheme}");
        let overrides = [&drained[..], &[&*name]].concat();
        let plan = plan_of(SQUARE, &overrides);
        let model = model::<2>(&plan);
        let mut built = schemes::build(&plan, &model).unwrap();
        let mut state = State::initial(&model);
        built.start(&model, &mut state).unwrap();
        let exact = 1.25e-10 * (0.75 * -2e6 + 0.25 * 1e6) * (1.0 - 0.5 / 8.0);
        let found = state.displacement[2 * 63];
        assert!(
            (found / exact - 1.0).abs() < 1e-5,
            "{scheme}: {found} {exact}"
        );
        assert!(state.pressure.iter().all(|p| *p == 1e6), "{scheme}");
        let (summary, _) = run_text(SQUARE, &overrides);
        assert!(summary.balance.momentum.unwrap() < 1e-5, "{scheme}");
    }
}
