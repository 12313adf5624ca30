#![allow(clippy::float_cmp)]
use super::*;

fn points(text: &str) -> Result<PointTable, FileError> {
    read_points(Path::new("points.csv"), text.as_bytes())
}

fn permeability(text: &str, column: Option<&str>) -> Result<Vec<f64>, FileError> {
    read_field(
        Path::new("k.csv"),
        text.as_bytes(),
        column,
        Property::PERMEABILITY,
    )
}

#[track_caller]
fn fails(result: Result<PointTable, FileError>, parts: &[&str]) {
    let message = result.unwrap_err().to_string();
    for part in parts.iter().chain(&["points.csv"]) {
        assert!(message.contains(part), "`{part}` not in: {message}");
    }
}

#[test]
fn columns_are_found_by_name_in_any_order() {
    let text = "\u{feff}# made by hand\r\nvolume_m2 , note, y,material,x_m,permeability_m2\r\n\r\n\
                0.5, first, 2, sand stone , 1, 1e-15\r\n  # between\r\n0.25,,-4,clay,+3e0,2e-15";
    let table = points(text).unwrap();
    assert_eq!(table.dimension, 2);
    assert_eq!(table.position, [1.0, 2.0, 3.0, -4.0]);
    assert_eq!(table.volume, [0.5, 0.25]);
    assert_eq!(table.material.unwrap(), ["sand stone", "clay"]);
    assert_eq!(table.permeability.unwrap(), [1e-15, 2e-15]);
}

#[test]
fn a_column_z_makes_space_and_cubic_metres() {
    let table = points("z,x,y,volume_m3\n3,1,2,8\n").unwrap();
    assert_eq!((table.dimension, table.position), (3, vec![1.0, 2.0, 3.0]));
    assert_eq!((table.material, table.permeability), (None, None));
    fails(
        points("z,x,y,volume_m2\n3,1,2,8\n"),
        &["`volume_m2`", "`volume_m3`"],
    );
    fails(
        points("x,y,volume_m3\n1,2,8\n"),
        &["`volume_m3`", "`volume_m2`"],
    );
    fails(points("x_mm,y,volume\n1,2,8\n"), &["`x_mm`", "`x_m`"]);
}

#[test]
fn missing_and_doubled_columns_name_the_columns_found() {
    fails(
        points("x,vol,volumes\n1,2,3\n"),
        &["`y`, `volume`", "`x`, `vol`, `volumes`"],
    );
    fails(
        points("X,Y,Volume\n1,2,3\n"),
        &["`X` for `x`", "`Volume` for `volume`"],
    );
    fails(points("x;y;volume\n1;2;3\n"), &["by commas"]);
    fails(
        points("x,y,x,volume\n1,2,3,4\n"),
        &["`x`", "remove or rename"],
    );
    fails(points("x,y,y_m,volume\n1,2,3,4\n"), &["`y`", "`y_m`"]);
    fails(points("0,0,1\n1,0,1\n"), &["line 1", "header"]);
}

#[test]
fn faults_are_reported_with_the_line_of_the_file() {
    let head = "# one\n\nx,y,volume\n# two\n0,0,1\n";
    fails(
        points(&format!("{head}\n# three\n1,0\n")),
        &["line 8", "2 values", "3 columns"],
    );
    fails(points(&format!("{head}1,0,1,\n")), &["line 6", "4 values"]);
    fails(
        points(&format!("{head}1,o,1\n")),
        &["line 6", "`o`", "`y`", "no number"],
    );
    fails(
        points(&format!("{head}1,,1\n")),
        &["line 6", "`y` is empty"],
    );
    fails(points(&format!("{head}1,\"0,1\n2,0,1\n")), &["line 6"]);
}

#[test]
fn bad_values_are_counted_and_the_first_is_shown() {
    let head = "x,y,volume,permeability\n0,0,1,1e-15\n";
    fails(
        points(&format!("{head}#\n1,0,-0.5,1\n2,0,0,1\n")),
        &["line 4", "volume is -0.5", "2 of 3", "not positive"],
    );
    fails(
        points(&format!("{head}1,0,1,NaN\n")),
        &["line 3", "permeability is NaN", "1 of 2"],
    );
    fails(
        points(&format!("{head}nan,0,1,1\n")),
        &["line 3", "x is NaN", "not a number"],
    );
    fails(
        points(&format!("{head}1,1e999,1,1\n")),
        &["line 3", "y is inf", "not finite"],
    );
    fails(
        points(&format!("{head}1,0,1,0\n")),
        &["line 3", "permeability is 0.0"],
    );
}

#[test]
fn a_table_without_rows_is_refused() {
    for text in [
        "",
        "\n\n",
        "# only\n",
        "x,y,volume\n",
        "x,y,volume\n# none\n\n",
    ] {
        let error = points(text).unwrap_err();
        assert!(
            matches!(error, FileError::Empty { what: "points", .. }),
            "{text:?}: {error}"
        );
    }
    let error = read_points(Path::new("a.csv"), b"x,y,volume\n1,2,\xff\n").unwrap_err();
    assert!(
        matches!(error, FileError::NotUtf8 { line: 2, .. }),
        "{error}"
    );
}

#[test]
fn the_only_column_needs_no_name() {
    assert_eq!(
        permeability("k\n1e-15\n\n 2e-15 \n", None).unwrap(),
        [1e-15, 2e-15]
    );
    assert!(permeability("k_mD\n1\n", None).is_err());
    let error = permeability("1e-15\n2e-15\n", None).unwrap_err();
    assert!(
        matches!(error, FileError::NoHeader { line: 1, .. }),
        "{error}"
    );
}

#[test]
fn one_of_several_columns_is_chosen_by_name() {
    let text = "depth,permeability_m2,kv\n1,1e-15,-\n2,2e-15,-\n";
    for name in ["permeability", "permeability_m2"] {
        assert_eq!(permeability(text, Some(name)).unwrap(), [1e-15, 2e-15]);
    }
    let error = permeability(text, None).unwrap_err().to_string();
    assert!(
        error.contains("`depth`, `permeability_m2`, `kv`"),
        "{error}"
    );
    let error = permeability(text, Some("permeabilty"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("did you mean `permeability_m2`"), "{error}");
    let error = permeability(text, Some("kv")).unwrap_err();
    assert!(
        matches!(error, FileError::NotNumber { line: 2, .. }),
        "{error}"
    );
}
