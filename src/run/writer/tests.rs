//! What runs of mechanics leave in their folder.

use std::fs;
use std::path::Path;

use super::*;
use crate::plan::resolve;
use crate::run::{Interrupt, run};
use crate::scene::load_str;

/// A block under a load that grows, and nothing else.
const SOLID: &str = r#"title = "Solid"
[geometry]
type = "lattice"
size = [1, 1]
points = [6, 6]
[materials.rock]
youngs_modulus = "1 GPa"
poissons_ratio = 0.25
[mechanics.boundary.bottom]
clamped = true
[mechanics.boundary.top]
traction = [0, "-1 MPa"]
[time]
end = 10
step = 1
[output.profiles.up]
from = [0.5, 0]
to = [0.5, 1]
points = 3
"#;

const COUPLED: [&str; 6] = [
    "fluid.viscosity=1 cP",
    "flow.boundary.top.pressure=0",
    "materials.rock.permeability=1e-15",
    "materials.rock.storage=1e-10",
    "materials.rock.biot_coefficient=0.8",
    "coupling={}",
];

/// The block with `--set` values.
pub(crate) fn plan(overrides: &[&str]) -> Plan {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let loaded = load_str("solid.toml", SOLID, Path::new(""), &overrides);
    let loaded = loaded.unwrap_or_else(|errors| panic!("{errors}"));
    resolve(&loaded, "solid").unwrap_or_else(|errors| panic!("{errors}"))
}

fn write(folder: &Path, overrides: &[&str]) -> Summary {
    let mut writer = Writer::create(folder, "").unwrap();
    let interrupt = Interrupt::default();
    let result = run(&plan(overrides), Some(&mut writer), &mut (), &interrupt);
    result.unwrap_or_else(|error| panic!("{error}")).0
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != crate::output::LIST)
        .collect();
    names.sort();
    names
}

/// Names of the arrays at the points of a VTU file.
fn arrays(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let (_, points) = text.split_once("<PointData>").unwrap();
    let names = points.split("Name=\"").skip(1);
    let names = names.filter(|rest| !rest.starts_with(|c: char| c.is_ascii_uppercase()));
    names
        .map(|rest| rest.split('"').next().unwrap().to_owned())
        .collect()
}

#[test]
fn mechanics_alone_writes_nothing_of_flow() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[]);
    let expected = [
        "deformed-0000.png",
        "deformed-0001.png",
        "displacement-0000.png",
        "displacement-0001.png",
        "fields-0000.vtu",
        "fields-0001.vtu",
        "fields.pvd",
        "history-displacement.svg",
        "history-step.svg",
        "history.csv",
        "profile-up-displacement.svg",
        "profile-up.csv",
        "resolved.toml",
        "setup.png",
        "stress-0000.png",
        "stress-0001.png",
        "summary.json",
    ];
    assert_eq!(names(folder.path()), expected);
    let expected = [
        "displacement",
        "effective_stress",
        "volumetric_strain",
        "volume",
        "material_id",
    ];
    assert_eq!(arrays(&folder.path().join("fields-0001.vtu")), expected);
}

/// What is the same at all points stands in the scene; two rocks of one modulus do not make it vary.
#[test]
fn properties_that_vary_are_fields() {
    let other = |changes: &str| {
        format!(
            "materials.other={{youngs_modulus=\"1 GPa\", poissons_ratio=0.25, {changes} region={{type=\"box\", \
             min=[0, 0], max=[0.5, 1]}}}}"
        )
    };
    let written = |sets: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &[sets, &["output.plots=false"]].concat());
        arrays(&folder.path().join("fields-0001.vtu"))[5..].to_vec()
    };
    assert!(written(&[&other("")]).is_empty());
    let stiff = other("").replace("1 GPa", "2 GPa");
    assert_eq!(written(&[&stiff]), ["youngs_modulus"]);
    // Poisson's ratio comes back from Lamé's constants with their rounding.
    let drawn = "materials.rock.youngs_modulus={distribution=\"log-normal\", median=\"1 GPa\", log10_std=0.2, seed=1}";
    assert_eq!(written(&[drawn]), ["youngs_modulus"]);
    let model = Model::<2>::of(&plan(&[&stiff])).unwrap();
    let [modulus] = &model.varying[..] else {
        panic!("{:?}", model.varying);
    };
    for (x, found) in model.cloud.position.iter().zip(&modulus.values) {
        let expected = if x[0] < 0.5 { 2e9 } else { 1e9 };
        assert!((found / expected - 1.0).abs() < 1e-12, "{x} {found}");
    }
}

#[test]
fn results_of_mechanics_are_replaced_by_the_next_run() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &["output.times=[5]"]);
    assert!(folder.path().join("displacement-0002.png").exists());
    write(folder.path(), &["output.plots=false"]);
    let expected = [
        "fields-0000.vtu",
        "fields-0001.vtu",
        "fields.pvd",
        "history.csv",
        "profile-up.csv",
        "resolved.toml",
        "summary.json",
    ];
    assert_eq!(names(folder.path()), expected);
}

#[test]
fn both_fields_have_pictures_arrays_and_drawings() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &COUPLED);
    let found = names(folder.path());
    for name in [
        "displacement-0001.png",
        "pressure-0001.png",
        "history-displacement.svg",
        "history-pressure.svg",
        "profile-up-displacement.svg",
        "profile-up.svg",
    ] {
        assert!(found.iter().any(|file| file == name), "{name}: {found:?}");
    }
    let found = arrays(&folder.path().join("fields-0001.vtu"));
    assert_eq!(
        found[..4],
        ["pressure", "velocity", "permeability", "displacement"]
    );
}

/// The profile runs from the clamped bottom to the loaded top, at which it must agree with the field.
#[test]
fn a_profile_has_a_row_per_place_and_output_after_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let summary = write(folder.path(), &["output.every=1"]);
    let table = History::read(folder.path().join("profile-up.csv")).unwrap();
    let expected = [
        "time_s",
        "distance_m",
        "displacement_x_m",
        "displacement_y_m",
    ];
    assert_eq!(table.columns, expected);
    assert_eq!(table.rows.len(), 3 * 10);
    let time = table.column("time_s").unwrap();
    assert_eq!(
        [time[0], time[3], time[29]].map(|t| t.round() as i64),
        [1, 2, 10]
    );
    let down = table.column("displacement_y_m").unwrap();
    assert!(down[0].abs() < 0.05 * down[2].abs(), "{down:?}");
    let largest = summary.displacement_max.unwrap();
    assert!(
        down[2] < -0.8 * largest && down[2] > -1.3 * largest,
        "{down:?} {largest}"
    );
    let drawing = fs::read_to_string(folder.path().join("profile-up-displacement.svg")).unwrap();
    assert!(drawing.contains("y-displacement along up"));
    let curves = (1..=10).filter(|k| drawing.contains(&format!("t = {k} s")));
    assert_eq!(curves.collect::<Vec<_>>(), [2, 4, 6, 8, 10]);
}

#[test]
fn history_has_every_step_until_there_are_too_many_and_then_an_even_share() {
    let folder = tempfile::tempdir().unwrap();
    let run_with = |most: usize| {
        let mut writer = Writer::create(folder.path(), "").unwrap();
        writer.most_rows = most;
        let plan = plan(&["time.step=0.1", "output.plots=false"]);
        let interrupt = Interrupt::default();
        let (summary, _) = run(&plan, Some(&mut writer), &mut (), &interrupt).unwrap();
        let table = History::read(folder.path().join("history.csv")).unwrap();
        (summary, table.column("time_s").unwrap())
    };
    let (summary, time) = run_with(MOST_ROWS);
    assert_eq!((time.len(), summary.steps), (101, 100));
    assert!(
        !summary
            .warnings
            .iter()
            .any(|text| text.contains("history.csv"))
    );
    let (summary, time) = run_with(16);
    // 101 states pass 16 rows at strides of 1, 2 and 4.
    let expected = (0..13).map(|k| 0.8 * f64::from(k)).chain([10.0]);
    assert_eq!(time.len(), 14);
    assert!(
        time.iter()
            .zip(expected)
            .all(|(found, exact)| (found - exact).abs() < 1e-9)
    );
    let told = summary
        .warnings
        .iter()
        .filter(|text| text.contains("one in 8 of the 100 steps"));
    assert_eq!(told.count(), 1, "{:?}", summary.warnings);
}

/// The slit runs through three of 5 × 5 cells, in the last of which it ends.
#[test]
fn a_cut_crack_has_no_cells_across_it_and_is_a_line_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[
            "cracks.slit={points=[[0, 0.5], [0.5, 0.5]], kind=\"cut\", pressure=1e6}",
            "output.plots=false",
        ],
    );
    let text = fs::read_to_string(folder.path().join("fields-0001.vtu")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let of = |tag: &str, name: &str| {
        let mut nodes = document.descendants();
        let node = nodes.find(|node| node.has_tag_name(tag));
        node.and_then(|node| node.attribute(name).map(str::to_owned))
    };
    assert_eq!(of("Piece", "NumberOfPoints").as_deref(), Some("36"));
    assert_eq!(of("Piece", "NumberOfCells").as_deref(), Some("22"));
    let text = fs::read_to_string(folder.path().join("cracks-0001.vtp")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let names = document
        .descendants()
        .filter_map(|node| node.attribute("Name"));
    let names: Vec<&str> = names.collect();
    let expected = ["crack", "distance", "opening", "sliding", "pressure"];
    assert_eq!(names[names.len() - 5..], expected);
    let collection = fs::read_to_string(folder.path().join("cracks.pvd")).unwrap();
    assert!(collection.contains("cracks-0000.vtp") && collection.contains("cracks-0001.vtp"));
}
