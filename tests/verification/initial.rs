//! In-situ states: at rest as long as nothing changes, refused where they are not in equilibrium, and without
//! effect on what is added to them.

use std::path::Path;

use perifrac::plan::{Plan, resolve};
use perifrac::run::{CheckpointRule, Interrupt, Job, Settings, Writer, openings, run_job};
use perifrac::scene::load_str;
use perifrac::schemes::State;

use crate::support::{largest_difference, model, plan_of, run_text, try_run};

/// A column under its own weight, full of water, with a free side.
const COLUMN: &str = r#"title = "Geostatic"
[geometry]
type = "lattice"
size = [10, 40]
spacing = 2.5
[fluid]
viscosity = "1 mPa s"
density = 1000
[materials.rock]
youngs_modulus = "1 GPa"
poissons_ratio = 0.25
density = 2200
biot_coefficient = 0.8
permeability = "1e-13 m^2"
storage = "1e-10 1/Pa"
[gravity]
acceleration = [0, -9.81]
[initial]
k0 = 0.5
pressure = "hydrostatic"
[flow.boundary.top]
pressure = 0
[mechanics.boundary]
left.roller = true
bottom.roller = true
[coupling]
[time]
end = 10
step = 1
[output]
plots = false
"#;

/// A block under uniform stress and pore pressure, with a traction and a free side.
const BLOCK: &str = r#"title = "Uniform"
[geometry]
type = "lattice"
size = [4, 2]
spacing = 0.25
[fluid]
viscosity = "1 cP"
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
density = 2500
biot_coefficient = 0.7
permeability = "1 mD"
storage = "1e-10 1/Pa"
[initial]
stress = { xx = "-4 MPa", yy = "-6 MPa", zz = "-5 MPa" }
pressure = "5 MPa"
[flow.boundary.right]
pressure = "5 MPa"
[mechanics.boundary]
left.roller = true
bottom.roller = true
right.traction = ["-7.5 MPa", 0]
[coupling]
[time]
end = 1
step = 0.1
[output]
plots = false
"#;

const SCHEMES: [&str; 4] = ["monolithic", "staggered", "semi-implicit", "explicit"];

fn most(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Runs ten steps (more where the scheme's own limit asks for them) and gives how far points moved.
fn moved(text: &str, overrides: &[&str]) -> f64 {
    let (summary, state) = run_text(text, overrides);
    assert!(summary.steps >= 10, "{}", summary.steps);
    let plan = plan_of(text, overrides);
    let model = model::<2>(&plan);
    let before = &model.flow.as_ref().unwrap().initial;
    let moved = most(&state.displacement);
    let changed = largest_difference(&state.pressure, before);
    println!(
        "{overrides:?}: u {moved:.1e} m, p {changed:.1e} Pa in {} steps",
        summary.steps
    );
    assert!(
        changed < 1e-9 * most(before),
        "{overrides:?}: {changed:.1e}"
    );
    moved
}

fn message(text: &str, overrides: &[&str]) -> String {
    try_run(&plan_of(text, overrides)).unwrap_err().to_string()
}

/// Released, the column would settle by ρ g H²/(2 M) = 14 mm.
#[test]
fn a_geostatic_column_is_at_rest() {
    for scheme in SCHEMES {
        let scheme = format!("scheme.name={scheme}");
        for other in ["geometry.origin=[0, -40]", "geometry.jitter=0.2"] {
            let moved = moved(COLUMN, &[&scheme, other]);
            assert!(moved < 1e-12 * 0.014, "{scheme} {other}: {moved:.1e}");
        }
    }
}

/// Released, the block would shorten by 2 mm.
#[test]
fn a_uniform_state_is_at_rest_with_tractions_free_sides_and_plates() {
    let others = [
        "mechanics.boundary.top={free = true}",
        "mechanics.boundary.top={traction = [0, \"-9.5 MPa\"]}",
        "mechanics.boundary.top={plate = \"-38 MN\"}",
        "mechanics.boundary.top={normal_displacement = {time = [0, 10, 11], value = [0, 0, 1]}}",
        "geometry.jitter=0.2",
    ];
    for scheme in SCHEMES {
        let scheme = format!("scheme.name={scheme}");
        for other in others {
            let moved = moved(BLOCK, &[&scheme, other]);
            assert!(moved < 1e-12 * 2e-3, "{scheme} {other}: {moved:.1e}");
        }
    }
    for scheme in ["explicit", "semi-implicit"] {
        let scheme = format!("scheme.name={scheme}");
        let set = [&*scheme, "mechanics.mode=dynamic", "time={end = 1e-3}"];
        let moved = moved(BLOCK, &set);
        assert!(moved < 1e-12 * 2e-3, "{scheme}: {moved:.1e}");
    }
}

/// σ_yy goes through the border, σ_xx jumps there.
#[test]
fn regions_of_different_stress_are_at_rest() {
    let region = "initial.regions=[{region = {type = \"half-plane\", point = [0, 1], normal = [0, 1]}, \
                  stress = {xx = \"-4 MPa\", yy = \"-6 MPa\"}}]";
    for scheme in SCHEMES {
        let scheme = format!("scheme.name={scheme}");
        let set = [
            &*scheme,
            region,
            "initial.stress={xx = \"-8 MPa\", yy = \"-6 MPa\"}",
            "mechanics.boundary.right={free = true}",
        ];
        let moved = moved(BLOCK, &set);
        assert!(moved < 1e-12 * 2e-3, "{scheme}: {moved:.1e}");
    }
    let free = "mechanics.boundary.right={free = true}";
    let solid = model::<2>(&plan_of(BLOCK, &[region, free])).solid.unwrap();
    assert_eq!(solid.initial_components[0][..2], [-4e6, -6e6]);
}

/// Two layers, whose weights add up: 10 m of the upper one on half a cell of the lower one.
#[test]
fn k0_follows_the_weight_of_layers() {
    let layer = "materials.lower={youngs_modulus = 1e9, poissons_ratio = 0.25, density = 2600, \
                 biot_coefficient = 0.5, permeability = 1e-13, storage = 1e-10, \
                 region = {type = \"half-plane\", point = [0, 30], normal = [0, 1]}}";
    let solid = model::<2>(&plan_of(COLUMN, &[layer])).solid.unwrap();
    let cloud = &solid.elastic.around.cloud;
    let point = (cloud.position.iter())
        .position(|x| (x[1] - 28.75).abs() < 1e-9)
        .unwrap();
    let total = -9.81 * (2200.0 * 10.0 + 2600.0 * 1.25);
    let vertical = total + 0.5 * 9810.0 * 11.25;
    let expected = [0.5 * vertical, vertical, 0.5 * vertical];
    for (found, expected) in solid.initial_components[point].iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }
    for scheme in ["monolithic", "staggered"] {
        let scheme = format!("scheme.name={scheme}");
        assert!(moved(COLUMN, &[layer, &scheme]) < 1e-14);
    }
}

#[test]
fn a_stress_out_of_equilibrium_is_refused_with_its_size_and_place() {
    let gradient = "initial.stress_gradient={yy = \"-20 kPa/m\"}";
    let told = message(BLOCK, &[gradient, "mechanics.boundary.right={free = true}"]);
    for part in ["leaves 2.000000e4 Pa/m at [", "weighs 0.000000e0 N/m^3"] {
        assert!(told.contains(part), "{told}");
    }
    // Without water the gradient would be ρ g = 21582 Pa/m; α ρ_f g = 7848 Pa/m of it are the water's.
    let dry = "initial={stress_gradient = {yy = \"-21.582 kPa/m\"}, pressure = \"hydrostatic\"}";
    let told = message(COLUMN, &[dry]);
    assert!(told.contains("leaves 7.848000e3 Pa/m"), "{told}");
    let wet = dry.replace("-21.582", "-13.734");
    assert!(moved(COLUMN, &[&wet, "scheme.name=monolithic"]) < 1e-14);
    let total = dry.replace("{stress", "{kind = \"total\", stress");
    assert!(moved(COLUMN, &[&total, "scheme.name=staggered"]) < 1e-14);
}

#[test]
fn a_traction_or_plate_that_differs_from_the_stress_is_refused_with_both() {
    let told = message(
        BLOCK,
        &["mechanics.boundary.right={traction = [\"-7 MPa\", 0]}"],
    );
    for part in ["[-7500000.0, 0.0] Pa on side right", "[-7000000.0, 0.0] Pa"] {
        assert!(told.contains(part), "{told}");
    }
    let told = message(BLOCK, &["mechanics.boundary.top={plate = \"-37 MN\"}"]);
    for part in ["-3.80000000e7 N", "side top", "-3.70000000e7 N"] {
        assert!(told.contains(part), "{told}");
    }
}

/// What is added to an in-situ state does what it does without one, for the problem is linear.
#[test]
fn consolidation_under_a_load_is_the_same_with_and_without_an_in_situ_state() {
    let load = "mechanics.loads.tank={side = \"top\", traction = [0, \"-1 MPa\"]}";
    let roller = "mechanics.boundary.right={roller = true}";
    let light = COLUMN
        .replace("[gravity]\nacceleration = [0, -9.81]\n", "")
        .replace("[initial]\nk0 = 0.5\npressure = \"hydrostatic\"\n", "");
    for scheme in SCHEMES {
        let scheme = format!("scheme.name={scheme}");
        let tight = [
            "scheme.coupling_tolerance=1e-13",
            "scheme.adr_tolerance=1e-13",
            "scheme.adr_iterations=100000",
            "coupling.undrained_start=true",
        ];
        let set = [&[&*scheme, load, roller], &tight[..]].concat();
        let [with, without] = [COLUMN, &light].map(|text| run_text(text, &set).1);
        let apart = largest_difference(&with.displacement, &without.displacement);
        let relative = apart / most(&without.displacement);
        println!(
            "{scheme}: {relative:.1e} of {:.2e} m",
            most(&without.displacement)
        );
        // Passes of the schemes that relax end at their own accuracy.
        let bar = match scheme.contains("plicit") {
            true => 1e-5,
            false => 1e-10,
        };
        assert!(relative < bar, "{scheme}: {relative:.1e}");
    }
}

/// Runs in a folder, with checkpoints.
fn run_in(folder: &Path, overrides: &[&str]) -> State {
    let overrides: Vec<String> = overrides.iter().map(|own| (*own).to_owned()).collect();
    let loaded = load_str("block", BLOCK, Path::new("."), &overrides).unwrap();
    let plan = resolve(&loaded, "block").unwrap();
    let mut writer = Writer::create(folder, &loaded.resolved_toml()).unwrap();
    let interrupt = Interrupt::default();
    let mut observer = ();
    let job = Job {
        writer: Some(&mut writer),
        settings: Settings {
            checkpoints: Some(CheckpointRule::default()),
            ..Settings::default()
        },
        ..Job::new(&mut observer, &interrupt)
    };
    run_job(&plan, job).unwrap().1
}

/// A run that goes on has the in-situ state of the first one, whatever its tractions are by then.
#[test]
fn a_run_that_goes_on_counts_from_the_same_in_situ_state() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, first, second] = ["whole", "first", "second"].map(|name| folder.path().join(name));
    let (quiet, ramp) = (
        "output.vtu=false",
        "mechanics.boundary.right={traction = [{time = [0, 1], value = [\"-7.5 MPa\", \"-6.5 MPa\"]}, 0]}",
    );
    let straight = run_in(&whole, &[quiet, ramp, "time.end=2"]);
    let middle = run_in(&first, &[quiet, ramp]);
    let from = format!("start={{from={:?}}}", first.display().to_string());
    let held = "mechanics.boundary.right={traction = [\"-6.5 MPa\", 0]}";
    let end = run_in(&second, &[quiet, held, &from]);
    assert!(largest_difference(&middle.displacement, &straight.displacement) > 1e-8);
    let apart = largest_difference(&end.displacement, &straight.displacement);
    assert!(apart < 1e-10 * most(&straight.displacement), "{apart:.1e}");
}

/// A cut in rock under stress opens by what its pressure exceeds the stress, and stays shut without a pressure.
#[test]
fn a_crack_in_stressed_rock_feels_the_net_pressure() {
    let text = r#"title = "Crack"
[geometry]
type = "lattice"
size = [1, 1]
points = [20, 20]
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
[mechanics.boundary]
left.roller = true
bottom.roller = true
[cracks.main]
points = [[0.3, 0.5], [0.7, 0.5]]
[time]
mode = "steady"
[output]
plots = false
"#;
    let run = |set: &[&str]| -> (Plan, State) {
        let plan = plan_of(text, set);
        let (_, state) = try_run(&plan).unwrap();
        (plan, state)
    };
    let stress = "initial.stress={xx = \"-10 MPa\", yy = \"-10 MPa\"}";
    let (_, shut) = run(&[stress]);
    assert!(most(&shut.displacement) < 1e-15);
    let (plan, open) = run(&[stress, "cracks.main.pressure=\"12 MPa\""]);
    let (_, net) = run(&["cracks.main.pressure=\"2 MPa\""]);
    let apart = largest_difference(&open.displacement, &net.displacement);
    assert!(apart < 1e-10 * most(&net.displacement), "{apart:.1e}");
    let jumps = openings(&model::<2>(&plan), &open, 0);
    assert!(jumps.iter().all(|jump| jump[0] > 0.0));
}

/// Rock that bears 1 MPa or so, alone.
const BREAKABLE: &str = r#"title = "Breakable"
[geometry]
type = "lattice"
size = [1, 1]
points = [12, 12]
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.25
fracture_energy = "100 J/m^2"
[initial]
stress = { xx = "-10 MPa", yy = "-12 MPa" }
[mechanics.boundary]
left.roller = true
bottom.roller = true
[damage]
length_scale = "0.3 m"
[time]
end = 1
step = 0.1
[output]
plots = false
"#;

/// Damage under an in-situ stress has nothing to do, and as little without any other force.
#[test]
fn stressed_rock_that_may_break_is_at_rest() {
    for scheme in ["implicit", "explicit"] {
        let (_, state) = run_text(BREAKABLE, &[&format!("scheme.name={scheme}")]);
        let moved = most(&state.displacement);
        println!("{scheme}: {moved:.1e}");
        assert!(moved < 1e-12 * 1e-3, "{scheme}: {moved:.1e}");
    }
}

/// A compression of 10 MPa that was typed with the wrong sign.
#[test]
fn a_tension_that_breaks_the_rock_is_refused_with_its_strength() {
    let told = message(
        BREAKABLE,
        &["initial.stress={xx = \"10 MPa\", yy = \"-12 MPa\"}"],
    );
    assert!(
        told.contains("would be broken before anything happens") && told.contains("1.0000e7"),
        "{told}"
    );
    // Below the strength it may pull.
    run_text(
        BREAKABLE,
        &["initial.stress={xx = \"0.5 MPa\", yy = \"-12 MPa\"}"],
    );
}
