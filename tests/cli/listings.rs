//! Verbs that only tell or hand out something: cases, solvers, schema, help.

use serde_json::Value;

use crate::columns::MOVING;
use crate::support::Place;

const CASES: [&str; 35] = [
    "five-spot",
    "two-layer",
    "channel",
    "barrier",
    "inclusion",
    "heterogeneous",
    "spe10-1",
    "reservoir-3d",
    "theis",
    "anisotropic",
    "well-test",
    "terzaghi",
    "terzaghi-graded",
    "terzaghi-tensor",
    "column-3d",
    "mandel",
    "footing",
    "layers-stiffness",
    "sneddon",
    "notched-tension",
    "notched-shear",
    "pressurised-notch",
    "natural-fractures",
    "injection-rate",
    "kgd-toughness",
    "kgd-viscosity",
    "kgd-leak-off",
    "breakdown",
    "inclined-injection",
    "two-cracks",
    "wing-cracks",
    "staged-injection",
    "penny-3d",
    "penny-viscosity",
    "manufactured",
];

#[test]
fn every_bundled_case_is_listed_and_sound() {
    let place = Place::new();
    let listed = place.succeed(&["cases"]);
    let names: Vec<&str> = listed
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(names, CASES);
    for name in names {
        let text = place.succeed(&["check", name]);
        let sound = |line: &str| line.starts_with(name) && line.contains(": no faults found");
        assert!(text.lines().all(sound), "{text}");
    }
}

#[test]
fn every_variant_of_a_bundled_case_is_sound() {
    let place = Place::new();
    let all = perifrac::cases::CASES.iter();
    let variants =
        all.flat_map(|case| case.variants.iter().map(move |(name, _)| (case.name, name)));
    for (case, variant) in variants {
        let checked = place.succeed(&["check", &format!("{case}/{variant}")]);
        assert!(checked.contains("no faults found"), "{checked}");
    }
}

#[test]
fn a_variant_that_was_written_into_a_folder_is_sound_there() {
    let place = Place::new();
    let written = place.succeed(&["cases", "--write", "kgd-leak-off/smoke", "own/crack"]);
    assert!(
        written.contains("perifrac run own/crack/smoke.toml"),
        "{written}"
    );
    let files = ["README.md", "scene.toml", "smoke.toml"];
    assert_eq!(place.list("own/crack"), files);
    place.succeed(&["check", "own/crack/smoke.toml"]);
}

#[test]
fn a_case_that_was_written_runs_from_its_file() {
    let place = Place::new();
    let written = place.succeed(&["cases", "--write", "channel"]);
    assert!(
        written.contains("perifrac run channel/scene.toml"),
        "{written}"
    );
    assert_eq!(place.list("channel"), ["README.md", "scene.toml"]);
    let coarse = [
        "--set",
        "geometry.points=[11, 11]",
        "--set",
        "materials.channel.region.max=[0.8, 0.55]",
    ];
    let fast = [
        "--set",
        "output.plots=false",
        "--set",
        "time.end=10",
        "--set",
        "output.times=[]",
    ];
    place.succeed(
        &[
            &["run", "channel/scene.toml", "--out", "written"],
            &coarse[..],
            &fast,
        ]
        .concat(),
    );
    place.succeed(&[&["run", "channel", "--out", "bundled"], &coarse[..], &fast].concat());
    assert!(place.list("written").contains(&"summary.json".to_owned()));
    assert_eq!(
        place.read("written/history.csv"),
        place.read("bundled/history.csv")
    );
}

#[test]
fn the_solvers_are_listed_with_their_options() {
    let text = Place::new().succeed(&["solvers"]);
    for word in [
        "faer-llt",
        "faer-cg",
        "auto",
        "preconditioner=",
        "Preconditioners",
        "petsc",
        "\nPETSc ",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn what_can_be_combined_is_told_as_in_the_documents() {
    let told = Place::new().succeed(&["schemes"]);
    assert_eq!(
        told.trim_end(),
        include_str!("../../docs/combinations.md").trim_end()
    );
    assert!(told.contains("`[fracture_flow]`"), "{told}");
}

#[test]
fn the_schema_is_json_and_knows_the_sections() {
    let schema: Value = serde_json::from_str(&Place::new().succeed(&["schema"])).unwrap();
    for section in [
        "title",
        "geometry",
        "fluid",
        "materials",
        "flow",
        "time",
        "output",
        "solver",
    ] {
        assert!(schema["properties"].get(section).is_some(), "{section}");
    }
    assert_eq!(schema["additionalProperties"], Value::Bool(false));
}

#[test]
fn help_and_version_are_told() {
    let place = Place::new();
    let help = place.succeed(&["--help"]);
    for verb in [
        "run",
        "plan",
        "check",
        "cases",
        "schemes",
        "solvers",
        "schema",
        "completions",
        "man",
    ] {
        assert!(
            help.lines().any(|line| line.trim_start().starts_with(verb)),
            "{verb}: {help}"
        );
    }
    assert!(help.contains("130 interrupted"), "{help}");
    assert_eq!(
        place.succeed(&["--version"]),
        format!("perifrac {}\n", env!("CARGO_PKG_VERSION"))
    );
}

/// The row of a table that `plan --choices` marks, and all cells of it.
fn choices(place: &Place, words: &[&str]) -> (String, Vec<Vec<String>>) {
    let text = place.succeed(&[&["plan", "--choices"], words].concat());
    let cells = |line: &str| -> Vec<String> {
        line.split(" | ")
            .skip(1)
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    let marked: Vec<&str> = text.lines().filter(|line| line.starts_with('>')).collect();
    assert_eq!(marked.len(), 1, "{text}");
    (
        cells(marked[0])[0].clone(),
        text.lines().skip(1).map(cells).collect(),
    )
}

#[test]
fn what_to_choose_is_told_as_in_the_book() {
    let place = Place::new();
    let page = include_str!("../../docs/book/pages/choosing.md");
    let table = page.lines().filter(|line| line.starts_with('|')).take(11);
    let row = |line: &str| -> Vec<String> {
        line.trim_matches('|')
            .split(" | ")
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    let mut told: Vec<Vec<String>> = table.map(row).collect();
    assert_eq!(told.remove(1), ["---|---|---|---|---|---|---"]);
    assert_eq!(choices(&place, &["five-spot"]).1, told);
}

#[test]
fn the_row_of_a_scene_is_that_of_the_hardest_thing_it_does() {
    let place = Place::new();
    place.write("moving.toml", MOVING);
    for (words, problem) in [
        (&["five-spot"][..], "flow alone"),
        (&["barrier"], "flow, only the end state"),
        (&["sneddon"], "deformation alone"),
        (&["terzaghi"], "consolidation"),
        (&["moving.toml"], "waves, impact"),
        (&["notched-tension"], "rock that breaks"),
        (
            &["notched-tension/paper"],
            "rock that breaks, model of the paper",
        ),
        (&["kgd-toughness/smoke"], "injection"),
        (
            &["natural-fractures/paper"],
            "injection, model of the paper",
        ),
    ] {
        assert_eq!(choices(&place, words).0, problem, "{words:?}");
    }
    let json = place.succeed(&["plan", "terzaghi", "--choices", "--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["applies"], "consolidation");
    let rows = json["choices"].as_array().unwrap();
    assert!(
        rows.iter()
            .any(|row| row["problem"] == json["applies"] && row["scheme"].is_string())
    );
}
