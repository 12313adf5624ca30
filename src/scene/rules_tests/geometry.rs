//! Rules of the domain, the horizon and shapes.

use super::{SOUND, broken, check, faults};

#[test]
fn geometry_rules() {
    check(&[
        (
            "size = [\"2 m\"",
            "size = [\"-2 m\"",
            "`size` must be positive",
            "\"-2 m\"",
        ),
        (
            "points = [40, 20]",
            "points = [40]",
            "`points` needs 2 components, found 1",
            "[40]",
        ),
        (
            "points = [40, 20]",
            "points = [40, 0]",
            "`points` must be at least 1, found 0",
            "0",
        ),
        (
            "points = [40, 20]",
            "",
            "a lattice needs `points` or `spacing`",
            "[geometry]",
        ),
        (
            "seed = 3",
            "spacing = 0.1",
            "`points` excludes `spacing`",
            "0.1",
        ),
        (
            "points = [40, 20]",
            "spacing = \"0.3 m\"",
            "`spacing` must divide `size`, found 6.667 cells",
            "\"0.3 m\"",
        ),
        (
            "points = [40, 20]",
            "spacing = 0",
            "`spacing` must be positive",
            "0",
        ),
        (
            "seed = 3",
            "thickness = \"-1 mm\"",
            "`thickness` must be positive",
            "\"-1 mm\"",
        ),
        (
            "jitter = 0.1",
            "jitter = 0.5",
            "`jitter` must lie between 0 and 0.4, found 0.5",
            "0.5",
        ),
        (
            "origin = [0, 0]",
            "origin = [0]",
            "`origin` needs 2 components, found 1",
            "[0]",
        ),
        (
            "type = \"lattice\"",
            "type = \"latice\"",
            "`latice` is not known here",
            "\"latice\"",
        ),
        ("type = \"lattice\"", "", "`type` is missing", "[geometry]"),
    ]);
    let line = broken("[\"2 m\", \"1 m\"]", "[1]");
    assert!(line.contains(&(
        "`size` needs 2 or 3 components, found 1".into(),
        "[1]".into()
    )));
}

/// The sound scene with another geometry.
fn with_geometry(geometry: &str) -> Vec<(String, String)> {
    let start = SOUND.find("type = \"lattice\"").unwrap();
    let end = SOUND.find("[horizon]").unwrap();
    faults(
        &format!("{}{geometry}\n{}", &SOUND[..start], &SOUND[end..]),
        &[],
    )
}

#[test]
fn graded_rules() {
    let sound = "type = 'graded'\naxes = [[{length = 1, spacing = [0.1, 0.05]}, {length = 1, \
                 spacing = 0.05}], [{length = '1 m', spacing = 0.1}]]";
    assert_eq!(with_geometry(sound), []);
    let table = [
        (
            "spacing = [0.1, 0.05]",
            "spacing = [0.1, 0]",
            "`spacing` must be positive",
            "0",
        ),
        (
            "length = '1 m'",
            "length = '5 cm'",
            "`spacing` is longer than its segment",
            "0.1",
        ),
        (
            ", [{length = '1 m', spacing = 0.1}]",
            ", []",
            "an axis needs at least one segment",
            "[]",
        ),
        (
            "spacing = [0.1, 0.05]",
            "spacing = {}",
            "expected a value or a list, found a table",
            "{}",
        ),
    ];
    for (from, to, message, excerpt) in table {
        assert!(sound.contains(from), "{from}");
        let found = with_geometry(&sound.replacen(from, to, 1));
        assert!(
            found.contains(&(message.to_owned(), excerpt.to_owned())),
            "{found:?}"
        );
    }
}

#[test]
fn blocks_rules() {
    let sound = "type = 'blocks'\nsize = [2, 1]\nspacing = 0.1\nrefine = [{levels = 2, region = \
                 {type = 'ball', centre = [1, 0.5], radius = 0.2}}]";
    assert_eq!(with_geometry(sound), []);
    let table = [
        (
            "levels = 2",
            "levels = 0",
            "`levels` must lie between 1 and 12, found 0",
            "0",
        ),
        (
            "radius = 0.2",
            "radius = 0",
            "`radius` must be positive",
            "0",
        ),
        (
            "centre = [1, 0.5]",
            "centre = [1]",
            "`centre` needs 2 components, found 1",
            "[1]",
        ),
        (
            "spacing = 0.1",
            "spacing = 0.7",
            "`spacing` must divide `size`, found 2.857 cells",
            "0.7",
        ),
    ];
    for (from, to, message, excerpt) in table {
        let found = with_geometry(&sound.replacen(from, to, 1));
        assert!(
            found.contains(&(message.to_owned(), excerpt.to_owned())),
            "{found:?}"
        );
    }
}

#[test]
fn point_file_rules() {
    let sound = "type = 'file'\npath = 'points.csv'\nbounds = {min = [0, 0], max = [2, 1]}";
    assert_eq!(with_geometry(sound), []);
    assert_eq!(with_geometry("type = 'file'\npath = 'points.VTU'"), []);
    let table = [
        (
            "'points.csv'",
            "'points.txt'",
            "`path` must be a file ending in `csv` or `vtu`",
        ),
        (
            "[2, 1]",
            "[2, 0]",
            "`max` must be greater than `min` along every axis",
        ),
        ("[2, 1]", "[2, 1, 1]", "`max` needs 2 components, found 3"),
    ];
    for (from, to, message) in table {
        let found = with_geometry(&sound.replacen(from, to, 1));
        assert_eq!(found[0].0, message, "{found:?}");
    }
}

#[test]
fn horizon_rules() {
    check(&[
        (
            "ratio = 2.3",
            "ratio = 0.5",
            "`ratio` must lie between 1 and 10, found 0.5",
            "0.5",
        ),
        (
            "ratio = 2.3",
            "radius = 0",
            "`radius` must be positive",
            "0",
        ),
        (
            "ratio = 2.3",
            "neighbours = 2",
            "`neighbours` must lie between 3 and 500, found 2",
            "2",
        ),
        (
            "ratio = 2.3",
            "ratio = 2\nradius = 0.2",
            "`radius` excludes `ratio`",
            "2",
        ),
        (
            "ratio = 2.3",
            "neigbours = 9",
            "unknown key `neigbours`",
            "neigbours",
        ),
        (
            "\"inverse\"",
            "\"inverse-cube\"",
            "`inverse-cube` is not known here",
            "\"inverse-cube\"",
        ),
    ]);
}

#[test]
fn shape_rules() {
    let region = "{ type = \"box\", min = [\"0.5 m\", 0], max = [\"1 m\", 1] }";
    check(&[
        (
            region,
            "{ type = \"box\", min = [1, 0], max = [1, 1] }",
            "`max` must be greater than `min` along every axis",
            "[1, 1]",
        ),
        (
            region,
            "{ type = \"box\", min = [0, 0, 0], max = [1, 1] }",
            "`min` needs 2 components, found 3",
            "[0, 0, 0]",
        ),
        (
            region,
            "{ type = \"polygon\", vertices = [[0, 0], [1, 1]] }",
            "a polygon needs at least three `vertices`",
            "[[0, 0], [1, 1]]",
        ),
        (
            region,
            "{ type = \"half-plane\", point = [0, 0], normal = [0, 0] }",
            "`normal` must not be zero",
            "[0, 0]",
        ),
        (
            region,
            "{ type = \"box\", min = [0, 0], mxa = [1, 1] }",
            "unknown key `mxa`",
            "mxa",
        ),
    ]);
}
