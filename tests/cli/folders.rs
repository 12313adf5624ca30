//! Folders and devices that results cannot be written to; nothing of the user's is ever lost.

use std::fs::{self, File};
use std::process::{Command, Stdio};

use crate::support::{FAULT, Fault, Place, changed, check};

#[test]
fn folders_that_are_not_for_results() {
    check(&[
        Fault {
            name: "a folder with other things in it",
            files: &[("out/thesis.tex", b"years of work")],
            code: 1,
            stderr: r#"
error: out is not empty and holds no results of perifrac; choose another folder with --out, or empty it
"#,
            ..FAULT
        },
        Fault {
            name: "a file where the folder should be",
            files: &[("out", b"a file")],
            code: 1,
            stderr: r#"
error: out: the place for results is a file; it must be a folder; choose another one with --out
"#,
            ..FAULT
        },
        Fault {
            name: "a folder inside a file",
            files: &[("out", b"a file")],
            arguments: &["run", "scene.toml", "--out", "out/results"],
            code: 1,
            stderr: r#"
error: out: the place for results is a file; it must be a folder; choose another one with --out
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn a_refused_folder_is_left_as_it_was() {
    let place = Place::with_scene(&[]);
    place.write("out/history.csv", "my own table");
    let outcome = place.run(&["run", "scene.toml", "--out", "out"]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert_eq!(place.list("out"), ["history.csv"]);
    assert_eq!(place.read("out/history.csv"), b"my own table");
}

#[test]
fn other_files_in_a_folder_of_results_survive_the_next_run() {
    let place = Place::with_scene(&[]);
    place.succeed(&["run", "scene.toml", "--out", "out"]);
    place.write("out/notes.txt", "look at the left side");
    place.succeed(&["run", "scene.toml", "--out", "out"]);
    assert_eq!(place.read("out/notes.txt"), b"look at the left side");
}

/// Names like those of results, in a folder that two runs then use.
#[test]
fn files_of_the_user_survive_whatever_their_names() {
    let place = Place::with_scene(&[]);
    let run = ["run", "scene.toml", "--out", "out"];
    place.succeed(&run);
    let own = [
        ".perifrac-mine.part",
        "crack-main-annotated.csv",
        "damage.txt",
        "displacement-0000-cut.png",
        "fields-0000.vtu.bak",
        "fields-copy.vtu",
        "history-my-analysis.csv",
        "permeability-map.csv",
        "pressure-0000-cut.png",
        "profile-across-fit.csv",
        "summary.json.orig",
    ];
    for name in own {
        place.write(&format!("out/{name}"), name);
    }
    for _ in 0..2 {
        place.succeed(&run);
    }
    for name in own {
        assert_eq!(place.read(&format!("out/{name}")), name.as_bytes());
    }
}

#[test]
fn the_next_run_removes_all_that_the_last_one_wrote() {
    let place = Place::with_scene(&[("plots = false", "plots = true\ntimes = [\"50 s\"]")]);
    let run = ["run", "scene.toml", "--out", "out"];
    place.succeed(&run);
    place.succeed(&["report", "out"]);
    assert!(place.list("out").contains(&"report.html".to_owned()));
    let few = ["--set", "output={plots=false, vtu=false}"];
    place.succeed(&[&run[..], &few].concat());
    assert_eq!(
        place.list("out"),
        ["history.csv", "resolved.toml", "summary.json"]
    );
    let entries = fs::read_dir(place.path("out")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name());
    let checkpoints = names.filter(|name| name.to_string_lossy().ends_with(".pfc"));
    assert_eq!(checkpoints.count(), 1, "the one at the end");
}

#[test]
fn a_result_that_was_changed_since_is_kept_and_told() {
    let place = Place::with_scene(&[]);
    let run = ["run", "scene.toml", "--out", "out"];
    place.succeed(&run);
    let noted = [&place.read("out/history.csv")[..], b"# look here\n"].concat();
    place.write("out/history.csv", &noted);
    let outcome = place.run(&run);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let expected = "warning: a file that no run wrote, or that was changed since, stood where a result \
                    belongs; it is now out/history.csv.kept\n";
    assert_eq!(outcome.stderr, expected);
    assert_eq!(place.read("out/history.csv.kept"), noted);
    assert_ne!(place.read("out/history.csv"), noted);
}

#[test]
fn variants_of_a_case_have_folders_of_their_own() {
    let place = Place::with_scene(&[("plots = false", "vtu = false\nplots = false")]);
    let fine = "geometry.points=[9, 9]";
    for own in [
        &[][..],
        &["--scheme", "explicit"],
        &["--set", fine],
        &[
            "--set",
            "time.end=50 s",
            "--solver",
            "faer-cg:preconditioner=jacobi",
        ],
    ] {
        place.succeed(&[&["run", "scene.toml"], own].concat());
        place.succeed(&[&["run", "scene.toml"], own].concat());
    }
    let case = place.path("").canonicalize().unwrap();
    let case = case.file_name().unwrap().to_str().unwrap();
    let mut expected = [
        case.to_owned(),
        format!("{case}+explicit"),
        format!("{case}+geometry.points=9,9"),
        format!("{case}+faer-cg-preconditioner=jacobi+time.end=50s"),
    ];
    expected.sort();
    assert_eq!(place.list("out"), expected);
}

/// `smoke.toml` of two cases.
#[test]
fn variants_in_files_have_the_name_of_their_case_in_front() {
    let place = Place::new();
    for case in ["clay", "sand"] {
        place.write(&format!("{case}/scene.toml"), changed(&[]));
        let smoke = "base = \"scene.toml\"\n[output]\nplots = false\nvtu = false\n";
        place.write(&format!("{case}/smoke.toml"), smoke);
        place.succeed(&["run", &format!("{case}/smoke.toml")]);
    }
    assert_eq!(place.list("out"), ["clay-smoke", "sand-smoke"]);
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_is_named() {
    use std::fs::{Permissions, create_dir, set_permissions};
    use std::os::unix::fs::PermissionsExt;
    let place = Place::with_scene(&[]);
    create_dir(place.path("closed")).unwrap();
    set_permissions(place.path("closed"), Permissions::from_mode(0o555)).unwrap();
    if File::create(place.path("closed/probe")).is_ok() {
        return; // The superuser may write anywhere.
    }
    let outcome = place.run(&["run", "scene.toml", "--out", "closed/out"]);
    let expected = "error: closed/out: the directory or file is not writable; change its \
                    permissions or choose another output directory\n";
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(1), expected));
}

/// A file system of a few pages, gone again when the test ends.
#[cfg(target_os = "linux")]
struct SmallDisk(std::path::PathBuf);

#[cfg(target_os = "linux")]
impl SmallDisk {
    /// Nothing where mounting is not allowed.
    fn mount(folder: std::path::PathBuf, size: &str) -> Option<Self> {
        std::fs::create_dir(&folder).unwrap();
        let options = format!("size={size}");
        let mut mount = Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", &options, "tmpfs"])
            .arg(&folder);
        let done = mount
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success());
        done.then_some(SmallDisk(folder))
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_leaves_no_broken_file() {
    let often = ("plots = false", "plots = false\nevery = \"1 s\"");
    let place = Place::with_scene(&[("points = [8, 8]", "points = [20, 20]"), often]);
    let Some(_disk) = SmallDisk::mount(place.path("disk"), "256k") else {
        return;
    };
    let outcome = place.run(&["run", "scene.toml", "--out", "disk/out"]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stderr.starts_with("error: disk/out/"),
        "{}",
        outcome.stderr
    );
    let remedy = "no space left on the device; free some space or choose another output directory";
    assert!(
        outcome.stderr.trim_end().ends_with(remedy),
        "{}",
        outcome.stderr
    );
    let mut names = place.list("disk/out");
    names.retain(|name| name.ends_with(".vtu"));
    assert!(!names.is_empty());
    for name in names {
        let text = String::from_utf8(place.read(&format!("disk/out/{name}"))).unwrap();
        assert!(
            roxmltree::Document::parse(&text).is_ok(),
            "{name} is not complete"
        );
    }
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_are_a_failure() {
    let place = Place::with_scene(&[]);
    for arguments in [
        &["schema"][..],
        &["completions", "bash"],
        &["run", "scene.toml", "--json"],
    ] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
        command
            .args(arguments)
            .current_dir(place.path(""))
            .stdout(full);
        let output = command.output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        let expected = "error: standard output: no space left on the device; free some space or \
                        choose another output directory\n";
        assert_eq!(
            (output.status.code(), stderr.as_str()),
            (Some(1), expected),
            "{arguments:?}"
        );
    }
}

#[test]
fn a_reader_that_went_away_is_no_failure() {
    let place = Place::with_scene(&[]);
    for arguments in [
        &["schema"][..],
        &["completions", "bash"],
        &["cases"],
        &["solvers"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
        command
            .args(arguments)
            .current_dir(place.path(""))
            .stdout(writer);
        let output = command.output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(
            (output.status.code(), stderr.as_str()),
            (Some(0), ""),
            "{arguments:?}"
        );
    }
}

#[test]
fn warnings_that_nobody_reads_do_not_stop_a_run() {
    let gravity = "[gravity]\nacceleration = [0, -9.81]\n[time]";
    let place = Place::with_scene(&[("[time]", gravity)]);
    for verb in ["run", "check"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
        command
            .args([verb, "scene.toml"])
            .current_dir(place.path(""))
            .stderr(writer);
        assert_eq!(command.output().unwrap().status.code(), Some(0), "{verb}");
    }
}
