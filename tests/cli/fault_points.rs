//! Points that are not where the scene thinks they are.

use crate::support::Place;

/// Cell centres of 8 × 8 cells over the unit square.
fn points() -> String {
    let place = |k: usize| (k as f64 + 0.5) / 8.0;
    let line = |k: usize| format!("{},{},{}\n", place(k % 8), place(k / 8), 1.0 / 64.0);
    "x,y,volume\n".to_owned() + &(0..64).map(line).collect::<String>()
}

fn scene(bounds: &str) -> Place {
    let geometry = format!("path = \"points.csv\"\nbounds = {bounds}");
    let place = Place::with_scene(&[
        ("\"lattice\"", "\"file\""),
        ("size = [1, 1]\npoints = [8, 8]", &geometry),
    ]);
    place.write("points.csv", points());
    place
}

const VERBS: [&[&str]; 3] = [
    &["check", "scene.toml"],
    &["plan", "scene.toml"],
    &["run", "scene.toml", "--out", "out"],
];

#[test]
fn bounds_that_no_point_reaches_are_refused_by_every_verb_alike() {
    let place = scene("{ min = [0, 0], max = [1.3, 1] }");
    let told: Vec<String> = VERBS
        .iter()
        .map(|arguments| {
            let outcome = place.run(arguments);
            assert_eq!(outcome.code, Some(3), "{arguments:?}: {outcome:?}");
            outcome.stderr
        })
        .collect();
    assert!(
        told[0].starts_with(
            "error: points.csv: no point reaches side right at 1.300000 m: the nearest, at \
             [0.9375, 0.0625], is 2.9 spacings away"
        ),
        "{}",
        told[0]
    );
    assert!(told.iter().all(|text| *text == told[0]), "{told:?}");
    assert!(!place.path("out/fields.pvd").exists());
    let sound = scene("{ min = [0, 0], max = [1, 1] }");
    for arguments in VERBS {
        sound.succeed(arguments);
    }
}

#[test]
fn probes_where_no_point_is_are_refused_by_every_verb_alike() {
    let place = scene("{ min = [0, 0], max = [1, 1] }");
    let hole = |line: &&str| {
        let numbers: Vec<f64> = line.split(',').filter_map(|n| n.parse().ok()).collect();
        numbers.is_empty() || (numbers[0] - 0.5).hypot(numbers[1] - 0.5) > 0.3
    };
    let text = points();
    let kept: Vec<&str> = text.lines().filter(hole).collect();
    place.write("points.csv", kept.join("\n"));
    let set = ["--set", "output.probes.centre.at=[0.5, 0.5]"];
    for arguments in VERBS {
        let outcome = place.run(&[arguments, &set].concat());
        assert_eq!(outcome.code, Some(3), "{outcome:?}");
        let said = "error: output.probes.centre: no point is near [0.5, 0.5]";
        assert!(outcome.stderr.starts_with(said), "{}", outcome.stderr);
    }
}
