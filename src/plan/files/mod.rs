//! Point clouds, meshes and properties of the rock from files: `.csv`, `.vtu`, `.npy`, `.msh` and `.inp`.
//!
//! Every reader takes the whole file into memory, checks every value, and reports the first fault
//! with its place, so that a damaged file never becomes a damaged simulation.

mod bundled;
mod columns;
mod csv;
mod error;
mod mesh;
mod npy;
mod order;
mod property;
mod table;
mod values;
mod vtu;

use std::io;
use std::path::Path;

pub(crate) use bundled::BUNDLED;
pub use error::FileError;
pub(crate) use error::{Place, ValueFault};
pub use mesh::PointSet;
pub(crate) use mesh::{MeshTable, read_mesh};
pub use order::check_length;
pub(crate) use order::{FieldTable, check_cells};
pub(crate) use property::Property;
pub use table::{PointTable, TableError};
pub(crate) use values::{Allowed, fault};
pub use vtu::{PointFields, read_array, read_fields};

/// Reads points from a `.csv` or `.vtu` file.
///
/// CSV: a header line with `x`, `y`, `volume` and optionally `z` (which makes the points
/// three-dimensional), `material` and `permeability`, in any order; other columns are ignored. A
/// name may carry its SI unit, as in `x_m`, `volume_m2`, `volume_m3` and `permeability_m2`. Blank
/// lines and lines that start with `#` are skipped.
///
/// VTU: an unstructured grid with the point data `volume` and optionally `permeability`, stored as
/// text, base64 or raw bytes, plain or compressed with zlib. The points are two-dimensional if all
/// z are equal to within 1e-12 of the largest extent. Cells are ignored; pieces are joined.
///
/// # Errors
/// [`FileError`] for a file that cannot be read, has another format, lacks a column, or holds a
/// position that is not finite or a volume or permeability that is not positive.
pub(crate) fn read_points(path: &Path) -> Result<PointTable, FileError> {
    match extension(path)?.as_str() {
        "csv" => csv::read_points(path, &read_bytes(path)?),
        "vtu" => vtu::read_points(path, &read_bytes(path)?),
        other => Err(wrong_extension(path, other, "`.csv` and `.vtu`")),
    }
}

/// Reads a property, SI, from an `.npy`, `.csv` or `.vtu` file.
///
/// NPY: an array of floats (4 or 8 bytes) or integers, in C or Fortran order; its shape comes with
/// the values, see [`FieldTable::in_point_order`]. CSV: the only column, or the one named
/// `column` (whose unit suffix such as `_m2` may be left out). VTU: the point data named `column`, or as the key.
///
/// # Errors
/// [`FileError`] for a file that cannot be read, has another format, lacks the column, or holds a
/// value that makes no sense.
pub(crate) fn read_field(
    path: &Path,
    column: Option<&str>,
    property: Property,
) -> Result<FieldTable, FileError> {
    let flat = |values| FieldTable {
        values,
        shape: None,
    };
    match extension(path)?.as_str() {
        "csv" => csv::read_field(path, &read_bytes(path)?, column, property).map(flat),
        "npy" => match column {
            None => npy::read_field(path, &read_bytes(path)?, property),
            Some(column) => Err(FileError::ColumnInArray {
                path: path.to_path_buf(),
                column: column.to_owned(),
            }),
        },
        "vtu" => {
            let values = read_array(path, column.unwrap_or(property.key))?;
            values::check(path, property.key, property.allowed, &values, Place::Index)?;
            Ok(flat(values))
        }
        other => Err(wrong_extension(path, other, "`.npy`, `.csv` and `.vtu`")),
    }
}

/// Directories are refused first: a missing extension is not what is wrong with them.
fn extension(path: &Path) -> Result<String, FileError> {
    if path.is_dir() {
        return Err(FileError::IsDirectory {
            path: path.to_path_buf(),
        });
    }
    Ok(path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase())
}

fn wrong_extension(path: &Path, found: &str, known: &'static str) -> FileError {
    let found = if found.is_empty() {
        "no extension".to_owned()
    } else {
        format!("`.{found}`")
    };
    FileError::MirrorContinuation {
        path: path.to_path_buf(),
        found,
        known,
    }
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    if let Some(bytes) = bundled::read(path)? {
        return Ok(bytes.to_vec());
    }
    std::fs::read(path).map_err(|source| {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => FileError::NotFound { path },
            io::ErrorKind::IsADirectory => FileError::IsDirectory { path },
            io::ErrorKind::PermissionDenied => FileError::NotReadable { path, source },
            _ => FileError::Io { path, source },
        }
    })
}

/// The bytes as text, or the line where they stop being UTF-8.
fn utf8<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str, FileError> {
    std::str::from_utf8(bytes).map_err(|error| FileError::NotUtf8 {
        path: path.to_path_buf(),
        line: 1 + bytes[..error.valid_up_to()]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count(),
    })
}

#[cfg(test)]
mod tests;
