//! A folder to work in, a small scene, and tables of faults.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use assert_cmd::Command;
use tempfile::TempDir;

/// A sound scene; each fault changes a line of it. It runs in a few milliseconds.
pub const BASE: &str = r#"title = "Base"
[geometry]
type = "lattice"
size = [1, 1]
points = [8, 8]
[fluid]
viscosity = "1 cP"
[materials.rock]
permeability = "1 mD"
storage = "1e-10 1/Pa"
[flow.boundary.left]
pressure = "1 MPa"
[flow.boundary.right]
pressure = "0 Pa"
[time]
end = "100 s"
[output]
plots = false
"#;

/// The base scene with some of its text replaced.
pub fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(BASE.to_owned(), |text, (old, new)| {
        assert_eq!(
            text.matches(old).count(),
            1,
            "`{old}` must stand in the scene once"
        );
        text.replace(old, new)
    })
}

/// What the program did.
#[derive(Debug)]
pub struct Outcome {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// An empty folder in which the program is run.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        Place {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    /// A folder that holds `scene.toml`, the base scene with some of its text replaced.
    pub fn with_scene(changes: &[(&str, &str)]) -> Self {
        let place = Self::new();
        place.write("scene.toml", changed(changes));
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names of what a folder holds, sorted.
    pub fn list(&self, folder: &str) -> Vec<String> {
        list(&self.path(folder))
    }

    /// The program, to be run in this folder; nothing of the caller's terminal shows through.
    pub fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_perifrac"));
        command.args(arguments).current_dir(self.folder.path());
        command
            .env_remove("COLUMNS")
            .env_remove("RAYON_NUM_THREADS");
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Outcome {
        let output = self.program(arguments).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Outcome {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// Runs and expects success; gives what was printed on standard output.
    pub fn succeed(&self, arguments: &[&str]) -> String {
        let outcome = self.run(arguments);
        assert_eq!(outcome.code, Some(0), "{arguments:?}: {outcome:?}");
        outcome.stdout
    }
}

/// Names of what a folder holds, sorted; nothing if there is no such folder. The list of its own files that
/// a run keeps is left out, and so are checkpoints.
pub fn list(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let name = |entry: fs::DirEntry| entry.file_name().into_string().unwrap();
    let mut names: Vec<String> = entries.map(|entry| name(entry.unwrap())).collect();
    names.retain(|name| !name.starts_with(".perifrac-files") && !name.ends_with(".pfc"));
    names.sort();
    names
}

/// Longest wait for what a program does.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until something is done.
#[track_caller]
pub fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(
            start.elapsed() < PATIENCE,
            "{what}: nothing after {PATIENCE:?}"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A call that must fail, and what it must say.
pub struct Fault<'a> {
    pub name: &'a str,
    /// Replacements in the base scene.
    pub change: &'a [(&'a str, &'a str)],
    /// Files to write; one called `scene.toml` takes the place of the base scene.
    pub files: &'a [(&'a str, &'a [u8])],
    pub arguments: &'a [&'a str],
    pub code: i32,
    /// All of standard error; line ends before and after do not count.
    pub stderr: &'a str,
}

/// A fault of the scene in `scene.toml`; the tables change what they need.
pub const FAULT: Fault = Fault {
    name: "",
    change: &[],
    files: &[],
    arguments: &["run", "scene.toml", "--out", "out"],
    code: 3,
    stderr: "",
};

/// Checks a table of faults and reports all that differ.
pub fn check(faults: &[Fault]) {
    let wrong: Vec<String> = faults.iter().filter_map(difference).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

fn difference(fault: &Fault) -> Option<String> {
    let place = Place::with_scene(fault.change);
    fault
        .files
        .iter()
        .for_each(|(name, content)| place.write(name, content));
    let outcome = place.run(fault.arguments);
    let (found, expected) = (
        outcome.stderr.trim_matches('\n'),
        fault.stderr.trim_matches('\n'),
    );
    let same = found == expected && outcome.code == Some(fault.code) && outcome.stdout.is_empty();
    (!same).then(|| {
        format!(
            "=== {}\n--- expected {}\n{expected}\n--- found {:?}\n{found}\n--- standard output\n{}===",
            fault.name, fault.code, outcome.code, outcome.stdout
        )
    })
}
