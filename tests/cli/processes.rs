//! Runs over several processes give what one process gives, and one that dies ends all.
//!
//! They need PETSc and mpirun; without them they pass without a check, unless PERIFRAC_REQUIRE_PETSC
//! is set.

#![cfg(unix)]

use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::support::{Place, wait_for};

/// Whether runs over several processes are possible here.
pub fn possible() -> bool {
    let place = Place::new();
    let petsc = place.succeed(&["solvers"]).contains("\nPETSc 3.");
    let mpirun = Command::new("mpirun").arg("--version").output().is_ok();
    let required = std::env::var_os("PERIFRAC_REQUIRE_PETSC").is_some();
    assert!(
        !required || (petsc && mpirun),
        "PETSc and mpirun are required here"
    );
    petsc && mpirun
}

/// The program started `count` times by mpirun, in the folder of `place`.
pub fn mpirun(place: &Place, count: usize, arguments: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .args(["--oversubscribe", "-n", &count.to_string()])
        .arg(env!("CARGO_BIN_EXE_perifrac"))
        .args(arguments)
        .args(["--threads", "1"])
        .current_dir(place.path(""));
    command
}

/// Runs `arguments` over `count` processes; 0 is a run without mpirun and PETSc. Gives the summary.
fn summary(place: &Place, count: usize, arguments: &[&str]) -> Value {
    let out = format!("out{count}");
    let mut all = vec!["run"];
    all.extend(arguments);
    all.extend(["--json", "--quiet", "--out", &out]);
    let text = match count {
        0 => place.succeed(&all),
        _ => {
            all.extend(["--solver", "petsc"]);
            let output = mpirun(place, count, &all).output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(
                output.status.success(),
                "{arguments:?} on {count}: {stderr}"
            );
            String::from_utf8(output.stdout).unwrap()
        }
    };
    assert_eq!(text.lines().count(), 1, "one process prints: {text}");
    serde_json::from_str(&text).unwrap()
}

/// Heading and numbers of each column of a table.
fn table(place: &Place, name: &str) -> Vec<(String, Vec<f64>)> {
    let text = String::from_utf8(place.read(name)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heading = lines.next().unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    let column = |k: usize| {
        rows.iter()
            .map(|row| row[k].parse().unwrap_or(f64::NAN))
            .collect()
    };
    let columns = heading.iter().enumerate();
    columns
        .map(|(k, name)| ((*name).to_owned(), column(k)))
        .collect()
}

/// Pressures, displacements and openings along a line agree to the tolerance of the solvers.
fn assert_same_table(place: &Place, count: usize, name: &str) {
    let one = table(place, &format!("out0/{name}"));
    let several = table(place, &format!("out{count}/{name}"));
    let mut compared = 0;
    for ((heading, one), (_, several)) in one.iter().zip(&several) {
        if !["pressure_Pa", "displacement_x_m", "opening_m"].contains(&heading.as_str()) {
            continue;
        }
        compared += one.len();
        assert_eq!(one.len(), several.len());
        let scale = one.iter().fold(0.0_f64, |m, value| m.max(value.abs()));
        for (one, several) in one.iter().zip(several) {
            let off = (one - several).abs() / scale;
            assert!(off < 1e-8, "{name}, {count} processes, {heading}: {off:e}");
        }
    }
    assert!(compared > 0, "{one:?}");
}

/// Points of all pieces of an output, which its index names.
/// Points that pieces own, and their cells.
fn in_pieces(place: &Place, index: &str) -> [usize; 2] {
    let text = String::from_utf8(place.read(index)).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let folder = index.split('/').next().unwrap();
    let pieces = document
        .descendants()
        .filter(|node| node.has_tag_name("Piece"));
    let counts = pieces.map(|piece| {
        let name = format!("{folder}/{}", piece.attribute("Source").unwrap());
        let ghosts = perifrac::plan::read_array(&place.path(&name), "vtkGhostType").unwrap();
        let own = ghosts.iter().filter(|ghost| **ghost < 0.5).count();
        [own, cells(place, &name)]
    });
    counts.fold([0, 0], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
}

/// Cells of a file.
fn cells(place: &Place, name: &str) -> usize {
    let text = String::from_utf8(place.read(name)).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let mut nodes = document.descendants();
    let piece = nodes.find(|node| node.has_tag_name("Piece")).unwrap();
    piece.attribute("NumberOfCells").unwrap().parse().unwrap()
}

fn assert_same_for_all_counts(arguments: &[&str], profile: &str) {
    if !possible() {
        return;
    }
    let place = Place::new();
    let one = summary(&place, 0, arguments);
    for count in 1..=4 {
        let several = summary(&place, count, arguments);
        for same in [
            "points", "unknowns", "bonds", "nonzeros", "steps", "rejected",
        ] {
            assert_eq!(one[same], several[same], "{same} on {count} processes");
        }
        assert_eq!(several["processes"], count);
        assert_same_table(&place, count, profile);
        if count > 1 {
            let [points, shared] = in_pieces(&place, &format!("out{count}/fields-0001.pvtu"));
            assert_eq!(points as u64, one["points"].as_u64().unwrap());
            assert_eq!(shared, cells(&place, "out0/fields-0001.vtu"));
            let collection = String::from_utf8(place.read(&format!("out{count}/fields.pvd")));
            assert!(collection.unwrap().contains("file=\"fields-0001.pvtu\""));
        }
    }
}

#[test]
fn flow_between_wells() {
    let coarse = ["five-spot", "--set", "geometry.points=[30, 30]"];
    let short = ["--set", "time.end=0.02", "--set", "output.times=[0.01]"];
    let all: Vec<&str> = coarse.iter().chain(&short).copied().collect();
    assert_same_for_all_counts(&all, "profile-diagonal.csv");
}

#[test]
fn a_crack_whose_faces_belong_to_several_processes() {
    let scene = ["sneddon", "--set", "geometry.spacing=0.025"];
    let step = ["--set", "time={end=1, step=1}"];
    let all: Vec<&str> = scene.iter().chain(&step).copied().collect();
    assert_same_for_all_counts(&all, "crack-main.csv");
}

#[test]
fn a_steady_state_between_wells_in_a_sealed_domain() {
    if !possible() {
        return;
    }
    let place = Place::new();
    let steady = [
        "five-spot",
        "--set",
        "geometry.points=[30, 30]",
        "--set",
        "time.mode=steady",
    ];
    summary(&place, 0, &steady);
    for count in [2, 3] {
        summary(&place, count, &steady);
        assert_same_table(&place, count, "profile-diagonal.csv");
    }
}

#[test]
fn consolidation_in_one_system() {
    let coarse = [
        "terzaghi",
        "--set",
        "geometry.spacing=0.25",
        "--set",
        "time.step=6",
    ];
    assert_same_for_all_counts(&coarse, "profile-axis.csv");
}

#[test]
fn consolidation_in_turn() {
    let coarse = [
        "terzaghi",
        "--set",
        "geometry.spacing=0.25",
        "--set",
        "time.step=6",
    ];
    let all: Vec<&str> = coarse
        .iter()
        .copied()
        .chain(["--scheme", "staggered"])
        .collect();
    assert_same_for_all_counts(&all, "profile-axis.csv");
}

#[test]
fn consolidation_of_a_graded_column_with_the_consistent_gradient() {
    let coarse = ["terzaghi-graded", "--set", "time.step=10"];
    assert_same_for_all_counts(&coarse, "profile-axis.csv");
}

#[test]
fn faults_are_told_once_with_their_exit_code() {
    if !possible() {
        return;
    }
    let place = Place::with_scene(&[("pressure = \"1 MPa\"", "pressure = \"1 m\"")]);
    let output = mpirun(&place, 3, &["run", "scene.toml"]).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert_eq!(stderr.matches("expected a pressure").count(), 1, "{stderr}");
    let place = Place::with_scene(&[]);
    let alone = ["run", "scene.toml", "--solver", "faer-llt"];
    let output = mpirun(&place, 2, &alone).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    assert_eq!(stderr.matches("choose `petsc`").count(), 1, "{stderr}");
    let output = mpirun(&place, 2, &["run", "scene.toml", "--scheme", "explicit"]).output();
    let stderr = String::from_utf8(output.unwrap().stderr).unwrap();
    assert!(stderr.contains("works in one process"), "{stderr}");
}

/// A running mpirun that does not outlive a failed test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The process of a rank among those that run in a folder.
fn process_of(rank: usize, folder: &str) -> Option<u32> {
    let own = format!("OMPI_COMM_WORLD_RANK={rank}");
    std::fs::read_dir("/proc")
        .ok()?
        .flatten()
        .find_map(|entry| {
            let path = entry.path();
            let here = std::fs::read_link(path.join("cwd")).ok()?;
            let environment = std::fs::read(path.join("environ")).ok()?;
            let mut words = environment.split(|byte| *byte == 0);
            let wanted = here.to_str()? == folder && words.any(|word| word == own.as_bytes());
            let name = std::fs::read_to_string(path.join("comm")).ok()?;
            (wanted && name.starts_with("perifrac"))
                .then(|| entry.file_name().to_str()?.parse().ok())?
        })
}

/// One of two processes is killed in the middle of a long run.
#[test]
fn a_process_that_dies_ends_the_run_and_leaves_whole_files() {
    if !possible() {
        return;
    }
    let place = Place::with_scene(&[]);
    let long = [
        "run",
        "scene.toml",
        "--out",
        "out",
        "--set",
        "time.end=1e6",
        "--set",
        "time.step=0.5",
        "--set",
        "time.max_steps=100000000",
        "--set",
        "output.every=100",
    ];
    let mut command = mpirun(&place, 2, &long);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut run = Running(child.unwrap());
    wait_for("a third output", || {
        place.path("out/fields-0002.pvtu").exists()
    });
    let folder = std::fs::canonicalize(place.path("")).unwrap();
    let victim = process_of(1, folder.to_str().unwrap()).expect("the second process runs");
    let killed = Command::new("kill")
        .args(["-9", &victim.to_string()])
        .status();
    assert!(killed.unwrap().success());
    wait_for("the end", || run.0.try_wait().unwrap().is_some());
    assert!(!run.0.wait().unwrap().success());
    let history = String::from_utf8(place.read("out/history.csv")).unwrap();
    let columns = history.lines().next().unwrap().split(',').count();
    assert!(history.ends_with('\n'));
    assert!(
        history
            .lines()
            .all(|line| line.split(',').count() == columns)
    );
    let collection = String::from_utf8(place.read("out/fields.pvd")).unwrap();
    let document = roxmltree::Document::parse(&collection).unwrap();
    let sets = document
        .descendants()
        .filter_map(|node| node.attribute("file"));
    let outputs: Vec<&str> = sets.collect();
    assert!(outputs.len() >= 2, "{collection}");
    for output in outputs {
        assert_eq!(in_pieces(&place, &format!("out/{output}")), [64, 49]);
    }
}

/// Two processes, one of which is killed, go on together to the bits that they would have had.
#[test]
fn two_processes_go_on_to_the_same_bits() {
    if !possible() {
        return;
    }
    let place = Place::new();
    let scene = [
        "terzaghi",
        "--set",
        "geometry.spacing=0.25",
        "--set",
        "time.step=0.02",
        "--set",
        "output.times=[2, 5, 10, 20, 40]",
        "--solver",
        "petsc",
        "--quiet",
        "--checkpoint-every",
        "50ms",
    ];
    let run = |folder: &'static str| [&["run"][..], &scene, &["--out", folder]].concat();
    assert!(mpirun(&place, 2, &run("whole")).status().unwrap().success());
    // PETSc itself does not always repeat its sums on a busy machine: one of four whole runs left the others by 1e-10
    // after 737 of 3,000 steps. What goes on wrongly goes wrong each time.
    let mut differs = None;
    for attempt in ["first", "second", "third"] {
        go_on_after_a_kill(&place, &run(attempt), attempt);
        differs = first_difference(&place, ["whole", attempt]);
        if differs.is_none() {
            break;
        }
    }
    assert_eq!(differs, None);
}

/// Kills one of two processes with a run into `folder` after its second output, and lets it go on to its end.
fn go_on_after_a_kill(place: &Place, run: &[&str], folder: &str) {
    let mut command = mpirun(place, 2, run);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut child = Running(child.unwrap());
    wait_for("a second output", || {
        place.path(&format!("{folder}/fields-0001.pvtu")).exists()
    });
    let all = std::fs::canonicalize(place.path("")).unwrap();
    if let Some(victim) = process_of(1, all.to_str().unwrap()) {
        let killed = Command::new("kill")
            .args(["-9", &victim.to_string()])
            .status();
        assert!(killed.unwrap().success());
    }
    wait_for("the end", || child.0.try_wait().unwrap().is_some());
    let alone = place.run(&["resume", folder]);
    assert!(alone.stderr.contains("2 processes wrote it"), "{alone:?}");
    let output = mpirun(place, 2, &["resume", folder, "--quiet"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
}

/// The first of the files of two runs that is not the same in both.
fn first_difference(place: &Place, folders: [&str; 2]) -> Option<String> {
    let results = |folder: &str| -> Vec<String> {
        let all = place.list(folder).into_iter();
        let kept = |name: &String| {
            ["csv", "vtu", "vtp", "pvtu", "pvd", "svg", "png", "kept"]
                .iter()
                .any(|ending| name.ends_with(ending))
        };
        all.filter(kept).collect()
    };
    assert_eq!(results(folders[0]), results(folders[1]));
    results(folders[0]).into_iter().find(|name| {
        let both = folders.map(|folder| place.read(&format!("{folder}/{name}")));
        both[0] != both[1]
    })
}
