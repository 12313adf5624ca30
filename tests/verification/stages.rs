//! Runs that start from the state that another one left.

use std::path::Path;

use perifrac::plan::{Plan, resolve};
use perifrac::run::{CheckpointRule, Interrupt, Job, RunError, Settings, Summary, Writer, run_job};
use perifrac::scene::{LoadedScene, load_str};
use perifrac::schemes::State;

/// A square, squeezed by tractions, whose pores drain to the right.
pub const SQUARE: &str = r#"
title = "Square"
[geometry]
type = "lattice"
size = [1, 1]
points = [8, 8]
[fluid]
viscosity = "1 mPa s"
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.25
permeability = "1e-15 m^2"
storage = "1e-10 1/Pa"
biot_coefficient = 1
fracture_energy = "100 J/m^2"
[mechanics.boundary.left]
roller = true
[mechanics.boundary.bottom]
roller = true
[mechanics.loads.side]
side = "right"
traction = ["-3 MPa", 0]
[mechanics.loads.top]
side = "top"
traction = [0, "-2 MPa"]
[flow.boundary.right]
pressure = 0
[coupling]
[scheme]
name = "monolithic"
[time]
end = "20 s"
[output]
plots = false
vtu = false
"#;

fn loaded(text: &str, overrides: &[String]) -> LoadedScene {
    load_str("square", text, Path::new("."), overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn set(keys: &[&str]) -> Vec<String> {
    keys.iter().map(|key| (*key).to_owned()).collect()
}

fn run_in(folder: &Path, overrides: &[String]) -> Result<(Plan, Summary, State), RunError> {
    run_text_in(folder, SQUARE, overrides)
}

fn run_text_in(
    folder: &Path,
    text: &str,
    overrides: &[String],
) -> Result<(Plan, Summary, State), RunError> {
    let loaded = loaded(text, overrides);
    let plan = resolve(&loaded, "square").unwrap_or_else(|e| panic!("{e}"));
    let mut writer = Writer::create(folder, &loaded.resolved_toml())?;
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
    let (summary, state) = run_job(&plan, job)?;
    Ok((plan, summary, state))
}

fn start(folder: &Path, keys: &[&str]) -> Vec<String> {
    let from = format!("start={{from={:?}}}", folder.display().to_string());
    let mut all = vec![from];
    all.extend(set(keys));
    all
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(f64::MIN_POSITIVE, |m, v| v.abs().max(m));
    let pairs = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    pairs.fold(0.0, f64::max) / largest
}

/// A run to 20 s is the same as one to 5 s and another from there, within the error of the steps; with the clock
/// that goes on as with one that begins anew.
#[test]
fn a_consolidation_in_two_parts_is_the_one_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, first, kept, reset] =
        ["whole", "first", "kept", "reset"].map(|name| folder.path().join(name));
    let fine = "time.tolerance=1e-7";
    let (_, _, straight) = run_in(&whole, &set(&[fine])).unwrap();
    run_in(&first, &set(&[fine, "time.end=5 s"])).unwrap();
    let keys = start(&first, &[fine, "start.clock=keep"]);
    let (_, summary, state) = run_in(&kept, &keys).unwrap();
    assert!(apart(&state.pressure, &straight.pressure) < 1e-5);
    assert!(apart(&state.displacement, &straight.displacement) < 1e-6);
    assert_eq!((state.time, summary.t_end), (20.0, 20.0));
    let keys = start(&first, &[fine, "time.end=15 s"]);
    let (_, _, state) = run_in(&reset, &keys).unwrap();
    assert!(apart(&state.pressure, &straight.pressure) < 1e-5);
    assert!(summary.balance.mass < 1e-9 && summary.balance.stored < 0.0);
}

/// Drained strain by hand: ε_x = (1 + ν)/E ((1 − ν) σ_x − ν σ_y) = 1.25e-10 (−2.25 + 0.5) MPa. Counted from
/// there, what follows is the change alone, and the stress is that of both.
#[test]
fn displacement_that_is_reset_counts_from_the_state_taken_over_and_keeps_its_stress() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let (_, _, drained) = run_in(&first, &set(&["time.end=1 h"])).unwrap();
    let corner = 2 * 63;
    let exact = 1.25e-10 * (-2.25e6 + 0.5e6) * (1.0 - 0.5 / 8.0);
    assert!((drained.displacement[corner] / exact - 1.0).abs() < 1e-6);
    let keys = start(
        &first,
        &[
            "start.displacement=reset",
            "time.end=1 h",
            "mechanics.loads.side.traction=[\"-6 MPa\", 0]",
        ],
    );
    let (_, summary, state) = run_in(&second, &keys).unwrap();
    let change = 1.25e-10 * 0.75 * -3e6 * (1.0 - 0.5 / 8.0);
    let shown = state.shown_displacement();
    assert!(
        (shown[corner] / change - 1.0).abs() < 1e-6,
        "{}",
        shown[corner]
    );
    assert!(summary.balance.momentum.unwrap() < 1e-9);
}

/// Rock that is squeezed before damage is switched on is not broken by that.
#[test]
fn damage_that_is_switched_on_in_compressed_rock_breaks_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    run_in(&first, &set(&["time.end=1 h"])).unwrap();
    let keys = start(
        &first,
        &[
            "damage={model=\"paper\", length_scale=0.5}",
            "fracture_flow={}",
            "flow.operator=bond",
            "coupling.undrained_start=false",
            "time.end=10 s",
        ],
    );
    let (plan, _, state) = run_in(&second, &keys).unwrap();
    let model = crate::support::model::<2>(&plan);
    let damage = model.solid.as_ref().unwrap().damage.as_ref().unwrap();
    let most = damage.of(&state.history).into_iter().fold(0.0, f64::max);
    assert!(most < 1e-6, "{most}");
    // Nor is what broke forgotten.
    let error = run_in(
        &folder.path().join("third"),
        &start(&second, &["time.end=1 s"]),
    );
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("damage") && error.contains("[damage]"),
        "{error}"
    );
}

/// The square without fluid, under its loads alone.
const DRY: &[&str] = &["time.end=1e-3 s", "materials.rock.density=2500"];

/// Waves take 4e-4 s through the square, so that at 1e-3 s nothing is at rest.
#[test]
fn rock_that_moves_is_not_stopped_untold() {
    let dry = SQUARE.split("[coupling]").next().unwrap();
    let (head, _) = dry.split_once("[flow.boundary.right]").unwrap();
    let text = |mode: &str| {
        let scheme = if mode == "dynamic" {
            "explicit"
        } else {
            "implicit"
        };
        format!(
            "{head}[mechanics]\nmode = \"{mode}\"\n[scheme]\nname = \"{scheme}\"\n[time]\nend = \"1 ms\"\n\
             [output]\nplots = false\nvtu = false\n"
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let [moving, still] = ["moving", "still"].map(|name| folder.path().join(name));
    let (dynamic, rest) = (text("dynamic"), text("quasi-static"));
    run_text_in(&moving, &dynamic, &set(DRY)).unwrap();
    run_text_in(&still, &rest, &set(DRY)).unwrap();
    let second = folder.path().join("second");
    let error = run_text_in(&second, &rest, &start(&moving, DRY)).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("its rock moves"), "{error}");
    assert!(error.contains("mechanics.mode = \"dynamic\""), "{error}");
    let (_, summary, _) = run_text_in(&second, &dynamic, &start(&still, DRY)).unwrap();
    let told = summary.warnings.join("\n");
    assert!(told.contains("starts at rest"), "{told}");
    // With inertia on both sides there is nothing to tell.
    let (_, summary, _) = run_text_in(&second, &dynamic, &start(&moving, DRY)).unwrap();
    let told = summary.warnings.join("\n");
    assert!(!told.contains("inertia"), "{told}");
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    run_in(&first, &set(&["time.end=1 s"])).unwrap();
    let refused = |from: &Path, keys: &[&str]| {
        let error = run_in(&second, &start(from, keys)).unwrap_err();
        error.to_string()
    };
    for (keys, expected) in [
        (
            &["geometry.points=[9, 9]"][..],
            "it has 64 points, and now there are 81",
        ),
        (&["geometry.size=[1, 2]"], "its points lie elsewhere"),
        (
            &["start.clock=keep", "time.end=0.5 s"],
            "it ends at t = 1e0 s",
        ),
    ] {
        let message = refused(&first, keys);
        assert!(message.contains(expected), "{message}");
    }
    let message = refused(&folder.path().join("nowhere"), &[]);
    assert!(message.contains("nowhere"), "{message}");
    let message = refused(folder.path(), &[]);
    assert!(message.contains("has no checkpoint"), "{message}");
}

/// Pumped, then shut in: the crack keeps its fluid, where it is and at its pressure, in rock that lets nothing in.
#[test]
fn a_crack_that_is_shut_in_keeps_what_was_pumped_in() {
    let text = perifrac::cases::find("kgd-toughness").unwrap().scene;
    let folder = tempfile::tempdir().unwrap();
    let [pumped, shut] = ["pumped", "shut"].map(|name| folder.path().join(name));
    let coarse = ["geometry.spacing=12.5 cm", "output.plots=false"];
    let run = |folder: &Path, overrides: &[String]| {
        let (_, summary, state) = run_text_in(folder, text, overrides).unwrap();
        (summary, state)
    };
    let held = |summary: &Summary| summary.results.as_ref().unwrap().crack_volume.unwrap();
    let (before, then) = run(&pumped, &set(&[coarse[0], coarse[1], "time.end=1.5 s"]));
    // A quarter of 1e-4 m²/s.
    assert!((held(&before) / (2.5e-5 * 1.5) - 1.0).abs() < 1e-5);
    let rate = "cracks.main.injection.rate=\"0 m^2/s\"";
    let keys = start(&pumped, &[coarse[0], coarse[1], rate, "time.end=1 s"]);
    let (after, now) = run(&shut, &keys);
    let change = held(&after) / held(&before) - 1.0;
    assert!(change.abs() < 1e-5, "{change}");
    // What the last step had not broken yet breaks, and no more.
    let length = |summary: &Summary| summary.results.as_ref().unwrap().crack_length;
    assert!(length(&after) - length(&before) < 0.0625);
    let drop = 1.0 - now.pressure[0] / then.pressure[0];
    assert!((0.0..0.1).contains(&drop), "{drop}");
    // At rest a pass leaves nothing to do for the next; what still breaks cuts the first step (13 times).
    assert!(after.rejected <= 20, "{}", after.rejected);
    assert!(after.counters.coupling_iterations < 600);
}
