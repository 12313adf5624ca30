#![allow(clippy::float_cmp)]
use super::*;

/// A file as NumPy writes it: version 1.0, header padded to 64 bytes.
pub(in super::super) fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let dict = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
    let width = (10 + dict.len() + 1).next_multiple_of(64) - 11;
    let header = format!("{dict:width$}\n");
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

fn read(bytes: &[u8]) -> Result<Vec<f64>, FileError> {
    read_field(Path::new("k.npy"), bytes, Property::PERMEABILITY).map(|table| table.values)
}

#[test]
fn every_number_type_and_byte_order_is_read() {
    let shape = "(2,)";
    assert_eq!(
        read(&npy("'<f8'", false, shape, &doubles(&[1.5, 2.0]))).unwrap(),
        [1.5, 2.0]
    );
    let big = [1.5_f64, 2.0].map(f64::to_be_bytes).concat();
    assert_eq!(read(&npy("'>f8'", false, shape, &big)).unwrap(), [1.5, 2.0]);
    let single = [1.5_f32, 2.0].map(f32::to_le_bytes).concat();
    assert_eq!(
        read(&npy("'<f4'", false, shape, &single)).unwrap(),
        [1.5, 2.0]
    );
    assert_eq!(
        read(&npy("'|u1'", false, shape, &[3, 255])).unwrap(),
        [3.0, 255.0]
    );
    assert_eq!(
        read(&npy("'|i1'", false, shape, &[3, 127])).unwrap(),
        [3.0, 127.0]
    );
    for (descr, bytes) in [
        ("'<i2'", 2),
        ("'<u2'", 2),
        ("'<i4'", 4),
        ("'<u4'", 4),
        ("'<i8'", 8),
    ] {
        let data = [3_i64, 258]
            .map(|value| value.to_le_bytes()[..bytes].to_vec())
            .concat();
        assert_eq!(
            read(&npy(descr, false, shape, &data)).unwrap(),
            [3.0, 258.0],
            "{descr}"
        );
    }
}

#[test]
fn fortran_order_gives_the_same_values_as_c_order() {
    // a[i, j, k] = 100 i + 10 j + k + 1 with shape (2, 3, 2).
    let value =
        |i: u8, j: u8, k: u8| 100.0 * f64::from(i) + 10.0 * f64::from(j) + f64::from(k) + 1.;
    let mut c = Vec::new();
    for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
        c.extend([value(i, j, 0), value(i, j, 1)]);
    }
    let mut fortran = Vec::new();
    for (k, j) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
        fortran.extend([value(0, j, k), value(1, j, k)]);
    }
    assert_eq!(
        read(&npy("'<f8'", false, "(2, 3, 2)", &doubles(&c))).unwrap(),
        c
    );
    assert_eq!(
        read(&npy("'<f8'", true, "(2, 3, 2)", &doubles(&fortran))).unwrap(),
        c
    );
    assert_eq!(
        read(&npy("'<f8'", true, "()", &doubles(&[4.0]))).unwrap(),
        [4.0]
    );
}

#[test]
fn other_types_and_empty_arrays_are_refused() {
    for descr in [
        "'|b1'",
        "'<f2'",
        "'<c16'",
        "'|S8'",
        "'|O'",
        "[('k', '<f8')]",
    ] {
        let error = read(&npy(descr, false, "(1,)", &doubles(&[1.0]))).unwrap_err();
        assert!(
            matches!(error, FileError::Unsupported { .. }),
            "{descr}: {error}"
        );
        assert!(error.to_string().contains("astype(float)"), "{error}");
    }
    let error = read(&npy("'<f8'", false, "(0, 3)", &[])).unwrap_err();
    assert!(matches!(error, FileError::Empty { .. }), "{error}");
}

#[test]
fn truncated_and_overlong_files_are_refused() {
    let whole = npy("'<f8'", false, "(3,)", &doubles(&[1.0, 2.0, 3.0]));
    for length in 0..whole.len() {
        let error = read(&whole[..length]).unwrap_err();
        assert!(
            matches!(error, FileError::Damaged { .. }),
            "{length}: {error}"
        );
    }
    assert!(read(&[&whole[..], &[0]].concat()).is_err());
}

#[test]
fn a_shape_that_overflows_is_refused_without_harm() {
    for shape in [
        "(18446744073709551615, 3)",
        "(4294967296, 4294967296, 0)",
        "(0xffffffffffff,)",
    ] {
        let error = read(&npy("'<f8'", false, shape, &[])).unwrap_err();
        assert!(error.to_string().contains("impossible"), "{error}");
    }
    let deep = "(".repeat(9000);
    let error = read(&npy("'<f8'", false, &deep, &[])).unwrap_err();
    assert!(error.to_string().contains("brackets"), "{error}");
}

#[test]
fn the_first_bad_entry_is_named() {
    let error = read(&npy(
        "'<f8'",
        false,
        "(4,)",
        &doubles(&[1.0, f64::NAN, 0.0, -1.0]),
    ));
    let message = error.unwrap_err().to_string();
    assert!(
        message.contains("k.npy, index 1") && message.contains("NaN"),
        "{message}"
    );
    assert!(message.contains("3 of 4"), "{message}");
    // In Fortran order the index is that of the flattened array, not of the file.
    let message = read(&npy(
        "'<f8'",
        true,
        "(2, 2)",
        &doubles(&[1.0, -2.0, 1.0, 1.0]),
    ));
    assert!(message.unwrap_err().to_string().contains("index 2"));
}
