//! Coupled scenes from the command line: what they write, and how unstable coupling is told.

use serde_json::Value;

use crate::support::Place;

const COARSE: [&str; 4] = ["--set", "geometry.spacing=0.5", "--set", "time.step=5"];

fn arguments<'a>(case: &'a str, own: &[&'a str]) -> Vec<&'a str> {
    [&["run", case, "--out", "out"][..], own].concat()
}

#[test]
fn a_coupled_run_writes_displacements_and_forces_beside_the_pressure() {
    let place = Place::new();
    let text = place.succeed(&arguments("terzaghi", &[&COARSE[..], &["--json"]].concat()));
    let summary: Value = serde_json::from_str(&text).unwrap();
    for field in ["pressure", "displacement"] {
        let error = summary["errors"][field]["l2"].as_f64().unwrap();
        assert!(error > 0.0 && error < 1e-2, "{field}: {error}");
    }
    assert_eq!(summary["errors_over_time"].as_array().unwrap().len(), 3);
    assert!(summary["balance"]["momentum"].as_f64().unwrap() < 1e-11);
    assert!(summary["balance"]["energy"].as_f64().unwrap() > 0.0);
    let files = place.list("out");
    for name in [
        "displacement-0003.png",
        "fields-0003.vtu",
        "history-displacement.svg",
        "profile-axis-displacement.svg",
    ] {
        assert!(files.iter().any(|file| file == name), "{name} in {files:?}");
    }
    let history = String::from_utf8(place.read("out/history.csv")).unwrap();
    let head = history.lines().next().unwrap();
    for column in [
        "displacement_x_near_m",
        "energy_J",
        "potential_J",
        "momentum_balance",
    ] {
        assert!(head.contains(column), "{column} in {head}");
    }
    let fields = place.read("out/fields-0003.vtu");
    let fields = String::from_utf8_lossy(&fields);
    for name in [
        "displacement",
        "effective_stress",
        "volumetric_strain",
        "velocity",
    ] {
        assert!(fields.contains(&format!("Name=\"{name}\"")), "{name}");
    }
}

#[test]
fn the_lagged_coupling_of_the_paper_ends_by_name_and_keeps_its_output() {
    let place = Place::new();
    let own = [
        "--set",
        "geometry.spacing=0.5",
        "--scheme",
        "explicit",
        "--set",
        "scheme.relaxation=0",
    ];
    let outcome = place.run(&arguments("terzaghi", &own));
    assert_eq!(outcome.code, Some(4), "{outcome:?}");
    for part in [
        "coupling unstable at t = ",
        "α²/(s(λ+2μ)) = 15.152",
        "scheme.relaxation = 0; set scheme.relaxation = 1, or use --scheme monolithic",
        "the output at t = 0.000000e0 s is kept",
    ] {
        assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
    }
    let files = place.list("out");
    assert!(files.contains(&"fields-0000.vtu".to_owned()), "{files:?}");
    assert!(files.contains(&"history.csv".to_owned()), "{files:?}");
}

#[test]
fn schemes_refuse_what_they_cannot_run_with_a_reason() {
    let place = Place::new();
    let stabilised = arguments("footing", &["--scheme", "explicit"]);
    let outcome = place.run(&stabilised);
    assert_eq!(outcome.code, Some(3), "{outcome:?}");
    let reason = "`stabilisation` needs a linear system";
    assert!(outcome.stderr.contains(reason), "{}", outcome.stderr);
    let wrong = arguments(
        "terzaghi",
        &[&COARSE[..], &["--solver", "faer-llt"]].concat(),
    );
    let outcome = place.run(&wrong);
    assert_eq!(outcome.code, Some(3), "{outcome:?}");
    assert!(outcome.stderr.contains("faer-llt"), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("quasi-definite"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn coupled_runs_give_the_same_bits_with_any_number_of_threads() {
    let place = Place::new();
    let run = |scheme: &str, threads: &str| {
        let own = ["--scheme", scheme, "--threads", threads, "--quiet"];
        place.succeed(&arguments("terzaghi", &[&COARSE[..], &own].concat()));
        (
            place.read("out/history.csv"),
            place.read("out/fields-0003.vtu"),
        )
    };
    for scheme in ["monolithic", "staggered", "semi-implicit"] {
        let one = run(scheme, "1");
        for threads in ["2", "3"] {
            assert!(
                one == run(scheme, threads),
                "{scheme} with {threads} threads"
            );
        }
    }
}
