//! Properties of rock as fields: from files and drawn at random, against the same rock by regions and values.

use std::fmt::Write as _;
use std::path::Path;

use perifrac::model::Model;
use perifrac::plan::resolve;
use perifrac::report::Timers;
use perifrac::scene;

use crate::support::{largest_difference, model, plan, plan_of, run_text, try_run};

/// A strip of 20 × 4 points that is pulled along x.
const BAR: &str = r#"title = "Bar"
[geometry]
type = "lattice"
size = [1, 0.2]
points = [20, 4]
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
[mechanics.boundary.left]
roller = true
[mechanics.boundary.right]
normal_displacement = 1e-4
[mechanics.boundary.top]
roller = true
[mechanics.boundary.bottom]
roller = true
[time]
mode = "steady"
"#;
const COLUMNS: usize = 20;
const ROWS: usize = 4;

/// A table of columns, each a name and a value per point by its column of the lattice, x fastest.
struct Table(tempfile::TempDir);

impl Table {
    fn of(columns: &[(&str, &dyn Fn(usize) -> f64)]) -> Self {
        let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let mut text = names.join(",") + "\n";
        for point in 0..COLUMNS * ROWS {
            let values = columns.iter().map(|(_, value)| value(point % COLUMNS));
            let values: Vec<String> = values.map(|own| format!("{own:e}")).collect();
            writeln!(text, "{}", values.join(",")).unwrap();
        }
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("rock.csv"), text).unwrap();
        Self(directory)
    }

    /// The override that takes a key of the rock from the column of its name.
    fn key(&self, key: &str) -> String {
        let file = self.0.path().join("rock.csv");
        let file = file.display();
        format!("materials.rock.{key}={{file = \"{file}\", column = \"{key}\"}}")
    }
}

fn displacement(overrides: &[&str]) -> Vec<f64> {
    run_text(BAR, overrides).1.displacement
}

/// Point by point the bits are those of two regions; layers are cut between the same points, so that they differ by
/// rounding only.
#[test]
fn a_file_of_two_halves_is_two_regions() {
    let half = |column: usize| if column < COLUMNS / 2 { 1e10 } else { 4e10 };
    let table = Table::of(&[("youngs_modulus", &half)]);
    let file = table.key("youngs_modulus");
    let stiff = "materials.stiff={youngs_modulus = \"40 GPa\", poissons_ratio = 0.2, region = {type = \"box\", min = \
                 [0.5, 0], max = [1, 0.2]}}";
    let pointwise = "mechanics.interfaces=pointwise";
    let found = displacement(&[&file, pointwise]);
    assert_eq!(found, displacement(&[stiff, pointwise]));
    let [by_file, by_region] = [&*file, stiff].map(|own| displacement(&[own]));
    assert!(largest_difference(&by_file, &by_region) < 1e-13 * 1e-4);
    assert!(largest_difference(&by_file, &found) > 1e-2 * 1e-4);
}

/// A stress that is the same everywhere stretches rock of M(x) by σ ∫dx/M. Layers of cells take the harmonic mean of
/// M along bonds, which does not have the error of the arithmetic one of a family.
#[test]
fn layers_of_cells_stretch_like_a_smooth_modulus() {
    let modulus = |column: usize| 1e10 * (2.0 * (column as f64 + 0.5) / COLUMNS as f64).exp();
    let table = Table::of(&[("youngs_modulus", &modulus)]);
    let file = table.key("youngs_modulus");
    // u(x) by the cells, whose mean compliance is that of their middles to second order.
    let compliance: Vec<f64> = (0..COLUMNS).map(|k| 1.0 / modulus(k)).collect();
    let total: f64 = compliance.iter().sum();
    let exact = |k: usize| (compliance[..k].iter().sum::<f64>() + 0.5 * compliance[k]) / total;
    let error = |overrides: &[&str]| {
        let found = displacement(overrides);
        let own = |k: usize| (found[2 * (COLUMNS + k)] / 1e-4 - exact(k)).abs();
        (0..COLUMNS).map(own).fold(0.0, f64::max)
    };
    let [layers, pointwise] = [
        error(&[&file]),
        error(&[&file, "mechanics.interfaces=pointwise"]),
    ];
    assert!(layers < 1e-9, "{layers}");
    assert!(pointwise < 0.02, "{pointwise}");
}

/// A column of a tenth of the fracture energy takes all the damage.
#[test]
fn rock_breaks_where_its_file_is_weak() {
    let weak = 13;
    let energy = |column: usize| if column == weak { 10.0 } else { 100.0 };
    let table = Table::of(&[("fracture_energy", &energy)]);
    let sets = [
        table.key("fracture_energy"),
        "damage={model = \"paper\", length_scale = \"0.05 m\"}".to_owned(),
        "mechanics.boundary.right={normal_displacement = {time = [0, 1], value = [0, 1e-4]}}"
            .to_owned(),
        "time={end = 1, step = 0.25}".to_owned(),
    ];
    let sets: Vec<&str> = sets.iter().map(|own| &**own).collect();
    let plan = plan_of(BAR, &sets);
    let (_, state) = try_run(&plan).unwrap();
    let solid = model::<2>(&plan).solid.unwrap();
    let damage = solid.damage.as_ref().unwrap().of(&state.history);
    let most = |wanted: bool| {
        let points = (0..damage.len()).filter(|point| (point % COLUMNS == weak) == wanted);
        points.map(|point| damage[point]).fold(0.0, f64::max)
    };
    assert!(
        most(true) > 2.0 * most(false),
        "{} {}",
        most(true),
        most(false)
    );
    assert!(most(true) > 0.1);
}

const COUPLED: &[&str] = &[
    "materials.rock.permeability=1e-14",
    "materials.rock.porosity=0.2",
    "materials.rock.biot_coefficient=0.8",
    "materials.rock.bulk_modulus=10 GPa",
    "materials.rock.density=2300",
    "fluid={viscosity = \"1 cP\", bulk_modulus = \"2.2 GPa\"}",
    "flow.boundary.right={pressure = \"1 MPa\"}",
    "coupling={}",
    "gravity.acceleration=[0, -9.81]",
    "mechanics.mode=quasi-static",
    "time={end = 100, step = 25}",
];

/// Files that say the same at all points give the bits of the values, and take no more memory while the model runs.
#[test]
fn constant_files_are_values_to_the_last_bit() {
    let values = [
        ("youngs_modulus", 1e10),
        ("poissons_ratio", 0.2),
        ("porosity", 0.2),
        ("biot_coefficient", 0.8),
        ("bulk_modulus", 1e10),
        ("density", 2300.0),
        ("permeability", 1e-14),
    ];
    let constant: Vec<Box<dyn Fn(usize) -> f64>> = (values.iter())
        .map(|&(_, value)| Box::new(move |_| value) as Box<dyn Fn(usize) -> f64>)
        .collect();
    let columns: Vec<(&str, &dyn Fn(usize) -> f64)> = (values.iter().zip(&constant))
        .map(|((name, _), value)| (*name, &**value))
        .collect();
    let table = Table::of(&columns);
    let keys: Vec<String> = values.iter().map(|(name, _)| table.key(name)).collect();
    let files: Vec<&str> = COUPLED
        .iter()
        .copied()
        .chain(keys.iter().map(|own| &**own))
        .collect();
    let (scalar, expected) = run_text(BAR, COUPLED);
    let (summary, found) = run_text(BAR, &files);
    assert_eq!(found.pressure, expected.pressure);
    assert_eq!(found.displacement, expected.displacement);
    assert_eq!(summary.counters.bytes, scalar.counters.bytes);
    assert_eq!(summary.counters.field_bytes, scalar.counters.field_bytes);
}

fn drawn(median: &str, std: f64, seed: u64) -> String {
    format!(
        "{{distribution = \"log-normal\", median = \"{median}\", log10_std = {std}, correlation_length = 0.1, seed = {seed}}}"
    )
}

/// z of log-normal values of a median and a deviation.
fn normal(values: &[f64], median: f64, std: f64) -> Vec<f64> {
    values
        .iter()
        .map(|own| (own / median).log10() / std)
        .collect()
}

/// Fields of one seed and correlation length draw the same normal numbers; those of another seed do not.
#[test]
fn fields_of_one_seed_are_high_together() {
    let sets = [
        format!("materials.rock.youngs_modulus={}", drawn("20 GPa", 0.1, 5)),
        format!("materials.rock.permeability={}", drawn("1e-14 m^2", 0.5, 5)),
        format!("materials.rock.density={}", drawn("2300 kg/m^3", 0.01, 6)),
    ];
    let sets: Vec<&str> = COUPLED
        .iter()
        .copied()
        .chain(sets.iter().map(|own| &**own))
        .collect();
    let model = model::<2>(&plan_of(BAR, &sets));
    let solid = model.solid.as_ref().unwrap();
    // E = 2μ(1 + ν).
    let moduli: Vec<f64> = solid.elastic.lame.iter().map(|own| 2.4 * own.mu).collect();
    let stiff = normal(&moduli, 2e10, 0.1);
    let flow = model.flow.as_ref().unwrap();
    let mobility: Vec<f64> = flow.mobility.iter().map(|own| own * 1e-3).collect();
    let loose = normal(&mobility, 1e-14, 0.5);
    assert!(largest_difference(&stiff, &loose) < 1e-10);
    assert!(stiff.iter().any(|z| z.abs() > 0.5));
}

fn refusal(text: &str, overrides: &[&str]) -> String {
    let overrides: Vec<String> = overrides.iter().map(|own| (*own).to_owned()).collect();
    let loaded = scene::load_str("test", text, Path::new(""), &overrides)
        .unwrap_or_else(|errors| panic!("{errors}"));
    match resolve(&loaded, "test") {
        Err(errors) => errors.to_string(),
        Ok(plan) => match Model::<2>::build(&plan, &mut Timers::default()) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("nothing is refused"),
        },
    }
}

#[test]
fn values_that_make_no_sense_are_refused_with_their_place() {
    let porosity = |column: usize| if column == 3 { 0.9 } else { 0.2 };
    let ratio = |column: usize| if column == 7 { 0.5 } else { 0.2 };
    let table = Table::of(&[("porosity", &porosity), ("poissons_ratio", &ratio)]);
    let with = |set: &str| refusal(BAR, &[COUPLED, &[set]].concat());
    let message = with(&table.key("porosity"));
    assert!(
        message.contains("rock.csv, line 5: porosity is 0.9, above 0.8: the Biot coefficient"),
        "{message}"
    );
    let message = with(&table.key("poissons_ratio"));
    assert!(
        message.contains("line 9: poissons_ratio is 0.5, above 0.499999"),
        "{message}"
    );
    let message = with(&format!("materials.rock.porosity={}", drawn("0.5", 1.0, 1)));
    assert!(
        message.contains("the porosity of material \"rock\" is")
            && message.contains("Biot coefficient 0.8000"),
        "{message}"
    );
}

/// An exact solution of one rock is not compared with a field.
#[test]
fn references_refuse_fields_by_name() {
    for (case, key, median, words) in [
        (
            "terzaghi",
            "youngs_modulus",
            "10 GPa",
            "uniform Young's modulus",
        ),
        ("terzaghi", "storage", "1e-10 1/Pa", "uniform storage"),
        (
            "sneddon",
            "youngs_modulus",
            "10 GPa",
            "uniform Young's modulus",
        ),
        ("theis", "storage", "1e-10 1/Pa", "uniform storage"),
    ] {
        let name = plan(case, &[]).materials[0].name.clone();
        let set = format!("materials.{name}.{key}={}", drawn(median, 0.1, 1));
        let text = perifrac::cases::find(case).unwrap().scene;
        let message = refusal(text, &[&set]);
        assert!(message.contains(words), "{case}: {message}");
    }
}
