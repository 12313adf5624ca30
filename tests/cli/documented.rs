//! What is written works: every command of the README, the notes and the book, every scene of the book, every
//! bundled case and every variant.
//!
//! Commands are read from the texts, so that they cannot drift apart. What takes long is run smaller or
//! shorter; the tables here say how, and a line of them that no longer fits anything is a failure.

use std::fs;
use std::path::{Path, PathBuf};

use crate::processes;
use crate::support::Place;

/// Keys changed, and words added, in a documented command that begins so.
const SHORTENED: &[(&str, &[&str])] = &[
    ("run five-spot", &["geometry.points=[50, 50]"]),
    ("run heterogeneous", &["geometry.points=[30, 30]"]),
    ("run terzaghi", &["geometry.spacing=0.25"]),
    ("run natural-fractures/wide", FIRST_OF_WIDE),
    (
        "run staged-injection",
        &["geometry.spacing=4 cm", "--out", "out/staged-injection"],
    ),
    ("run inclined-crack.toml", &["time.end=0.1"]),
    ("run injection.toml", &["time.end=0.02"]),
    ("study", &["--quick", "--budget", "3s"]),
    ("plan terzaghi --for-error", &["geometry.spacing=0.5"]),
];

/// Commands that are not run here: they are continuous integration itself, for users of the library, or
/// tested elsewhere (examples).
const ELSEWHERE: &[&str] = &[
    "apt-get",
    "cargo add",
    "cargo build",
    "cargo check",
    "cargo clippy",
    "cargo doc",
    "cargo fmt",
    "cargo install",
    "cargo package",
    "cargo run --release --example",
    "cargo run --release -p",
    "cargo test",
    "docs/book/build",
    "pip install",
];

/// What stands for a name of the user's choice.
const PLACEHOLDERS: &[(&str, &str)] = &[
    ("SCENE", "two-layer"),
    ("NAME", "channel"),
    ("DIR", "earlier"),
];

const FIRST_OF_WIDE: &[&str] = &[
    "geometry.spacing=8 cm",
    "damage.length_scale=24 cm",
    "time.end=0.02",
    "time.max_step=0.02",
];

/// How cases and variants are run that take more than seconds: changed keys. Those with a step of their own
/// end after the first.
const SMALLER: &[(&str, &[&str])] = &[
    ("five-spot", &["geometry.points=[50, 50]"]),
    ("channel", &["time.end=1"]),
    ("heterogeneous", &["geometry.points=[30, 30]"]),
    ("reservoir-3d", &["geometry.points=[10, 10, 5]"]),
    ("anisotropic", &["geometry.points=[50, 50]"]),
    ("well-test", &["geometry.points=[40, 40]"]),
    ("well-test/limited", &["geometry.points=[40, 40]"]),
    ("terzaghi", &["time.step=3"]),
    ("terzaghi-graded", &["time.step=3"]),
    ("terzaghi-tensor", &["time.step=3"]),
    ("penny-3d", &["geometry.points=[12, 12, 12]"]),
    ("notched-tension", TENSION),
    ("notched-tension/fine", TENSION_OF_PAPER),
    ("notched-tension/paper", TENSION_OF_PAPER),
    ("notched-tension/uniform", TENSION_OF_PAPER),
    ("notched-shear", SHEAR),
    ("notched-shear/paper", SHEAR_OF_PAPER),
    ("notched-shear/uniform", SHEAR_OF_PAPER),
    (
        "pressurised-notch",
        &["geometry.spacing=2 cm", "time.end=200"],
    ),
    (
        "pressurised-notch/paper",
        &["geometry.spacing=2 cm", "time.end=200"],
    ),
    ("natural-fractures", PUMPED),
    ("natural-fractures/paper", INJECTION),
    ("natural-fractures/vertical", INJECTION),
    ("natural-fractures/wide", FIRST_OF_WIDE),
    ("injection-rate", PUMPED),
    ("injection-rate/four", PUMPED),
    ("injection-rate/six", PUMPED),
    ("staged-injection", &["geometry.spacing=4 cm"]),
    ("kgd-toughness", KGD),
    ("kgd-viscosity", KGD),
    ("kgd-leak-off", &["geometry.spacing=10 cm", "time.end=0.3"]),
    ("breakdown", &["geometry.spacing=6.25 cm"]),
    ("inclined-injection", INCLINED),
    ("inclined-injection/turned", INCLINED),
    (
        "penny-viscosity",
        &["geometry.spacing=30 cm", "time.end=0.03"],
    ),
    ("two-cracks", KGD),
    ("wing-cracks", &["geometry.spacing=8 cm", "time.end=0.3"]),
];
const KGD: &[&str] = &["geometry.spacing=12.5 cm", "time.end=0.3"];
const INCLINED: &[&str] = &["geometry.spacing=8 cm", "time.end=0.3"];
const TENSION: &[&str] = &[COARSE, "time.end=300"];
const SHEAR: &[&str] = &[COARSE, "time.end=75"];
const TENSION_OF_PAPER: &[&str] = &[COARSE, NOTCH, "time.end=300"];
const SHEAR_OF_PAPER: &[&str] = &[COARSE, NOTCH, "time.end=75"];
const COARSE: &str = "geometry={type=\"lattice\", size=[\"1 mm\", \"1 mm\"], points=[30, 30]}";
const NOTCH: &str = "damage.length_scale=0.1333333 mm";
const PUMPED: &[&str] = &["geometry.spacing=4 cm", "time.end=0.02"];
const INJECTION: &[&str] = &[
    "geometry.spacing=4 cm",
    "damage.length_scale=8 cm",
    "time.end=0.02",
    "time.max_step=0.02",
];

/// Variants that are small as they are.
const SMOKE: &str = "/smoke";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All texts that a user reads.
fn texts() -> Vec<PathBuf> {
    let mut found = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    let mut folders = vec![
        root().join("docs"),
        root().join("cases"),
        root().join("benches"),
    ];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "md") {
                found.push(path);
            }
        }
    }
    found
}

/// Copies the scenes of the book, with their data, to where its commands are run; their names.
fn scenes_of_the_book(place: &Place) -> Vec<String> {
    let mut names = Vec::new();
    for file in fs::read_dir(root().join("docs/book/scenes")).unwrap() {
        let path = file.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        place.write(&name, fs::read(&path).unwrap());
        names.push(name);
    }
    names.retain(|name| name.ends_with(".toml"));
    names
}

/// Commands in the shell blocks of a text, and those in its lines that are whole.
fn commands(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (number, part) in text.split("```").enumerate() {
        if number % 2 == 1 {
            let block = part.strip_prefix("sh\n").unwrap_or_default();
            found.extend(block.lines().map(str::to_owned));
            continue;
        }
        let spans = part.split('`').skip(1).step_by(2);
        let spans = spans.map(|span| span.split_whitespace().collect::<Vec<_>>().join(" "));
        found.extend(
            spans.filter(|span| span.starts_with("perifrac ") && span.matches(' ').count() > 1),
        );
    }
    // What is left open is the form of a command.
    found.retain(|line| !words(line).is_empty() && !line.contains('…'));
    found
}

/// Words of a command as a shell splits them, without the remark at its end.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for letter in line.chars() {
        match (quote, letter) {
            (Some(open), _) if letter == open => quote = None,
            (None, '\'' | '"') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, _) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    words
}

/// What the program is given, and over how many processes; nothing for what is not run here.
fn arguments(command: &str) -> Option<(Vec<String>, usize)> {
    if ELSEWHERE.iter().any(|start| command.starts_with(start)) {
        return None;
    }
    let mut words = words(command);
    let mut count = 0;
    for (start, processes) in [
        (&["cargo", "run", "--release", "--"][..], 0),
        (&["mpirun", "-n", "2", "perifrac"], 2),
        (&["perifrac"], 0),
    ] {
        if words.len() > start.len() && words.iter().zip(start).all(|(own, known)| own == known) {
            words.drain(..start.len());
            count = processes;
            for word in &mut words {
                let known = PLACEHOLDERS.iter().find(|(name, _)| name == word);
                *word = known.map_or(word.clone(), |(_, own)| (*own).to_owned());
            }
            return Some((words, count));
        }
    }
    panic!("`{command}` is no command of this program: {words:?} {count}");
}

/// A command with what the table adds to it; keys that it sets itself stay.
fn shortened(mut all: Vec<String>, used: &mut Vec<&'static str>) -> Vec<String> {
    let typed = all.join(" ");
    for (start, added) in SHORTENED
        .iter()
        .filter(|(start, _)| typed.starts_with(start))
    {
        used.push(start);
        let key = |word: &str| word.split('=').next().unwrap_or_default().to_owned();
        for word in added.iter().filter(|word| !typed.contains(&key(word))) {
            if word.contains('=') {
                all.push("--set".to_owned());
            }
            all.push((*word).to_owned());
        }
    }
    all
}

/// Runs a documented command, shortened; tells what went wrong.
fn fault(place: &Place, command: &str, used: &mut Vec<&'static str>) -> Option<String> {
    let (typed, count) = arguments(command)?;
    let all = shortened(typed, used);
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let possible = processes::possible();
    let expected = match possible || !command.contains("petsc") {
        true => 0,
        // What PETSc would do is refused by name.
        false => 2,
    };
    let (code, stderr) = match count {
        2.. if possible => {
            let output = processes::mpirun(place, count, &all).output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr);
            (output.status.code(), stderr.into_owned())
        }
        _ => {
            let outcome = place.run(&all);
            (outcome.code, outcome.stderr)
        }
    };
    (code != Some(expected)).then(|| format!("`{command}` as {all:?}: {code:?}\n{stderr}"))
}

#[test]
fn every_documented_command_works() {
    let place = Place::new();
    scenes_of_the_book(&place);
    place.succeed(&["run", "two-layer", "--out", "earlier"]);
    let (mut used, mut faults, mut done) = (Vec::new(), Vec::new(), Vec::new());
    for path in texts() {
        for command in commands(&fs::read_to_string(path).unwrap()) {
            let words = words(&command);
            if !done.contains(&words) {
                faults.extend(fault(&place, &command, &mut used));
                done.push(words);
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(done.len() > 35, "{done:?}");
    let unused = SHORTENED.iter().filter(|(start, _)| !used.contains(start));
    assert_eq!(unused.count(), 0, "all of the table is used: {used:?}");
}

/// A block of the book is a whole scene, if only by its `base`, or includes one that is a file.
#[test]
fn every_scene_of_the_book_is_sound() {
    let place = Place::new();
    let names = scenes_of_the_book(&place);
    for name in &names {
        place.succeed(&["check", name]);
    }
    let mut blocks = 0;
    let book = root().join("docs/book");
    for path in texts().iter().filter(|path| path.starts_with(&book)) {
        let text = fs::read_to_string(path).unwrap();
        let blocks_of = text.split("```").skip(1).step_by(2);
        for block in blocks_of.filter_map(|block| block.strip_prefix("toml\n")) {
            if !block.starts_with("--8<--") {
                place.write("block.toml", block);
                place.succeed(&["check", "block.toml"]);
                blocks += 1;
            }
        }
    }
    assert!(names.len() >= 6 && blocks >= 6, "{names:?} {blocks}");
}

/// Every case and variant by its name.
fn every_scene() -> Vec<String> {
    let all = perifrac::cases::CASES.iter();
    let names = all.flat_map(|case| {
        let variants = case.variants.iter();
        let variants = variants.map(|(name, _)| format!("{}/{name}", case.name));
        std::iter::once(case.name.to_owned()).chain(variants)
    });
    names.collect()
}

#[test]
fn every_file_of_the_cases_is_known_by_its_name() {
    let names = every_scene();
    for case in fs::read_dir(root().join("cases")).unwrap() {
        let case = case.unwrap();
        for file in fs::read_dir(case.path()).unwrap() {
            let path = file.unwrap().path();
            let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
            if path.extension().is_none_or(|ending| ending != "toml") {
                continue;
            }
            let case = case.file_name().into_string().unwrap();
            let name = match stem.as_str() {
                "scene" => case,
                variant => format!("{case}/{variant}"),
            };
            assert!(names.contains(&name), "{name} cannot be run by its name");
        }
    }
}

#[test]
fn every_case_and_variant_runs() {
    let place = Place::new();
    for name in every_scene().iter().filter(|name| !name.ends_with(SMOKE)) {
        place.succeed(&["plan", name]);
        let smaller = SMALLER.iter().find(|(own, _)| own == name);
        let mut all = vec!["run", name, "--set", "output.times=[]", "--threads", "1"];
        for key in smaller.iter().flat_map(|(_, keys)| keys.iter()) {
            all.extend(["--set", key]);
        }
        place.succeed(&all);
    }
    let known = every_scene();
    let unused = SMALLER
        .iter()
        .filter(|(name, _)| !known.iter().any(|own| own == name));
    assert_eq!(unused.count(), 0);
}

/// The smoke form of a case in which rock breaks must let it break.
#[test]
fn smoke_forms_run_and_show_their_case() {
    let place = Place::new();
    let mut breaking = 0;
    for name in every_scene().iter().filter(|name| name.ends_with(SMOKE)) {
        place.succeed(&["run", name, "--threads", "1", "--out", "out"]);
        if let Some(drawing) = place
            .list("out")
            .iter()
            .find(|file| *file == "crack-path.svg")
        {
            let drawing = String::from_utf8(place.read(&format!("out/{drawing}"))).unwrap();
            assert!(!drawing.contains("nothing broke"), "{name}");
            breaking += 1;
        }
    }
    assert!(breaking >= 5, "{breaking}");
}
