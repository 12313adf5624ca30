//! Studies and reports from outside: numbers, rows of failures, interruption, pages.

use std::fs;

use serde_json::Value;

use crate::support::Place;

/// A study of two small clouds by one method: fractions of a second a run.
const SMALL: [&str; 14] = [
    "study",
    "cost",
    "two-layer",
    "--set",
    "time.end=0.02",
    "--set",
    "output={times=[], plots=false}",
    "--points",
    "12,20",
    "--schemes",
    "implicit",
    "--solvers",
    "faer-llt",
    "--quick",
];

fn report(place: &Place, folder: &str) -> Value {
    serde_json::from_slice(&place.read(&format!("{folder}/report.json"))).unwrap()
}

#[test]
fn the_report_has_the_numbers_of_the_single_runs() {
    let place = Place::new();
    place.succeed(&[&SMALL[..], &["--out", "s"]].concat());
    let report = report(&place, "s");
    let runs = report["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 8, "2 clouds × 2 integrators × 2 tolerances");
    let run = &runs[5];
    let mut arguments = vec!["run", "two-layer", "--json", "--quiet", "--out", "single"];
    arguments.extend(&SMALL[3..7]);
    for text in run["overrides"].as_array().unwrap() {
        arguments.extend(["--set", text.as_str().unwrap()]);
    }
    let single: Value = serde_json::from_str(&place.succeed(&arguments)).unwrap();
    assert_eq!(
        run["errors"]["pressure"],
        single["errors_over_time"][0]["pressure"]["l2"]
    );
    assert_eq!(run["measures"]["steps"].as_f64(), single["steps"].as_f64());
    assert_eq!(
        run["measures"]["points"].as_f64(),
        single["points"].as_f64()
    );
    let factorisations = &single["counters"]["solver"]["factorisations"];
    assert_eq!(
        run["measures"]["factorisations"].as_f64(),
        factorisations.as_f64()
    );
    for measure in ["wall_s", "cpu_s", "memory_bytes"] {
        assert!(
            run["measures"][measure].as_f64().unwrap() > 0.0,
            "{measure}"
        );
    }
    let table = String::from_utf8(place.read("s/cost.csv")).unwrap();
    assert_eq!(table.lines().count(), 9, "{table}");
    let page = String::from_utf8(place.read("s/report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("Pareto front"));
    assert!(
        !page.contains("src=\"http") && !page.contains("href=\"http"),
        "no network"
    );
}

#[test]
fn a_study_goes_on_where_it_stopped() {
    let place = Place::new();
    let arguments = [&SMALL[..], &["--out", "s"]].concat();
    place.succeed(&arguments);
    let log = String::from_utf8(place.read("s/log.jsonl")).unwrap();
    let lines: Vec<&str> = log.lines().collect();
    let half = &lines[3][..lines[3].len() / 2];
    place.write("s/log.jsonl", format!("{}\n{half}", lines[..3].join("\n")));
    place.succeed(&arguments);
    let again = String::from_utf8(place.read("s/log.jsonl")).unwrap();
    assert_eq!(
        again.lines().take(3).collect::<Vec<_>>(),
        lines[..3],
        "kept to the last digit"
    );
    assert_eq!(again.lines().count(), lines.len());
}

#[test]
fn a_run_that_fails_is_a_row_with_its_reason() {
    let place = Place::new();
    let few = ["--set", "time.max_steps=3", "--out", "s"];
    place.succeed(&[&SMALL[..], &few].concat());
    let report = report(&place, "s");
    for run in report["runs"].as_array().unwrap() {
        assert_eq!(run["status"], "failed", "{run}");
        assert_eq!(run["code"], 1);
        assert!(
            run["reason"]
                .as_str()
                .unwrap()
                .contains("raise time.max_steps"),
            "{run}"
        );
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_reports_what_is_done() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let place = Place::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    // Enough repetitions for the signal to come in between.
    command.args(SMALL).args(["--repeat", "1000", "--out", "s"]);
    command
        .current_dir(place.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut study = command.spawn().unwrap();
    let start = Instant::now();
    let rows =
        || fs::read_to_string(place.path("s/log.jsonl")).map_or(0, |text| text.lines().count());
    while rows() < 2 && start.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let id = study.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(study.wait().unwrap().code(), Some(130));
    let report = report(&place, "s");
    assert_eq!(report["complete"], false);
    assert!(!report["runs"].as_array().unwrap().is_empty());
    let parts = place
        .list("s")
        .into_iter()
        .filter(|name| name.ends_with(".part"));
    assert_eq!(parts.count(), 0);
}

#[test]
fn a_case_that_does_not_suit_is_refused_with_a_remedy() {
    let place = Place::new();
    for (arguments, remedy) in [
        (&["study", "contrast", "terzaghi"][..], "two-layer"),
        (&["study", "cost", "footing"], "[reference]"),
        (&["report", "nowhere"], "perifrac run"),
        (&["plan", "terzaghi", "--for-error", "2"], "between 0 and 1"),
    ] {
        let outcome = place.run(arguments);
        assert_eq!(outcome.code, Some(2), "{outcome:?}");
        assert!(outcome.stderr.contains(remedy), "{outcome:?}");
    }
}

#[test]
fn a_run_is_put_on_one_page() {
    let place = Place::with_scene(&[("plots = false", "plots = true")]);
    place.succeed(&["run", "scene.toml", "--out", "out"]);
    place.succeed(&["report", "out"]);
    let page = String::from_utf8(place.read("out/report.html")).unwrap();
    for part in [
        "<svg",
        "data:image/png;base64,",
        "Balances",
        "Counters",
        "resolved.toml",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn a_forecast_names_a_command_that_runs() {
    let place = Place::new();
    let small = ["--set", "time.end=0.02", "--set", "geometry.points=[20, 5]"];
    let plan = [
        "plan",
        "two-layer",
        "--for-error",
        "5e-2",
        "--scheme",
        "implicit",
        "--json",
    ];
    let text = place.succeed(&[&plan[..], &small].concat());
    let forecast: Value = serde_json::from_str(&text).unwrap();
    assert!(forecast["seconds"].as_f64().unwrap() > 0.0);
    assert!(forecast["interval"][1].as_f64() > forecast["interval"][0].as_f64());
    let command = forecast["command"].as_str().unwrap();
    let words = command.replace('\'', "");
    let sets: Vec<&str> = words.split(" --set ").skip(1).collect();
    let mut arguments = vec!["run", "two-layer", "--json", "--quiet"];
    sets.iter()
        .for_each(|text| arguments.extend(["--set", text]));
    let run: Value = serde_json::from_str(&place.succeed(&arguments)).unwrap();
    assert!(
        run["errors"]["pressure"]["l2"].as_f64().unwrap() < 0.1,
        "{run}"
    );
}
