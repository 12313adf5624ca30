use std::path::PathBuf;

use proptest::prelude::*;

use super::*;

fn written(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (directory, path)
}

#[test]
fn the_format_is_known_by_the_extension_in_any_case() {
    let (_directory, path) = written("points.CSV", b"x,y,volume\n1,2,3\n");
    assert_eq!(read_points(&path).unwrap().position, [1.0, 2.0]);
    let table = read_field(&path, Some("volume"), Property::PERMEABILITY).unwrap();
    assert_eq!((&table.values[..], table.shape), (&[3.0][..], None));
    for (name, known) in [("a.txt", "`.csv` and `.vtu`"), ("a", "no extension")] {
        let message = read_points(Path::new(name)).unwrap_err().to_string();
        assert!(message.contains(known), "{message}");
    }
    let message = read_field(Path::new("a.vtk"), None, Property::PERMEABILITY)
        .unwrap_err()
        .to_string();
    assert!(message.contains("`.npy`, `.csv` and `.vtu`"), "{message}");
}

#[test]
fn missing_files_and_directories_are_told_apart() {
    let directory = tempfile::tempdir().unwrap();
    let error = read_points(&directory.path().join("none.csv")).unwrap_err();
    assert!(matches!(error, FileError::NotFound { .. }), "{error}");
    let folder = directory.path().join("folder.npy");
    std::fs::create_dir(&folder).unwrap();
    let error = read_field(&folder, None, Property::PERMEABILITY).unwrap_err();
    assert!(matches!(error, FileError::IsDirectory { .. }), "{error}");
    let error = read_field(&folder.join("a.npy"), None, Property::PERMEABILITY).unwrap_err();
    assert!(matches!(error, FileError::NotFound { .. }), "{error}");
}

#[test]
fn an_array_file_has_no_columns() {
    let error = read_field(Path::new("k.npy"), Some("k"), Property::PERMEABILITY).unwrap_err();
    assert!(matches!(error, FileError::ColumnInArray { .. }), "{error}");
}

#[test]
fn values_of_every_property_are_checked_where_they_are_read() {
    let text =
        "E_Pa,E_GPa,nu,alpha,n,label\n1e9,1,0.2,0.7,0.1,a\n2e9,2,0.5,1,15,b\n0,3,-0.1,1.5,0,c\n";
    let (_directory, path) = written("rock.csv", text.as_bytes());
    let fault = |column, property| {
        read_field(&path, Some(column), property)
            .unwrap_err()
            .to_string()
    };
    for (column, property, words) in [
        (
            "E_Pa",
            Property::YOUNGS_MODULUS,
            "line 4: youngs_modulus is 0.0, not positive",
        ),
        (
            "E_GPa",
            Property::YOUNGS_MODULUS,
            "has the unit `GPa`; convert the values to Pa and name it `E_Pa`",
        ),
        (
            "nu",
            Property::POISSONS_RATIO,
            "line 3: poissons_ratio is 0.5, above 0.499999",
        ),
        (
            "alpha",
            Property::BIOT_COEFFICIENT,
            "line 4: biot_coefficient is 1.5, above 1: the pressure",
        ),
        (
            "n",
            Property::POROSITY,
            "line 3: porosity is 15.0, above 1: it is a share of the volume",
        ),
        (
            "label",
            Property::DENSITY,
            "`a` in column `label` is no number",
        ),
        ("storage", Property::STORAGE, "no column `storage`"),
    ] {
        let message = fault(column, property);
        assert!(
            message.contains(words) && message.contains("rock.csv"),
            "{message}"
        );
    }
}

#[test]
fn point_data_are_read_by_the_name_of_the_key_or_of_the_column() {
    let file = &vtu::tests::files()[1];
    let (_directory, path) = written("rock.vtu", file);
    let own = read_field(&path, None, Property::PERMEABILITY).unwrap();
    assert_eq!(own.values, [1e-15, 2e-15, 3e-15, 4e-15]);
    let named = read_field(&path, Some("volume"), Property::POROSITY).unwrap();
    assert_eq!(named.values, [0.01, 0.02, 0.03, 0.04]);
    let message = read_field(&path, None, Property::STORAGE)
        .unwrap_err()
        .to_string();
    assert!(message.contains("no array `storage`"), "{message}");
}

/// Whatever a reader makes of a damaged file, what it returns must be usable.
fn usable(table: &PointTable) -> bool {
    let points = table.volume.len();
    let positive = |values: &[f64]| values.iter().all(|v| v.is_finite() && *v > 0.0);
    points > 0
        && table.position.len() == points * table.dimension
        && table.position.iter().all(|x| x.is_finite())
        && positive(&table.volume)
        && table
            .permeability
            .as_ref()
            .is_none_or(|k| k.len() == points && positive(k))
        && table
            .material
            .as_ref()
            .is_none_or(|names| names.len() == points)
}

/// Some bytes of a file replaced, then its end cut off.
fn damage(file: &[u8], changes: &[(prop::sample::Index, u8)], end: usize) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for (index, byte) in changes {
        let place = index.index(bytes.len());
        bytes[place] = *byte;
    }
    bytes.truncate(end.max(1).min(bytes.len()));
    bytes
}

fn changes() -> impl Strategy<Value = Vec<(prop::sample::Index, u8)>> {
    let byte = prop_oneof![
        any::<u8>(),
        prop::sample::select(b"0189<>\"'([{=_#,-\n".to_vec())
    ];
    prop::collection::vec((any::<prop::sample::Index>(), byte), 0..6)
}

fn cut() -> impl Strategy<Value = usize> {
    prop_oneof![3 => Just(usize::MAX), 1 => 0_usize..4000]
}

const CSV: &[u8] = b"# a\nx_m, y, z,volume_m3,material,permeability\n0,0,1,2,\"a b\",1e-15\n\n\
                     1.5,0,2,2,c,3e-15\n";

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damaged_csv_gives_an_error_or_sound_points(changes in changes(), end in cut()) {
        let bytes = damage(CSV, &changes, end);
        if let Ok(table) = csv::read_points(Path::new("a.csv"), &bytes) {
            prop_assert!(usable(&table));
        }
        let _ = csv::read_field(Path::new("a.csv"), &bytes, Some("permeability"), Property::PERMEABILITY);
    }

    #[test]
    fn damaged_vtu_gives_an_error_or_sound_points(
        file in prop::sample::select(vtu::tests::files()),
        changes in changes(),
        end in cut(),
    ) {
        let bytes = damage(&file, &changes, end);
        if let Ok(table) = vtu::read_points(Path::new("a.vtu"), &bytes) {
            prop_assert!(usable(&table));
        }
    }

    #[test]
    fn damaged_npy_gives_an_error_or_sound_values(changes in changes(), end in cut()) {
        let file = npy::tests::npy("'<f8'", true, "(2, 3)", &[1_f64; 6].map(f64::to_le_bytes).concat());
        let bytes = damage(&file, &changes, end);
        if let Ok(table) = npy::read_field(Path::new("a.npy"), &bytes, Property::PERMEABILITY) {
            let values = table.values;
            prop_assert!(!values.is_empty() && values.iter().all(|k| k.is_finite() && *k > 0.0));
        }
    }

    #[test]
    fn cut_off_csv_never_adds_points(end in 0_usize..CSV.len()) {
        if let Ok(table) = csv::read_points(Path::new("a.csv"), &CSV[..end]) {
            prop_assert!(usable(&table) && table.volume.len() <= 2);
        }
    }
}
