//! Every column of every table is told of: its unit and its meaning.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::support::Place;

/// Small runs that together write every column of tables of runs.
const RUNS: &[&[&str]] = &[
    &["terzaghi", "--set", "time.step=6"],
    &["mandel", "--set", "geometry.spacing=0.05"],
    &["well-test/limited", "--set", "geometry.points=[30, 30]"],
    &["barrier"],
    &["column-3d", "--set", "time.step=2"],
    &["notched-tension/smoke"],
    &[
        "natural-fractures/smoke",
        "--set",
        "geometry.spacing=0.03",
        "--end",
        "0.02",
    ],
    &[
        "natural-fractures/smoke",
        "--set",
        "geometry.spacing=0.03",
        "--set",
        CRACK,
        "--end",
        "0.002",
    ],
    &["kgd-toughness/smoke", "--end", "0.2"],
    &["penny-3d/smoke"],
    &["sneddon", "--set", "geometry.spacing=0.02"],
    &["moving.toml"],
    &["regions.toml"],
    &["staged.toml"],
];

/// A crack in pores that fluid under a given pressure fills.
const CRACK: &str =
    "cracks.main={kind=\"damaged\", points=[[0, 0.48], [0.15, 0.48]], pressure=1e3}";

/// Rock with inertia.
pub const MOVING: &str = r#"
[geometry]
type = "lattice"
size = [1, 1]
points = [6, 6]
[materials.rock]
youngs_modulus = 1e9
poissons_ratio = 0.25
density = 2000
[mechanics]
mode = "dynamic"
boundary.bottom.clamped = true
loads.top = { side = "top", traction = [0, -1e5] }
[scheme]
name = "explicit"
[time]
end = "1 ms"
[output]
profiles.up = { from = [0.5, 0], to = [0.5, 1], points = 3 }
"#;

const REGIONS: &str = r#"
[geometry]
type = "lattice"
size = [1, 1]
points = [8, 8]
[fluid]
viscosity = 1e-3
[materials.rock]
permeability = 1e-15
storage = 1e-10
[flow]
regions = [{ region = { type = "box", min = [0, 0], max = [0.3, 0.3] }, pressure = 1e6 }]
boundary.right.pressure = 0
[time]
end = "1 s"
[output]
profiles.across = { from = [0, 0.5], to = [1, 0.5], points = 3 }
"#;

const STAGES: &str = "base = \"regions.toml\"\n[[stages]]\nname = \"one\"\n[[stages]]\nname = \"two\"\n\
                      [stages.time]\nend = \"2 s\"\n";

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).unwrap()
}

/// Names of the columns of tables in a folder, by file, as their first lines have them.
fn headings(place: &Place, folder: &str) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for file in place.list(folder) {
        if file.ends_with(".csv") {
            let text = String::from_utf8(place.read(&format!("{folder}/{file}"))).unwrap();
            let first = text.lines().next().unwrap();
            all.extend(first.split(',').map(|name| (file.clone(), name.to_owned())));
        }
    }
    all
}

fn text<'a>(column: &'a Value, key: &str) -> &'a str {
    column[key].as_str().unwrap()
}

/// What a run tells of its columns; they are those of its tables, with unit and meaning.
fn told(place: &Place, folder: &str) -> Vec<Value> {
    let summary = json(&place.read(&format!("{folder}/summary.json")));
    let columns = summary["columns"].as_array().unwrap().clone();
    let named = |own: &Value| (text(own, "file").to_owned(), text(own, "name").to_owned());
    let mut names: Vec<_> = columns.iter().map(named).collect();
    names.sort_by(|a, b| a.0.cmp(&b.0));
    assert_eq!(names, headings(place, folder), "{folder}");
    for column in &columns {
        assert!(!text(column, "meaning").is_empty(), "{folder}: {column}");
        assert!(!text(column, "unit").is_empty(), "{folder}: {column}");
    }
    columns
}

#[test]
fn runs_tell_of_every_column_and_leave_none_of_the_list_out() {
    let place = Place::new();
    for (name, scene) in [
        ("moving.toml", MOVING),
        ("regions.toml", REGIONS),
        ("staged.toml", STAGES),
    ] {
        place.write(name, scene);
    }
    let mut seen = BTreeSet::new();
    for (number, words) in RUNS.iter().enumerate() {
        let folder = format!("{number}");
        let quick = ["--set", "output.plots=false", "--out", &folder, "--json"];
        let printed = place.succeed(&[&["run"], *words, &quick[..]].concat());
        let stages = place
            .list(&folder)
            .into_iter()
            .filter(|name| place.path(&format!("{folder}/{name}")).is_dir());
        let folders = stages
            .map(|stage| format!("{folder}/{stage}"))
            .chain([folder.clone()]);
        let all: Vec<Value> = folders.flat_map(|folder| told(&place, &folder)).collect();
        let own = &json(printed.as_bytes())["columns"];
        assert!(
            own.as_array()
                .unwrap()
                .iter()
                .all(|column| all.contains(column)),
            "{own}"
        );
        seen.extend(all.iter().map(|own| {
            (
                text(own, "unit").to_owned(),
                text(own, "meaning").to_owned(),
            )
        }));
    }
    let known = json(place.succeed(&["schema", "--columns"]).as_bytes());
    let known = known.as_array().unwrap().iter();
    let of_runs = known.filter(|column| text(column, "file") != "KIND.csv");
    let never = of_runs.filter(|column| {
        !seen.contains(&(
            text(column, "unit").to_owned(),
            text(column, "meaning").to_owned(),
        ))
    });
    let never: Vec<&str> = never.map(|column| text(column, "name")).collect();
    assert!(never.is_empty(), "no run writes {never:?}");
}

#[test]
fn a_study_writes_columns_of_the_list_and_no_others() {
    let place = Place::new();
    let known = json(place.succeed(&["schema", "--columns"]).as_bytes());
    let known = known.as_array().unwrap().iter();
    let of_studies: Vec<&str> = known
        .filter(|column| text(column, "file") == "KIND.csv")
        .map(|column| text(column, "name"))
        .collect();
    for (kind, case) in [
        ("convergence", "terzaghi"),
        ("contrast", "two-layer"),
        ("stability", "terzaghi"),
    ] {
        let study = [
            "study", kind, case, "--quick", "--budget", "4s", "--out", kind,
        ];
        place.succeed(&study);
        for (file, name) in headings(&place, kind) {
            let field = name.starts_with("error_") && of_studies.contains(&"error_FIELD");
            assert!(field || of_studies.contains(&&*name), "{file}: {name}");
        }
    }
}
