//! Sound scenes: what a run prints and writes, and what `plan` and `check` say.

use std::path::Path;

use serde_json::Value;

use crate::support::{Outcome, Place};

const LINES: &str = "plots = true\ntimes = [\"50 s\"]\n\
                     probes.middle = { at = [0.5, 0.5] }\n\
                     profiles.across = { from = [0, 0.5], to = [1, 0.5] }";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn a_run_writes_these_files_and_no_others() {
    let place = Place::with_scene(&[("plots = false", LINES)]);
    place.succeed(&["run", "scene.toml", "--out", "out"]);
    let expected = [
        "fields-0000.vtu",
        "fields-0001.vtu",
        "fields-0002.vtu",
        "fields.pvd",
        "history-pressure.svg",
        "history-step.svg",
        "history.csv",
        "pressure-0000.png",
        "pressure-0001.png",
        "pressure-0002.png",
        "profile-across.csv",
        "profile-across.svg",
        "resolved.toml",
        "setup.png",
        "summary.json",
    ];
    assert_eq!(place.list("out"), expected);
    assert_eq!(place.list(""), ["out", "scene.toml"]);
}

#[test]
fn a_run_writes_into_a_folder_named_after_the_scene() {
    let place = Place::with_scene(&[("plots = false", "vtu = false\nplots = false")]);
    place.write("sand/scene.toml", place.read("scene.toml"));
    place.write("clay.toml", place.read("scene.toml"));
    place.succeed(&["run", "sand/scene.toml"]);
    place.succeed(&["run", "clay.toml"]);
    assert_eq!(place.list("out"), ["clay", "sand"]);
    let without_fields = ["history.csv", "resolved.toml", "summary.json"];
    assert_eq!(place.list("out/clay"), without_fields);
}

#[test]
fn the_json_of_a_run_has_the_promised_keys() {
    let place = Place::with_scene(&[]);
    place.write("base.toml", place.read("scene.toml"));
    let arguments = [
        "run",
        "base.toml",
        "--json",
        "--solver",
        "faer-llt",
        "--out",
        "out",
    ];
    let printed = json(&place.succeed(&arguments));
    let keys = [
        "case", "scheme", "solver", "points", "unknowns", "steps", "rejected", "wall_s", "t_end",
        "errors", "balance", "counters", "warnings",
    ];
    for key in keys {
        assert!(printed.get(key).is_some(), "{key} is not in {printed}");
    }
    assert_eq!(printed["case"], "base");
    assert_eq!(printed["points"], 64);
    assert_eq!(printed["t_end"], 100.0);
    assert!(
        printed["solver"].as_str().unwrap().contains("faer-llt"),
        "{printed}"
    );
    assert!(
        printed["balance"]["mass"].as_f64().unwrap().abs() < 1e-9,
        "{printed}"
    );
    assert_eq!(
        printed,
        json(&String::from_utf8(place.read("out/summary.json")).unwrap())
    );
}

#[test]
fn a_steady_flow_through_a_uniform_rock_is_darcys() {
    let place = Place::with_scene(&[("end = \"100 s\"", "mode = \"steady\"")]);
    let printed = json(&place.succeed(&["run", "scene.toml", "--json"]));
    let darcy = 9.869233e-16 / 1e-3 * 1e6;
    let right = printed["outflow"]["right"].as_f64().unwrap();
    assert!((right / darcy - 1.0).abs() < 1e-8, "{right} {darcy}");
    assert_eq!(printed["steps"], 0);
}

#[test]
fn a_reference_brings_errors() {
    let place = Place::new();
    let arguments = ["run", "two-layer", "--json", "--set", "output.plots=false"];
    let printed = json(&place.succeed(&arguments));
    for norm in ["l2", "max"] {
        let error = printed["errors"]["pressure"][norm].as_f64().unwrap();
        assert!(error > 0.0 && error < 0.05, "{norm} {error}");
    }
}

#[test]
fn a_quiet_run_prints_nothing_and_warns_of_nothing() {
    let gravity = "[gravity]\nacceleration = [0, -9.81]\n[time]";
    let place = Place::with_scene(&[("[time]", gravity)]);
    let Outcome {
        code,
        stdout,
        stderr,
    } = place.run(&["run", "scene.toml", "--quiet"]);
    assert_eq!((code, stdout.as_str(), stderr.as_str()), (Some(0), "", ""));
    let outcome = place.run(&["run", "scene.toml"]);
    assert_eq!(outcome.code, Some(0));
    assert!(
        outcome
            .stderr
            .starts_with("warning: the pressure on side left"),
        "{outcome:?}"
    );
    assert!(
        outcome.stdout.contains("64 points, implicit"),
        "{outcome:?}"
    );
    assert!(!outcome.stdout.contains("warning"), "{outcome:?}");
}

#[test]
fn flags_win_over_overrides_and_overrides_over_the_scene() {
    let place = Place::with_scene(&[("[time]", "[scheme]\nname = \"implicit\"\n[time]")]);
    let scheme = |arguments: &[&str]| {
        let whole = [&["run", "scene.toml", "--json"], arguments].concat();
        json(&place.succeed(&whole))["scheme"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    assert!(scheme(&[]).starts_with("implicit"));
    assert!(scheme(&["--set", "scheme.name=explicit"]).starts_with("explicit"));
    let both = ["--scheme", "implicit", "--set", "scheme.name=explicit"];
    assert!(scheme(&both).starts_with("implicit"));
}

#[test]
fn a_plan_is_told_without_running_and_writes_nothing() {
    let place = Place::with_scene(&[]);
    let plan = json(&place.succeed(&["plan", "scene.toml", "--json"]));
    assert_eq!(
        (&plan["points"], &plan["dimension"]),
        (&Value::from(64), &Value::from(2))
    );
    let text = place.succeed(&["plan", "scene.toml"]);
    for line in [
        "cloud",
        "materials",
        "effect",
        "operator",
        "scheme",
        "solver",
        "memory",
        "limit",
    ] {
        assert!(
            text.lines()
                .any(|found| found.trim_start().starts_with(line)),
            "{line}: {text}"
        );
    }
    assert_eq!(place.list(""), ["scene.toml"]);
}

#[test]
fn a_sound_scene_has_no_faults() {
    let place = Place::with_scene(&[]);
    place.write("base.toml", place.read("scene.toml"));
    assert_eq!(
        place.succeed(&["check", "base.toml"]),
        "base: no faults found (64 points)\n"
    );
    assert_eq!(place.list(""), ["base.toml", "scene.toml"]);
}

#[test]
fn rate_and_bottom_hole_pressure_of_a_well_are_columns_of_the_history() {
    let place = Place::new();
    let set = "geometry.points=[20, 20]";
    place.succeed(&["run", "well-test/limited", "--set", set, "--out", "out"]);
    let text = String::from_utf8(place.read("out/history.csv")).unwrap();
    let heading: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let column = |name: &str| heading.iter().position(|own| *own == name).unwrap();
    let columns = ["well_rate_well_m3_per_s", "well_pressure_well_Pa", "time_s"].map(column);
    let rows = text.lines().skip(1).map(|line| {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        columns.map(|k| values[k])
    });
    let rows: Vec<[f64; 3]> = rows.collect();
    let asked = -100.0 / 86_400.0;
    assert!((rows[0][0] / asked - 1.0).abs() < 1e-12);
    assert!(
        rows.iter()
            .all(|[rate, bottom, _]| *rate >= asked * (1.0 + 1e-12) && *bottom >= 17.8e6 - 1.0)
    );
    let held = rows.iter().filter(|[_, bottom, _]| *bottom <= 17.8e6);
    assert!(held.clone().count() > 5);
    assert!(
        held.clone()
            .all(|[rate, ..]| *rate > asked && *rate < 0.9 * asked)
    );
    assert!(rows.last().unwrap()[0].abs() <= 0.0);
}

#[test]
fn a_scene_without_a_title_is_called_like_its_case() {
    let place = Place::with_scene(&[("title = \"Base\"\n", "")]);
    place.write("clay.toml", place.read("scene.toml"));
    let plan = place.succeed(&["plan", "clay.toml"]);
    assert_eq!(plan.lines().next(), Some("clay"), "{plan}");
    place.succeed(&["run", "clay.toml", "--out", "first"]);
    // The text of the run tells the title, whatever its file is called.
    let again = place.succeed(&["plan", "first/resolved.toml"]);
    assert_eq!(again.lines().next(), Some("resolved: clay"), "{again}");
    place.succeed(&["run", "first/resolved.toml", "--out", "second"]);
    assert_eq!(
        place.read("first/resolved.toml"),
        place.read("second/resolved.toml")
    );
}

#[test]
fn a_run_ends_where_it_is_told_to_and_later_outputs_are_left_out() {
    let times = "plots = false\ntimes = [\"80 s\", \"20 s\", \"50 s\"]";
    let place = Place::with_scene(&[("plots = false", times)]);
    // The flag is the last word, whatever else sets the end.
    let arguments = [
        "run",
        "scene.toml",
        "--end",
        "0.5 min",
        "--set",
        "time.end=90",
        "--json",
        "--out",
        "out",
    ];
    let printed = json(&place.succeed(&arguments));
    assert_eq!(printed["t_end"], 30.0);
    let told = printed["warnings"].as_array().unwrap();
    let late =
        "2 of output.times, from 50 s on, lie after the end of the run, 30 s, and are left out";
    assert!(told.iter().any(|warning| warning == late), "{told:?}");
    let fields = place
        .list("out")
        .into_iter()
        .filter(|name| name.ends_with(".vtu"));
    let expected = ["fields-0000.vtu", "fields-0001.vtu", "fields-0002.vtu"];
    assert_eq!(fields.collect::<Vec<_>>(), expected);
    assert!(
        String::from_utf8(place.read("out/resolved.toml"))
            .unwrap()
            .contains("end = \"0.5 min\"")
    );
}

/// A plate on points of a file that lies beside the scene.
#[test]
fn what_a_run_was_runs_again_from_its_own_folder() {
    let place = Place::new();
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/book/scenes");
    for name in ["own-points.toml", "points.csv"] {
        place.write(name, std::fs::read(book.join(name)).unwrap());
    }
    let quiet = ["--set", "output.plots=false"];
    place.succeed(&[&["run", "own-points.toml", "--out", "first"], &quiet[..]].concat());
    let mut again = place.program(&["run", "resolved.toml", "--out", "../second"]);
    let ended = again.current_dir(place.path("first")).output().unwrap();
    assert!(ended.status.success(), "{ended:?}");
    for file in ["resolved.toml", "history.csv"] {
        let [first, second] = ["first", "second"].map(|run| place.read(&format!("{run}/{file}")));
        assert_eq!(first, second, "{file}");
    }
}
