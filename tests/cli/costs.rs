//! Costs of cases without an exact solution, and what of them is not resolved.

use serde_json::Value;

use crate::studies::{SMALL, report};
use crate::support::Place;

/// Without an exact solution errors are distances from a run that is far finer and verified itself.
#[test]
fn the_cost_of_a_case_without_an_exact_solution() {
    let place = Place::new();
    let arguments = [
        "study",
        "cost",
        "heterogeneous",
        "--set",
        "time={end=\"1 min\", tolerance=1e-4}",
        "--set",
        "output={times=[\"10 s\"]}",
        // Smooth enough to converge on few points.
        "--set",
        "materials.rock.permeability={distribution=\"log-normal\", median=\"10 mD\", log10_std=0.2, \
         correlation_length=\"5 m\", seed=1}",
        "--points",
        "8,12",
        "--schemes",
        "implicit",
        "--solvers",
        "faer-llt",
        "--quick",
        "--defaults",
        "--out",
        "s",
    ];
    let printed = place.succeed(&arguments);
    assert!(
        printed.contains("over-resolved run of 2304 points"),
        "{printed}"
    );
    let report = report(&place, "s");
    let exact = &report["findings"]["over_resolved"]["run"];
    let uncertainty = exact["uncertainty"]["pressure"].as_f64().unwrap();
    assert!(uncertainty > 0.0 && uncertainty < 3e-3, "{exact}");
    assert!(exact["fall"].as_f64().unwrap() > 2.0, "{exact}");
    let runs = report["runs"].as_array().unwrap();
    let (chain, own): (Vec<&Value>, Vec<&Value>) = runs
        .iter()
        .partition(|run| run["scheme"] == "over-resolved");
    assert_eq!((chain.len(), own.len()), (3, 8));
    assert!(chain.iter().all(|run| run["resolved"] == false));
    for run in own {
        let error = run["measures"]["error"].as_f64().unwrap();
        let resolved = run["resolved"].as_bool().unwrap();
        assert!(error > 0.0 && error < 0.1, "{run}");
        assert_eq!(resolved, error >= 3.0 * uncertainty, "{run}");
        assert!(
            resolved,
            "a quarter of the spacing resolves second order: {run}"
        );
    }
    let page = String::from_utf8(place.read("s/report.html")).unwrap();
    assert!(page.contains("Richardson"));
}

/// An uncertainty as large as the errors leaves no figure that a reader could trust.
#[test]
fn errors_within_the_uncertainty_are_not_resolved() {
    let place = Place::new();
    let printed = place.succeed(&[
        "study",
        "cost",
        "footing",
        "--points",
        "10",
        "--schemes",
        "monolithic",
        "--solvers",
        "faer-ldlt",
        "--quick",
        "--defaults",
        "--budget",
        "5min",
        "--out",
        "s",
    ]);
    assert!(printed.contains("does not converge well"), "{printed}");
    let report = report(&place, "s");
    for run in report["runs"].as_array().unwrap() {
        assert_eq!(run["resolved"], false, "{run}");
    }
    let page = String::from_utf8(place.read("s/report.html")).unwrap();
    assert!(page.contains("error not resolved"));
}

/// Where rock breaks methods are compared on the scene's own cloud. In turns and both at once come to the same
/// state, so they have the same error at the same bound of the steps.
#[test]
fn the_cost_of_rock_that_breaks_is_compared_on_one_cloud() {
    let place = Place::new();
    place.succeed(&[
        "study",
        "cost",
        "natural-fractures/smoke",
        "--set",
        "geometry.spacing=4 cm",
        "--set",
        "damage.length_scale=12 cm",
        "--schemes",
        "monolithic,staggered",
        "--solvers",
        "auto",
        "--quick",
        "--budget",
        "5min",
        "--out",
        "s",
    ]);
    let report = report(&place, "s");
    let runs = report["runs"].as_array().unwrap();
    let errors = |scheme: &str| -> Vec<(f64, f64)> {
        let own = runs.iter().filter(|run| run["scheme"] == scheme);
        own.map(|run| {
            assert_eq!(run["measures"]["points"], 288.0, "{run}");
            let step = run["varied"]["largest step"].as_f64().unwrap();
            (step, run["measures"]["error"].as_f64().unwrap())
        })
        .collect()
    };
    let both = errors("monolithic backward Euler");
    let turns = errors("staggered backward Euler");
    assert_eq!((both.len(), turns.len()), (2, 2));
    for ((step, both), (same, turns)) in both.iter().zip(&turns) {
        assert!((step - same).abs() < 1e-12);
        assert!((both / turns - 1.0).abs() < 0.02, "{both} and {turns}");
    }
    let (long, short) = (both[0], both[1]);
    assert!(short.0 < long.0 && short.1 < 0.9 * long.1, "{both:?}");
    let judged = &report["findings"]["over_resolved"]["run"];
    // The finest level is left out where the budget does not reach.
    let share = judged["step"].as_f64().unwrap() / short.0;
    assert!(
        [0.25, 0.125]
            .iter()
            .any(|expected| (share - expected).abs() < 1e-9),
        "{judged}"
    );
}

/// Settings are runs of their own, and the line of a method goes through the cheapest of all.
#[test]
fn a_study_of_cost_tries_settings_and_tells_which_were_worth_it() {
    let place = Place::new();
    let small = &SMALL[..SMALL.len() - 1];
    place.succeed(&[small, &["--out", "s"]].concat());
    let report = report(&place, "s");
    let runs = report["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 16, "constant steps beside the adaptive ones");
    for run in runs {
        let constant = run["setting"] == "constant steps";
        assert_eq!(run["varied"]["step"].is_number(), constant, "{run}");
        assert_eq!(run["varied"]["tolerance"].is_number(), !constant, "{run}");
        let beaten = run["status"] == "beaten";
        assert!(run["status"] == "done" || (beaten && constant), "{run}");
        let steps = run["measures"]["steps"].as_f64();
        let count = run["varied"]["step"]
            .as_f64()
            .map(|step| (0.02 / step).round());
        assert!(beaten || !constant || steps == count, "{run}");
    }
    let page = String::from_utf8(place.read("s/report.html")).unwrap();
    assert!(page.contains("Settings that were tried") && page.contains("as it comes"));
    for picture in ["cost.svg", "cost-cpu.svg", "cost-memory.svg"] {
        assert!(place.path(&format!("s/{picture}")).exists(), "{picture}");
    }
    let table = String::from_utf8(place.read("s/cost.csv")).unwrap();
    assert!(
        table.starts_with("scheme,solver,setting,operator,"),
        "{table}"
    );
}
