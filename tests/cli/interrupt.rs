//! A long run that the user stops keeps what it has written.

#![cfg(unix)]

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::support::{Place, wait_for};

/// A running program that does not outlive a failed test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    fn signal(&self, name: &str) {
        let id = self.0.id().to_string();
        let status = Command::new("kill").args([name, &id]).status();
        assert!(status.unwrap().success());
    }

    fn ended(&mut self) -> bool {
        self.0.try_wait().unwrap().is_some()
    }
}

/// Millions of explicit steps: far longer than any test waits.
const LONG: [&str; 11] = [
    "scene.toml",
    "--scheme",
    "explicit",
    "--set",
    "time.end=1e8",
    "--set",
    "time.max_steps=1000000000",
    "--set",
    "output.every=1e4",
    "--threads",
    "1",
];

/// Starts a run into `out`.
fn start(place: &Place, arguments: &[&str]) -> Running {
    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    command.args(["run", "--out", "out"]).args(arguments);
    command
        .current_dir(place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    Running(command.spawn().unwrap())
}

fn text(place: &Place, name: &str) -> String {
    String::from_utf8(place.read(name)).unwrap()
}

/// What a run printed that a signal ended.
fn told(run: &mut Running, code: i32) -> String {
    wait_for("the end", || run.ended());
    assert_eq!(run.0.wait().unwrap().code(), Some(code));
    let [mut stdout, mut stderr] = [String::new(), String::new()];
    let (mut out, mut err) = (run.0.stdout.take().unwrap(), run.0.stderr.take().unwrap());
    out.read_to_string(&mut stdout).unwrap();
    err.read_to_string(&mut stderr).unwrap();
    assert_eq!(stdout, "");
    stderr
}

fn stopped_by(signal: &str, code: i32) -> (Place, String) {
    let place = Place::with_scene(&[]);
    let mut run = start(&place, &LONG);
    wait_for("a second output", || {
        place.path("out/fields-0001.vtu").exists()
    });
    run.signal(signal);
    let stderr = told(&mut run, code);
    (place, stderr)
}

#[test]
fn an_interrupted_run_leaves_complete_files() {
    let (place, stderr) = stopped_by("-INT", 130);
    let time = stderr.strip_prefix("error: interrupted at t = ");
    let time = time.and_then(|rest| {
        let end = " s; what was written is complete; go on with `perifrac resume out`\n";
        rest.strip_suffix(end)
    });
    let time: f64 = time.unwrap_or_else(|| panic!("{stderr}")).parse().unwrap();
    let history = text(&place, "out/history.csv");
    assert!(history.ends_with('\n'));
    let columns = |line: &str| line.split(',').count();
    let header = columns(history.lines().next().unwrap());
    assert!(history.lines().count() > 1 && history.lines().all(|line| columns(line) == header));
    let pvd = text(&place, "out/fields.pvd");
    let collection = roxmltree::Document::parse(&pvd).unwrap();
    let sets: Vec<_> = collection
        .descendants()
        .filter(|n| n.has_tag_name("DataSet"))
        .collect();
    let last: f64 = sets
        .last()
        .unwrap()
        .attribute("timestep")
        .unwrap()
        .parse()
        .unwrap();
    assert!(
        (last / time - 1.0).abs() < 1e-5,
        "the last state is at {last} s, not {time} s"
    );
    let named: Vec<&str> = sets
        .iter()
        .filter_map(|set| set.attribute("file"))
        .collect();
    let files = place.list("out");
    let written: Vec<&String> = files.iter().filter(|name| name.ends_with(".vtu")).collect();
    assert_eq!(named, written);
    for name in named {
        assert!(
            roxmltree::Document::parse(&text(&place, &format!("out/{name}"))).is_ok(),
            "{name}"
        );
    }
    let known = |name: &String| name.ends_with(".vtu") || name.ends_with(".pvd");
    let others: Vec<&String> = files.iter().filter(|name| !known(name)).collect();
    assert_eq!(others, ["history.csv", "resolved.toml"]);
}

#[test]
fn a_run_that_is_asked_to_end_stops_in_the_same_way() {
    for (signal, code) in [("-TERM", 143), ("-HUP", 129)] {
        let (_, stderr) = stopped_by(signal, code);
        assert!(stderr.starts_with("error: interrupted at t = "), "{stderr}");
    }
}

/// As under `nohup`.
#[test]
fn a_hangup_that_is_to_be_ignored_is() {
    let place = Place::with_scene(&[]);
    let mut command = Command::new("sh");
    command.args([
        "-c",
        "trap '' HUP; exec \"$@\"",
        "sh",
        env!("CARGO_BIN_EXE_perifrac"),
    ]);
    command.args(["run", "--out", "out"]).args(LONG);
    command.current_dir(place.path(""));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut run = Running(command.spawn().unwrap());
    let outputs = || place.list("out").len();
    wait_for("an output", || place.path("out/fields-0001.vtu").exists());
    run.signal("-HUP");
    // One may be under way; a run that ends adds another.
    let before = outputs();
    wait_for("outputs after it", || outputs() > before + 3);
    assert!(!run.ended());
    run.signal("-INT");
    assert!(told(&mut run, 130).starts_with("error: interrupted at t = "));
}

/// Relaxation to nearly the last digit, again in every pass of the undrained start.
#[test]
fn a_step_is_left_in_the_middle() {
    let relaxation = [
        "terzaghi",
        "--scheme",
        "explicit",
        "--set",
        "scheme.solid=adr",
        "--set",
        "scheme.adr_tolerance=1e-12",
        "--set",
        "scheme.adr_iterations=1000000000",
    ];
    let place = Place::new();
    let mut run = start(&place, &relaxation);
    wait_for("the start", || place.path("out/resolved.toml").exists());
    // The model is there within a fraction of it.
    std::thread::sleep(Duration::from_secs(1));
    run.signal("-INT");
    let stderr = told(&mut run, 130);
    assert!(stderr.starts_with("error: interrupted at t = "), "{stderr}");
}

#[test]
fn what_cannot_be_left_is_ended_all_the_same() {
    let place = Place::with_scene(&[("points = [8, 8]", "points = [700, 700]")]);
    let mut run = start(&place, &["scene.toml", "--set", "time.mode=steady"]);
    wait_for("the start", || place.path("out/resolved.toml").exists());
    std::thread::sleep(Duration::from_millis(200));
    run.signal("-INT");
    let stderr = told(&mut run, 130);
    assert!(stderr.contains("what was written is complete"), "{stderr}");
    assert!(!place.path("out/summary.json").exists());
}

#[test]
fn a_folder_is_for_one_run_at_a_time_and_free_after_a_kill() {
    let place = Place::with_scene(&[]);
    let mut run = start(&place, &LONG);
    wait_for("an output", || place.path("out/fields-0001.vtu").exists());
    let second = place.run(&["run", "scene.toml", "--out", "out"]);
    let expected = format!(
        "error: out is in use: process {} is writing there; wait until it has ended, end it, or choose \
         another folder with --out\n",
        run.0.id()
    );
    assert_eq!((second.code, second.stderr), (Some(1), expected));
    run.0.kill().unwrap();
    run.0.wait().unwrap();
    assert!(place.path("out/.perifrac-lock").exists());
    place.succeed(&["run", "scene.toml", "--out", "out"]);
    let left = [
        "fields-0000.vtu",
        "fields-0001.vtu",
        "fields.pvd",
        "history.csv",
        "resolved.toml",
        "summary.json",
    ];
    assert_eq!(place.list("out"), left);
}

#[test]
fn a_second_interruption_does_not_wait_for_a_long_solve() {
    let place = Place::with_scene(&[("points = [8, 8]", "points = [500, 500]")]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
    command.args([
        "run",
        "scene.toml",
        "--out",
        "out",
        "--set",
        "time.mode=steady",
    ]);
    let mut run = Running(command.current_dir(place.path("")).spawn().unwrap());
    wait_for("the start", || place.path("out/resolved.toml").exists());
    for _ in 0..2 {
        std::thread::sleep(Duration::from_millis(200));
        run.signal("-INT");
    }
    wait_for("the end", || run.ended());
    assert_eq!(run.0.wait().unwrap().code(), Some(130));
    assert!(!place.path("out/summary.json").exists());
}
