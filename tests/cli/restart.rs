//! Runs that are killed, ended by a queue, or given files that are not theirs.

#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::Place;

/// Scenes that take about a second, one of every kind of scheme.
const SCENES: [&[&str]; 5] = [
    &["terzaghi", "--set", "geometry.spacing=0.25"],
    &[
        "terzaghi",
        "--set",
        "geometry.spacing=0.5",
        "--scheme",
        "staggered",
        "--solver",
        "faer-cg:preconditioner=amg",
    ],
    &["five-spot", "--set", "geometry.points=[30, 30]"],
    &["notched-tension/smoke"],
    &["pressurised-notch/smoke"],
];

/// Kills of all scenes together; all of them with `PERIFRAC_KILLS=100`.
fn kills() -> usize {
    let wanted = std::env::var("PERIFRAC_KILLS").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(10)
}

fn program(place: &Place, arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    command
        .args(arguments)
        .args(["--quiet", "--checkpoint-every", "20ms"])
        .current_dir(place.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command.spawn().unwrap()
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill")
        .args([name, &child.id().to_string()])
        .stderr(Stdio::null())
        .status();
    // It may have ended by itself.
    let _ = status.unwrap();
}

/// Names and bytes of all results.
fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all: Vec<(String, Vec<u8>)> = entries
        .filter_map(|entry| {
            let path = entry.unwrap().path();
            let ending = path.extension()?.to_str()?.to_owned();
            let name = path.file_name()?.to_string_lossy().into_owned();
            let kept = ["csv", "vtu", "vtp", "pvd", "svg", "png"].contains(&&*ending);
            kept.then(|| (name, std::fs::read(&path).unwrap()))
        })
        .collect();
    all.sort();
    all
}

fn assert_same(place: &Place, what: &[&str]) {
    let (whole, killed) = (
        results(&place.path("whole")),
        results(&place.path("killed")),
    );
    let names = |all: &[(String, Vec<u8>)]| -> Vec<String> {
        all.iter().map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(names(&whole), names(&killed), "{what:?}");
    for ((name, one), (_, other)) in whole.iter().zip(&killed) {
        assert!(one == other, "{what:?}: {name} differs");
    }
    assert!(place.path("killed/summary.json").is_file());
}

/// A number between 0 and 1 from a small generator, so that a failure can be repeated.
fn next(seed: &mut u64) -> f64 {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

#[test]
fn killed_at_random_moments_a_run_ends_with_the_same_bits() {
    let mut seed = 0x9e37_79b9_7f4a_7c15;
    let each = kills().div_ceil(SCENES.len());
    for scene in SCENES {
        let place = Place::new();
        let begun = Instant::now();
        let run = |folder: &str| {
            let mut arguments = vec!["run"];
            arguments.extend(scene);
            arguments.extend(["--out", folder]);
            program(&place, &arguments)
        };
        assert!(run("whole").wait().unwrap().success(), "{scene:?}");
        let length = begun.elapsed().as_secs_f64();
        let has_begun = || {
            let folder = std::fs::read_dir(place.path("killed"));
            let names = folder
                .into_iter()
                .flatten()
                .flatten()
                .map(|e| e.file_name());
            names
                .into_iter()
                .any(|name| name.to_string_lossy().ends_with(".pfc"))
        };
        let start = || match has_begun() {
            true => program(&place, &["resume", "killed"]),
            false => run("killed"),
        };
        for _ in 0..each {
            let mut child = start();
            std::thread::sleep(Duration::from_secs_f64(length * 0.8 * next(&mut seed)));
            signal(&child, "-KILL");
            child.wait().unwrap();
        }
        assert!(start().wait().unwrap().success(), "{scene:?}");
        assert_same(&place, scene);
    }
}

/// A queue's notice: the checkpoint is there within five seconds, the code is 143, and the message says how to
/// go on.
#[test]
fn a_run_that_a_queue_ends_keeps_its_state_and_says_how_to_go_on() {
    let place = Place::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    let child = command
        .args([
            "run",
            "natural-fractures",
            "--out",
            "long",
            "--threads",
            "1",
        ])
        .current_dir(place.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !place.path("long/history.csv").is_file() {
        assert!(begun.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "-TERM");
    let told = Instant::now();
    let output = child.wait_with_output().unwrap();
    assert!(told.elapsed() < Duration::from_secs(5));
    assert_eq!(output.status.code(), Some(143));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("perifrac resume long"), "{text}");
}

/// A scene in stages that is killed within a stage goes on there, and ends with the same history.
#[test]
fn stages_go_on_where_they_were_killed() {
    let place = Place::new();
    let begun = Instant::now();
    let run = |folder: &str| {
        let smaller = ["--set", "geometry.spacing=4 cm"];
        let arguments = ["run", "staged-injection", "--out", folder];
        program(&place, &[&arguments[..], &smaller].concat())
    };
    assert!(run("whole").wait().unwrap().success());
    let length = begun.elapsed();
    let mut child = run("killed");
    std::thread::sleep(length.mul_f64(0.6));
    signal(&child, "-KILL");
    child.wait().unwrap();
    assert!(
        program(&place, &["resume", "killed"])
            .wait()
            .unwrap()
            .success()
    );
    assert_same(&place, &["staged-injection"]);
    for stage in ["01-load", "02-drain", "03-inject", "04-shut-in"] {
        let both = ["whole", "killed"].map(|run| results(&place.path(&format!("{run}/{stage}"))));
        assert!(both[0] == both[1], "{stage}");
    }
}

/// What `resume` is given that it cannot go on from.
#[test]
fn resume_refuses_what_is_no_run_that_was_stopped() {
    let place = Place::new();
    let told = |arguments: &[&str], code: i32| {
        let outcome = place.run(arguments);
        assert_eq!(outcome.code, Some(code), "{arguments:?}: {outcome:?}");
        outcome.stdout + &outcome.stderr
    };
    let text = told(&["resume", "nowhere"], 2);
    assert!(text.contains("nowhere has no checkpoint"), "{text}");
    let small = ["--set", "geometry.points=[12, 12]", "--quiet"];
    let run = [&["run", "five-spot", "--out", "done"][..], &small].concat();
    told(&run, 0);
    let text = told(&["resume", "done"], 0);
    assert!(text.contains("nothing left to do"), "{text}");
    // Another scene was put beside the checkpoint.
    std::fs::write(place.path("done/resolved.toml"), "title = \"other\"\n").unwrap();
    let text = told(&["resume", "done"], 1);
    assert!(text.contains("another scene"), "{text}");
    for wrong in ["5", "0 s", "5 m", "soon"] {
        let text = told(&["run", "five-spot", "--checkpoint-every", wrong], 2);
        assert!(text.contains("5min"), "{wrong}: {text}");
    }
}
