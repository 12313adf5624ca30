//! The same scene again: in the same folder, from its resolved text, with other threads.

use crate::support::Place;

/// The files of two folders that must agree to the last bit.
fn assert_same_results(place: &Place, first: &str, second: &str) {
    let names = place.list(first);
    assert_eq!(names, place.list(second));
    assert!(names.iter().any(|name| name.ends_with(".vtu")), "{names:?}");
    for name in names
        .iter()
        .filter(|name| name.ends_with(".vtu") || name.ends_with(".csv"))
    {
        let [a, b] = [first, second].map(|folder| place.read(&format!("{folder}/{name}")));
        assert!(a == b, "{name} of {first} and {second} differ");
    }
}

#[test]
fn a_run_in_the_same_folder_replaces_the_results() {
    let place = Place::with_scene(&[]);
    let times = "output.times=[\"20 s\", \"50 s\"]";
    place.succeed(&["run", "scene.toml", "--out", "again", "--set", times]);
    assert!(place.list("again").contains(&"fields-0003.vtu".to_owned()));
    place.succeed(&["run", "scene.toml", "--out", "again"]);
    place.succeed(&["run", "scene.toml", "--out", "fresh"]);
    assert_same_results(&place, "again", "fresh");
}

#[test]
fn the_resolved_scene_gives_the_same_bits() {
    let place = Place::with_scene(&[("[8, 8]", "[8, 8]\njitter = 0.2\nseed = 3")]);
    let sets = [
        "--set",
        "fluid.viscosity=2 cP",
        "--set",
        "time.tolerance=1e-4",
    ];
    let arguments = [
        &["run", "scene.toml", "--out", "first", "--solver", "faer-cg"][..],
        &sets,
    ];
    place.succeed(&arguments.concat());
    place.succeed(&["run", "first/resolved.toml", "--out", "second"]);
    assert_same_results(&place, "first", "second");
    assert_eq!(
        place.read("first/resolved.toml"),
        place.read("second/resolved.toml")
    );
}

/// Enough points that the work is shared out among threads.
fn compare_threads(arguments: &[&str]) {
    let random = "{ distribution = \"log-normal\", median = \"1 mD\", log10_std = 1, seed = 5 }";
    let place = Place::with_scene(&[("[8, 8]", "[64, 64]"), ("\"1 mD\"", random)]);
    for threads in ["1", "2", "3"] {
        let fixed = ["run", "scene.toml", "--threads", threads, "--out", threads];
        place.succeed(&[&fixed, arguments].concat());
    }
    assert_same_results(&place, "1", "2");
    assert_same_results(&place, "1", "3");
}

#[test]
fn implicit_steps_do_not_depend_on_the_number_of_threads() {
    for solver in ["faer-llt", "faer-cg"] {
        compare_threads(&["--solver", solver, "--set", "time.step=20 s"]);
    }
}

#[test]
fn explicit_steps_do_not_depend_on_the_number_of_threads() {
    compare_threads(&["--scheme", "explicit", "--set", "time.end=0.02 s"]);
}
