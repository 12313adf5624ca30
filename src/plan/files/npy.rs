//! Values from `NumPy` arrays (`.npy`).

use std::io;
use std::path::Path;

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};

use super::values::check;
use super::{FieldTable, FileError, Place, Property};

/// Larger headers belong to records with thousands of fields, which are not read here.
const LONGEST_HEADER: usize = 1 << 16;

/// Reads an array; see [`super::read_field`].
pub(super) fn read_field(
    path: &Path,
    bytes: &[u8],
    property: Property,
) -> Result<FieldTable, FileError> {
    let damaged = |reason| FileError::Damaged {
        path: path.to_path_buf(),
        place: None,
        reason,
    };
    check_header(bytes).map_err(damaged)?;
    let mut rest = bytes;
    let file = NpyFile::new(&mut rest).map_err(|error| damaged(error.to_string()))?;
    let (shape, order) = (file.shape().to_vec(), file.order());
    let stored = numbers(path, file)?.map_err(|error| damaged(reason(&error)))?;
    if !rest.is_empty() {
        let extra = rest.len();
        return Err(damaged(format!(
            "{extra} bytes follow the array of shape {shape:?}"
        )));
    }
    if stored.is_empty() {
        return Err(FileError::Empty {
            path: path.to_path_buf(),
            what: "values",
        });
    }
    let values = if order == Order::Fortran {
        c_order(&stored, &shape)
    } else {
        stored
    };
    check(path, property.key, property.allowed, &values, Place::Index)?;
    let size = |&size: &u64| usize::try_from(size).unwrap_or(usize::MAX);
    Ok(FieldTable {
        values,
        shape: Some(shape.iter().map(size).collect()),
    })
}

fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "the data end before the array is complete".to_owned(),
        _ => error.to_string(),
    }
}

/// The library multiplies the numbers of the header without a check, and follows brackets as deep
/// as they go; a damaged header must do no harm there.
fn check_header(bytes: &[u8]) -> Result<(), String> {
    let &[
        b'\x93',
        b'N',
        b'U',
        b'M',
        b'P',
        b'Y',
        major,
        _,
        ref rest @ ..,
    ] = bytes
    else {
        return Err("this is no `.npy` file, its first bytes are wrong".to_owned());
    };
    let (length, text) = match (major, rest) {
        (1, &[low, high, ref text @ ..]) => (usize::from(u16::from_le_bytes([low, high])), text),
        (2 | 3, &[a, b, c, d, ref text @ ..]) => (
            usize::try_from(u32::from_le_bytes([a, b, c, d])).unwrap_or(usize::MAX),
            text,
        ),
        (1..=3, _) => return Err("the header is cut off".to_owned()),
        _ => return Err(format!("the format version {major} is unknown")),
    };
    if length > LONGEST_HEADER {
        return Err(format!(
            "the header has {length} bytes, more than {LONGEST_HEADER}"
        ));
    }
    check_dictionary(text.get(..length).ok_or("the header is cut off")?)
}

fn check_dictionary(header: &[u8]) -> Result<(), String> {
    if header.iter().filter(|&byte| b"([{".contains(byte)).count() > 64 {
        return Err("the header has too many brackets".to_owned());
    }
    let words = header.split(|byte| !byte.is_ascii_alphanumeric() && *byte != b'_');
    let mut product = 1_u64;
    for word in words.filter(|word| word.first().is_some_and(u8::is_ascii_digit)) {
        let number = std::str::from_utf8(word)
            .ok()
            .and_then(|word| word.parse::<u64>().ok());
        product = number
            .and_then(|number| product.checked_mul(number.max(1)))
            .filter(|&product| product < 1 << 48)
            .ok_or("the shape in the header is impossible")?;
    }
    Ok(())
}

type Numbers = io::Result<Vec<f64>>;

fn numbers<R: io::Read>(path: &Path, file: NpyFile<R>) -> Result<Numbers, FileError> {
    let dtype = file.dtype();
    let kind = match &dtype {
        DType::Plain(kind) => Some((kind.type_char(), kind.size_field())),
        _ => None,
    };
    Ok(match kind {
        Some((TypeChar::Float, 8)) => file.into_vec::<f64>(),
        Some((TypeChar::Float, 4)) => convert::<f32, R>(file, f64::from),
        Some((TypeChar::Int, 1)) => convert::<i8, R>(file, f64::from),
        Some((TypeChar::Int, 2)) => convert::<i16, R>(file, f64::from),
        Some((TypeChar::Int, 4)) => convert::<i32, R>(file, f64::from),
        Some((TypeChar::Int, 8)) => convert::<i64, R>(file, |value| value as f64),
        Some((TypeChar::Uint, 1)) => convert::<u8, R>(file, f64::from),
        Some((TypeChar::Uint, 2)) => convert::<u16, R>(file, f64::from),
        Some((TypeChar::Uint, 4)) => convert::<u32, R>(file, f64::from),
        Some((TypeChar::Uint, 8)) => convert::<u64, R>(file, |value| value as f64),
        _ => {
            return Err(FileError::Unsupported {
                path: path.to_path_buf(),
                what: "the data type",
                found: dtype.descr().trim_matches('\'').to_owned(),
                remedy: "save the array as doubles, `array.astype(float)` in NumPy",
            });
        }
    })
}

fn convert<T: Deserialize, R: io::Read>(file: NpyFile<R>, to: impl Fn(T) -> f64) -> Numbers {
    let values = file.data::<T>().map_err(io::Error::other)?;
    values.map(|value| value.map(&to)).collect()
}

/// Values stored with the first index fastest, sorted so that the last is.
fn c_order(stored: &[f64], shape: &[u64]) -> Vec<f64> {
    let sizes: Vec<usize> = shape
        .iter()
        .map(|&size| usize::try_from(size).unwrap_or(usize::MAX))
        .collect();
    let mut index = vec![0; sizes.len()];
    let mut values = Vec::with_capacity(stored.len());
    for _ in 0..stored.len() {
        let place = index
            .iter()
            .zip(&sizes)
            .rev()
            .fold(0, |place, (i, size)| place * size + i);
        values.push(stored[place]);
        for (i, size) in index.iter_mut().zip(&sizes).rev() {
            *i += 1;
            if *i < *size {
                break;
            }
            *i = 0;
        }
    }
    values
}

#[cfg(test)]
#[path = "npy_tests.rs"]
pub(super) mod tests;
