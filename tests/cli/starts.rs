//! Scenes that start from the state of another run, and scenes in stages, whose stages do.

use crate::support::{BASE, Place, changed, wait_for};

/// The base scene, from the state that `from` names.
fn started(from: &str, changes: &[(&str, &str)]) -> String {
    format!("{}[start]\nfrom = \"{from}\"\n", changed(changes))
}

/// What check, plan and run say of `scene.toml`, which all of them refuse at the line of `from`.
fn refused(place: &Place, scene: &str) -> String {
    place.write("scene.toml", scene);
    let line = scene.lines().position(|line| line.starts_with("from"));
    let at = format!("scene.toml:{}:", line.unwrap() + 1);
    let told = [
        &["check", "scene.toml"][..],
        &["plan", "scene.toml"],
        &["run", "scene.toml", "--quiet", "--out", "out"],
    ]
    .map(|call| {
        let outcome = place.run(call);
        assert_eq!(outcome.code, Some(3), "{call:?}: {outcome:?}");
        assert!(outcome.stderr.contains(&at), "{call:?}: {}", outcome.stderr);
        outcome.stderr
    });
    assert!(told.iter().all(|text| *text == told[0]), "{told:?}");
    told[0].clone()
}

#[test]
fn check_and_plan_refuse_a_start_where_the_run_does_and_in_its_words() {
    let place = Place::with_scene(&[]);
    place.succeed(&["run", "scene.toml", "--quiet", "--out", "first"]);
    place.write("empty/note.txt", "");
    place.write("damaged/checkpoint-0000000001.pfc", "no checkpoint");
    for (from, changes, expected) in [
        ("nowhere", &[][..], "nowhere"),
        ("empty", &[], "empty has no checkpoint"),
        ("damaged", &[], "is no whole checkpoint"),
        (
            "first",
            &[("points = [8, 8]", "points = [9, 9]")],
            "it has 64 points, and now there are 81",
        ),
        (
            "first",
            &[("size = [1, 1]", "size = [1, 2]")],
            "its points lie elsewhere",
        ),
    ] {
        let text = refused(&place, &started(from, changes));
        assert!(text.contains(expected), "{text}");
    }
    let kept = started("first", &[]) + "clock = \"keep\"\n";
    let text = refused(&place, &kept);
    assert!(text.contains("it ends at t = 1e2 s"), "{text}");
    place.write("scene.toml", started("first", &[]));
    for call in [&["check", "scene.toml"][..], &["plan", "scene.toml"]] {
        place.succeed(call);
    }
}

/// A scene that is too large to be built for a check: what the checkpoint says of itself is compared.
#[test]
fn a_start_is_looked_at_in_scenes_that_are_judged_by_estimates() {
    let large = ("points = [8, 8]", "points = [900, 900]");
    let place = Place::with_scene(&[]);
    place.succeed(&["run", "scene.toml", "--quiet", "--out", "first"]);
    for (from, more, expected) in [
        ("nowhere", "", "nowhere"),
        ("first", "clock = \"keep\"\n", "it ends at t = 1e2 s"),
    ] {
        place.write("scene.toml", started(from, &[large]) + more);
        let outcome = place.run(&["check", "scene.toml"]);
        assert_eq!(outcome.code, Some(3), "{outcome:?}");
        assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
    }
}

const STAGES: &str = r#"
[[stages]]
name = "long"
[stages.scheme]
name = "explicit"
[stages.time]
end = "4e4 s"

[[stages]]
name = "short"
[stages.time]
end = "4.1e4 s"
"#;

/// Only the first stage names a state that must be there.
#[test]
fn stages_are_checked_without_the_states_that_they_will_start_from() {
    let place = Place::new();
    place.write("scene.toml", format!("{BASE}{STAGES}"));
    let text = place.succeed(&["check", "scene.toml"]);
    assert_eq!(text.matches("no faults found").count(), 2, "{text}");
    place.write("scene.toml", format!("{}{STAGES}", started("nowhere", &[])));
    let outcome = place.run(&["check", "scene.toml"]);
    assert_eq!(outcome.code, Some(3), "{outcome:?}");
    assert!(outcome.stderr.contains("nowhere"), "{}", outcome.stderr);
}

/// By the way that its message names, a stage that was stopped goes on, and so do those after it.
#[cfg(unix)]
#[test]
fn what_stops_in_a_stage_goes_on_with_all_of_them() {
    use std::process::{Command, Stdio};
    let place = Place::new();
    place.write("scene.toml", format!("{BASE}{STAGES}"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    command.args(["run", "scene.toml", "--out", "all", "--threads", "1"]);
    command.args(["--set", "time.max_steps=1000000000"]);
    command.current_dir(place.path(""));
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    wait_for("the first stage", || {
        place.path("all/01-long/history.csv").is_file()
    });
    let signal = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signal.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("go on with `perifrac resume all`"), "{told}");
    assert!(!place.path("all/02-short").exists());
    let from = [
        "resume",
        "all",
        "--from",
        "all/01-long/checkpoint-0000000001.pfc",
    ];
    let outcome = place.run(&from);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    place.succeed(&["resume", "all", "--quiet"]);
    for done in ["01-long", "02-short"] {
        assert!(place.path(&format!("all/{done}/summary.json")).is_file());
    }
    assert!(place.path("all/summary.json").is_file());
}
