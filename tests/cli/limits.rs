//! What is too large: clouds, memory, threads; and arrays of another shape than the cloud.

use assert_cmd::Command;

use crate::support::Place;

/// Code and standard error of a command.
fn told(command: &mut Command) -> (Option<i32>, String) {
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), text)
}

/// A billion points with fifteen bonds each are more than 32 bits can number; nothing of them is made,
/// so that 6 GiB of address space are plenty.
#[cfg(unix)]
#[test]
fn a_billion_points_are_refused_without_being_made() {
    let place = Place::with_scene(&[("points = [8, 8]", "points = [31623, 31623]")]);
    for verb in ["check", "plan", "run"] {
        let mut shell = Command::new("sh");
        let program = env!("CARGO_BIN_EXE_perifrac");
        let text = format!("ulimit -v 6291456; exec '{program}' {verb} scene.toml --out out");
        let text = if verb == "run" {
            text
        } else {
            text.replace(" --out out", "")
        };
        let (code, stderr) = told(shell.args(["-c", &text]).current_dir(place.path(".")));
        assert_eq!(code, Some(3), "{verb}: {stderr}");
        assert!(
            stderr.contains("32-bit indices can number"),
            "{verb}: {stderr}"
        );
    }
    assert!(place.list("out").is_empty());
}

/// Two and a half hundred million points: a run would need some hundred gigabytes.
#[test]
fn a_large_cloud_is_judged_by_estimates() {
    let place = Place::with_scene(&[("points = [8, 8]", "points = [16000, 15625]")]);
    let said = place.succeed(&["check", "scene.toml"]);
    assert!(
        said.contains("no faults found (250000000 points, by estimates"),
        "{said}"
    );
    let text = place.succeed(&["plan", "scene.toml", "--json"]);
    let plan: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(plan["points"], 250_000_000);
    assert_eq!(plan["estimated"], true);
    let bonds = plan["bonds"].as_f64().unwrap() / 250e6;
    assert!((7.0..9.0).contains(&bonds), "{bonds} bonds a point");
    assert!(
        plan["memory"]["total"].as_f64().unwrap() > 5e10,
        "{}",
        plan["memory"]
    );
}

/// The estimate of a cloud that is not made against that of one that is, a third finer.
#[test]
fn estimates_go_on_where_clouds_are_no_longer_made() {
    let plan = |points: &str| -> serde_json::Value {
        let place = Place::with_scene(&[("points = [8, 8]", points)]);
        serde_json::from_str(&place.succeed(&["plan", "scene.toml", "--json"])).unwrap()
    };
    let (made, estimated) = (plan("points = [520, 520]"), plan("points = [600, 600]"));
    assert_eq!(
        (&made["estimated"], &estimated["estimated"]),
        (&false.into(), &true.into())
    );
    let ratio = |of: &dyn Fn(&serde_json::Value) -> f64| of(&estimated) / of(&made);
    let finer: f64 = 600.0 / 520.0;
    let memory = ratio(&|plan| plan["memory"]["total"].as_f64().unwrap());
    assert!((memory / finer.powi(2) - 1.0).abs() < 0.1, "{memory}");
    let step = ratio(&|plan| plan["limits"][0]["dt"].as_f64().unwrap());
    assert!((step * finer.powi(2) - 1.0).abs() < 1e-3, "{step}");
    for key in ["spacing", "horizon"] {
        let length = ratio(&|plan| plan[key][0].as_f64().unwrap());
        assert!((length * finer - 1.0).abs() < 1e-3, "{key}: {length}");
    }
}

#[test]
fn a_run_that_needs_more_memory_than_allowed_is_refused_with_what_it_needs() {
    let place = Place::with_scene(&[("points = [8, 8]", "points = [80, 80]")]);
    let run = |size: &str| place.run(&["run", "scene.toml", "--memory", size]);
    let refused = run("1MB");
    assert_eq!(refused.code, Some(1), "{refused:?}");
    for words in [
        "the run needs about",
        "1.0 MB are free (--memory)",
        "--memory SIZE",
        "coarser",
    ] {
        assert!(refused.stderr.contains(words), "{words}: {refused:?}");
    }
    assert!(place.list("out").is_empty());
    assert_eq!(run("1GiB").code, Some(0));
    assert_eq!(run("plenty").code, Some(2));
}

#[test]
fn more_threads_than_a_system_bears_are_refused() {
    let place = Place::with_scene(&[]);
    let mut asked = place.program(&["run", "scene.toml", "--threads", "99999999"]);
    let (code, stderr) = told(&mut asked);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("--threads 99999999: at most"), "{stderr}");
    let mut set = place.program(&["check", "scene.toml"]);
    let (code, stderr) = told(set.env("RAYON_NUM_THREADS", "99999999"));
    assert_eq!(code, Some(2), "{stderr}");
    assert!(
        stderr.contains("RAYON_NUM_THREADS=99999999: at most"),
        "{stderr}"
    );
}

#[test]
fn thousands_of_faulty_materials_end_with_the_first_hundred() {
    let place = Place::with_scene(&[]);
    let bad = (0..5000).map(|k| format!("[materials.m{k}]\npermeability = \"1 mPa\"\n"));
    let scene = String::from_utf8(place.read("scene.toml")).unwrap() + &bad.collect::<String>();
    place.write("scene.toml", scene);
    let outcome = place.run(&["check", "scene.toml"]);
    assert_eq!(outcome.code, Some(3));
    assert!(outcome.stderr.matches("found a pressure").count() <= 100);
    assert!(
        outcome.stderr.contains("errors in scene.toml"),
        "{}",
        outcome.stderr
    );
}

/// An array of doubles as NumPy saves it.
fn npy(shape: &str, values: &[f64]) -> Vec<u8> {
    let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = u16::try_from(head.len()).unwrap().to_le_bytes();
    let values: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    [b"\x93NUMPY\x01\x00", &length[..], head.as_bytes(), &values].concat()
}

/// Eight columns of four rows, of which the second row from below is tight: along x three rows of
/// 1 m each conduct κ Δp/L = 1e-9 · 1e6/8 m/s, together 3.75e-4 m²/s (read the other way round, the
/// tight points would be spread over all rows).
#[test]
fn an_array_of_the_shape_of_the_lattice_is_indexed_by_x_first() {
    let place = Place::with_scene(&[
        ("size = [1, 1]", "size = [8, 4]"),
        ("points = [8, 8]", "points = [8, 4]"),
        ("\"1 mD\"", "{ file = \"k.npy\" }"),
        ("end = \"100 s\"", "mode = \"steady\""),
    ]);
    let value = |row: usize| if row == 1 { 1e-18 } else { 1e-12 };
    let by_x: Vec<f64> = (0..8).flat_map(|_| (0..4).map(value)).collect();
    let by_y: Vec<f64> = (0..4).flat_map(|row| [value(row); 8]).collect();
    for (shape, values) in [("(8, 4)", &by_x), ("(32,)", &by_y)] {
        place.write("k.npy", npy(shape, values));
        let text = place.succeed(&[
            "run",
            "scene.toml",
            "--json",
            "--quiet",
            "--set",
            "flow.operator=bond",
        ]);
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        let outflow = summary["outflow"]["right"].as_f64().unwrap();
        // Bonds into the tight row are lost to its neighbours: a fifth, where the other order leaves nothing.
        assert!((outflow / 3.75e-4 - 1.0).abs() < 0.25, "{shape}: {outflow}");
    }
    place.write("k.npy", npy("(4, 8)", &by_y));
    for verb in ["check", "plan", "run"] {
        let refused = place.run(&[verb, "scene.toml"]);
        assert_eq!(refused.code, Some(3), "{refused:?}");
        assert!(
            refused.stderr.contains("shape (4, 8) for a grid of 8 × 4"),
            "{refused:?}"
        );
    }
}
