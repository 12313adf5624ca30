//! Studies and reports from outside: numbers, rows of failures, interruption, pages.

use std::fs;

use serde_json::Value;

use crate::support::Place;

/// A study of two small clouds by one method: fractions of a second a run.
pub const SMALL: [&str; 15] = [
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
    "--defaults",
];

pub fn report(place: &Place, folder: &str) -> Value {
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
    assert!(page.contains("<svg") && page.contains("The line of a method joins"));
    let drawing = String::from_utf8(place.read("s/cost.svg")).unwrap();
    let marks = drawing.matches("<circle").count() + drawing.matches("<polygon").count();
    assert_eq!(
        marks,
        8 + 2,
        "a mark per run, and of either method in the legend"
    );
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
    let lines = log(&place);
    let half = &lines[3][..lines[3].len() / 2];
    place.write("s/log.jsonl", format!("{}\n{half}", lines[..3].join("\n")));
    place.succeed(&arguments);
    let again = log(&place);
    assert_eq!(again[..3], lines[..3], "kept to the last digit");
    assert_eq!(again.len(), lines.len());
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

/// Interrupts a study as ctrl-C does, once its log has so many rows; gives its exit code.
#[cfg(unix)]
fn interrupt(place: &Place, arguments: &[&str], rows: usize) -> Option<i32> {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    command.args(arguments).current_dir(place.path(""));
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut study = command.spawn().unwrap();
    let start = Instant::now();
    while log(place).len() < rows && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = Command::new("kill")
        .args(["-INT", &study.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    study.wait().unwrap().code()
}

/// Lines of the log of the study in `s`.
fn log(place: &Place) -> Vec<String> {
    let text = fs::read_to_string(place.path("s/log.jsonl")).unwrap_or_default();
    text.lines().map(str::to_owned).collect()
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_reports_what_is_done() {
    let place = Place::new();
    // Enough repetitions for the signal to come in between.
    let arguments = [&SMALL[..], &["--repeat", "1000", "--out", "s"]].concat();
    assert_eq!(interrupt(&place, &arguments, 2), Some(130));
    let report = report(&place, "s");
    assert_eq!(report["complete"], false);
    assert!(!report["runs"].as_array().unwrap().is_empty());
    let parts = place
        .list("s")
        .into_iter()
        .filter(|name| name.ends_with(".part"));
    assert_eq!(parts.count(), 0);
}

/// Contrasts of 1 to 1e12 by one scheme on few points.
const CONTRAST: [&str; 14] = [
    "study",
    "contrast",
    "two-layer",
    "--set",
    "time.end=0.02",
    "--set",
    "output={times=[], plots=false}",
    "--set",
    "geometry.points=[20, 5]",
    "--schemes",
    "implicit",
    "--solvers",
    "faer-llt",
    "--quick",
];

/// Where flow alone is stable, on the coarsest cloud.
const STABILITY: [&str; 8] = [
    "study",
    "stability",
    "two-layer",
    "--schemes",
    "explicit,implicit",
    "--solvers",
    "faer-llt",
    "--quick",
];

/// Whether a page shows pictures and loads nothing: neither from the network nor from files.
#[track_caller]
fn assert_self_contained(place: &Place) {
    let page = String::from_utf8(place.read("s/report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("</html>"));
    // Scripts stand in the page; that they fetch nothing is told by tests in a browser.
    assert!(!page.contains("<script "), "a script from elsewhere");
    let parts = page
        .split("<script>")
        .map(|part| part.rsplit("</script>").next().unwrap_or(""));
    let page: String = parts.collect();
    for tag in ["<link", "<iframe", "<object", "@import", "url("] {
        assert!(!page.contains(tag), "{tag}");
    }
    for attribute in ["src=\"", "href=\""] {
        let targets = page.split(attribute).skip(1);
        for target in targets {
            let own = target.starts_with("data:") || target.starts_with('#');
            assert!(own, "{attribute}{}", &target[..target.len().min(40)]);
        }
    }
}

/// Does the study to its end, interrupts it halfway elsewhere and goes on: nothing runs twice.
#[cfg(unix)]
#[track_caller]
fn assert_goes_on(arguments: &[&str], variants: usize) -> Value {
    let place = Place::new();
    let arguments = [arguments, &["--out", "s"]].concat();
    let code = interrupt(&place, &arguments, 2);
    let before = log(&place);
    assert_eq!(code, Some(130), "{before:?}");
    assert!((2..variants).contains(&before.len()), "{}", before.len());
    assert_eq!(report(&place, "s")["complete"], false);
    place.succeed(&arguments);
    let after = log(&place);
    assert_eq!(after.len(), variants);
    assert_eq!(after[..before.len()], before, "kept to the last digit");
    assert_self_contained(&place);
    let report = report(&place, "s");
    assert_eq!(report["complete"], true);
    assert_eq!(report["runs"].as_array().unwrap().len(), variants);
    place.succeed(&arguments);
    assert_eq!(log(&place), after, "all there already");
    report
}

#[cfg(unix)]
#[test]
fn a_study_of_contrast_goes_on_and_shows_that_implicit_costs_stay() {
    // Three operators, transient and steady at five contrasts, steady at four more below 1.
    let report = assert_goes_on(&CONTRAST, 42);
    for run in report["runs"].as_array().unwrap() {
        assert_eq!(run["status"], "done", "{run}");
        let error = run["errors"]["pressure"].as_f64().unwrap();
        let bar = match run["operator"].as_str() {
            Some("path") => 0.01,
            Some("bond") => 0.05,
            _ => 0.5,
        };
        assert!(error < bar, "{run}");
    }
}

#[cfg(unix)]
#[test]
fn a_study_of_stability_goes_on_and_finds_the_explicit_limit() {
    // Explicit, backward Euler and TR-BDF2, three contrasts, five steps.
    let report = assert_goes_on(&STABILITY, 45);
    let borders = report["findings"]["borders"].as_array().unwrap();
    assert_eq!(borders.len(), 9);
    for border in borders {
        let border_of = |key: &str| &border["border"][key];
        let always = border_of("unstable").is_null();
        assert_eq!(always, border["method"] != "explicit", "{border}");
        assert_eq!(border_of("found").is_null(), always, "{border}");
        match border_of("cells_apart").as_f64() {
            Some(apart) => assert!(apart <= 1.0 && !always, "{border}"),
            None => assert!(
                always,
                "theory has no border there and none was found: {border}"
            ),
        }
    }
}

/// The split whose strain lags, once a step: with a strength above 1 its small steps diverge and its
/// large ones do not. Theory's border and the one found are at most a cell apart, and beyond it the
/// pressure swings before it comes to rest.
#[test]
fn the_lagged_split_holds_from_the_step_that_theory_names() {
    let place = Place::new();
    place.succeed(&[
        "study",
        "stability",
        "terzaghi",
        "--set",
        "geometry.size=[\"7.5 m\", \"1 m\"]",
        "--set",
        "output.probes={}",
        "--set",
        "output.profiles={}",
        "--points",
        "15",
        "--schemes",
        "semi-implicit,monolithic",
        "--quick",
        "--budget",
        "5min",
        "--out",
        "s",
    ]);
    let report = report(&place, "s");
    let borders = report["findings"]["borders"].as_array().unwrap();
    assert_eq!(borders.len(), 6);
    let lagged = |entry: &&Value| entry["method"] != "monolithic";
    for border in borders.iter().filter(lagged) {
        let border = &border["border"];
        let strength = border["strength"].as_f64().unwrap();
        let apart = border["cells_apart"].as_f64();
        assert_eq!(apart.is_some(), strength > 1.0, "{border}");
        assert!(apart.unwrap_or(0.0) <= 1.0, "{border}");
        assert!(border["stable"].is_array(), "{border}");
        assert_eq!(border["unstable"].is_array(), strength > 1.0, "{border}");
        assert_eq!(border["theory"][0].as_f64().unwrap() > 0.0, strength > 1.0);
    }
    let classes = report["findings"]["classes"].as_array().unwrap();
    let (lagged, monolithic): (Vec<&Value>, Vec<&Value>) = classes.iter().partition(lagged);
    assert!(lagged.iter().any(|entry| entry["class"] == "oscillating"));
    assert!(
        monolithic
            .iter()
            .all(|entry| entry["class"] == "converged" || entry["class"] == "inaccurate")
    );
}

/// Longer than no run, so that none ends.
const NO_TIME: [&str; 2] = ["--limit", "0.001s"];

#[test]
fn a_study_without_time_says_what_is_missing_and_claims_nothing() {
    for (kind, case) in [
        ("cost", "terzaghi"),
        ("contrast", "two-layer"),
        ("stability", "terzaghi"),
        ("convergence", "terzaghi"),
    ] {
        let place = Place::new();
        let own = [
            "study", kind, case, "--quick", "--budget", "20s", "--out", "a b",
        ];
        let text = place.succeed(&[&own[..], &NO_TIME].concat());
        assert!(text.contains("0 of ") && !text.contains("NaN"), "{text}");
        let longer = format!("`perifrac study {kind} {case} --quick --out 'a b'`");
        assert!(text.contains(&longer), "{text}");
        let page = String::from_utf8(place.read("a b/report.html")).unwrap();
        let command = format!(
            "<code>perifrac study {kind} {case} --quick --budget 20s --out 'a b' --limit 0.001s</code>"
        );
        assert!(page.contains(&command), "{page}");
        for words in [
            "NaN",
            "<svg",
            "is of order",
            "found at",
            " wins ",
            "at every step run",
        ] {
            assert!(!page.contains(words), "{kind}: {words}");
        }
        let report = report(&place, "a b");
        assert_eq!(report["coverage"]["outcomes"]["done"], 0);
        let planned = report["coverage"]["planned"].as_u64().unwrap();
        assert_eq!(report["runs"].as_array().unwrap().len() as u64, planned);
    }
}

/// The command that a page names gives the runs that it lacks.
#[test]
fn a_study_that_lacked_time_goes_on_with_the_command_it_names() {
    let place = Place::new();
    let short = [&SMALL[..], &["--out", "s"], &NO_TIME].concat();
    let text = place.succeed(&short);
    let command = text.split('`').nth(1).unwrap().replace('\'', "");
    let bare = [&SMALL[..], &["--out", "s"]].concat();
    assert_eq!(command, format!("perifrac {}", bare.join(" ")));
    let text = place.succeed(&bare);
    assert!(text.contains("8 of 8 runs done\n"), "{text}");
    let text = place.succeed(&short);
    assert!(
        text.contains("8 of 8 runs done\n"),
        "what is done stays done: {text}"
    );
}

/// The same version may be another program; its rows are those of another study.
#[cfg(unix)]
#[test]
fn another_build_of_the_program_runs_everything_again() {
    use std::io::Write;
    use std::process::Command;

    let place = Place::new();
    let program = place.path("perifrac");
    fs::copy(env!("CARGO_BIN_EXE_perifrac"), &program).unwrap();
    let study = || {
        let mut command = Command::new(&program);
        command.args(SMALL).args(["--out", "s"]);
        assert!(
            command
                .current_dir(place.path(""))
                .output()
                .unwrap()
                .status
                .success()
        );
        log(&place).len()
    };
    assert_eq!((study(), study()), (8, 8));
    // What stands behind the end of a program is not executed, but is part of the file.
    let mut file = fs::OpenOptions::new().append(true).open(&program).unwrap();
    file.write_all(b"rebuilt").unwrap();
    drop(file);
    assert_eq!((study(), study()), (16, 16));
}

#[test]
fn a_case_that_does_not_suit_is_refused_with_a_remedy() {
    let place = Place::new();
    for (arguments, remedy) in [
        (&["study", "contrast", "terzaghi"][..], "two-layer"),
        (&["study", "cost", "notched-tension"], "[flow]"),
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
