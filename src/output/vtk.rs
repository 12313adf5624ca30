//! What all XML files of VTK share: named arrays of numbers, compressed, with units.
//!
//! Version 1.0 of the format: zlib-compressed blocks, inline base64, 64-bit headers, little endian. Read by `ParaView`,
//! `PyVista` and meshio.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::OutputError;

/// Uncompressed bytes per zlib block: large enough to compress well, small enough to read in parts.
pub(super) const BLOCK_BYTES: usize = 1 << 18;

/// Names of the six components of a symmetric tensor, in the order in which `ParaView` takes them.
const TENSOR_COMPONENTS: [&str; 6] = ["XX", "YY", "ZZ", "XY", "YZ", "XZ"];

/// One field given at every point, or of every cell.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// Name in the file, such as `displacement`.
    pub name: &'a str,
    /// SI unit, such as `Pa`; empty for pure numbers.
    pub unit: &'a str,
    /// Values per point: 1 (scalar), 2 or 3 (vector; two are padded with a zero) or 6 (symmetric
    /// tensor in the order XX, YY, ZZ, XY, YZ, XZ).
    pub components: usize,
    /// Values, point by point. Shape `(points · components,)`.
    pub values: &'a [f64],
}

/// Corners of cells, in the way of VTK.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cells<'a> {
    /// Numbers of the corners of all cells, one cell after another.
    pub corners: &'a [u32],
    /// Where the corners of each cell end in `corners`. Shape `(cells,)`.
    pub ends: &'a [u64],
    /// Of polyhedra the number of faces, and for each face the number of its corners and these. Empty without any.
    pub faces: &'a [u64],
    /// Where the faces of each cell end in `faces`; −1 for cells that are no polyhedra. Shape `(cells,)`, or empty.
    pub face_ends: &'a [i64],
}

impl Cells<'_> {
    /// Refuses ends that do not ascend to the number of corners, and corners that are no points.
    ///
    /// # Errors
    /// [`OutputError::Shape`].
    pub(super) fn check(&self, path: &Path, points: usize) -> Result<(), OutputError> {
        let end = self.ends.last().map_or(0, |end| *end as usize);
        let ends = if self.ends.is_sorted() {
            end
        } else {
            usize::MAX
        };
        OutputError::check_length(path, "the corners of cells", ends, self.corners.len())?;
        let beyond = self
            .corners
            .iter()
            .find(|corner| **corner as usize >= points);
        beyond.map_or(Ok(()), |corner| {
            let most = points.saturating_sub(1);
            OutputError::check_length(path, "a corner of a cell", most, *corner as usize)
        })
    }

    /// Writes connectivity and offsets.
    pub(super) fn write(&self, writer: &mut dyn Write) -> io::Result<()> {
        let corners = self.corners.iter();
        let corners = corners.map(|corner| i64::from(*corner).to_le_bytes());
        let corners = eight_bytes(self.corners.len(), corners);
        let ends = self.ends.iter().map(|end| end.to_le_bytes());
        let ends = eight_bytes(self.ends.len(), ends);
        write_array(writer, "Int64", "Name=\"connectivity\"", "", &corners)?;
        write_array(writer, "Int64", "Name=\"offsets\"", "", &ends)?;
        if self.faces.is_empty() {
            return Ok(());
        }
        let faces: Vec<u8> = self
            .faces
            .iter()
            .flat_map(|own| own.to_le_bytes())
            .collect();
        let ends = self.face_ends.iter().flat_map(|end| end.to_le_bytes());
        let ends: Vec<u8> = ends.collect();
        write_array(writer, "Int64", "Name=\"faces\"", "", &faces)?;
        write_array(writer, "Int64", "Name=\"faceoffsets\"", "", &ends)
    }
}

/// Refuses a dimension that the format lacks; gives the number of points.
///
/// # Errors
/// [`OutputError::Unsupported`], or [`OutputError::Shape`] for part of a point.
pub(super) fn check_positions(
    path: &Path,
    positions: &[f64],
    dimension: usize,
) -> Result<usize, OutputError> {
    if !matches!(dimension, 2 | 3) {
        return Err(unsupported(
            path,
            "the dimension".to_owned(),
            dimension,
            "2 or 3",
        ));
    }
    let points = positions.len() / dimension;
    OutputError::check_length(path, "the positions", points * dimension, positions.len())?;
    Ok(points)
}

/// Refuses fields that the format lacks, or that are not given at `count` points or cells.
///
/// # Errors
/// [`OutputError::Unsupported`] or [`OutputError::Shape`].
pub(super) fn check_fields(
    path: &Path,
    fields: &[Field<'_>],
    count: usize,
) -> Result<(), OutputError> {
    for field in fields {
        if !matches!(field.components, 1 | 2 | 3 | 6) {
            let what = format!("the number of components of field {:?}", field.name);
            return Err(unsupported(path, what, field.components, "1, 2, 3 or 6"));
        }
        let what = format!("field {:?}", field.name);
        OutputError::check_length(path, &what, count * field.components, field.values.len())?;
    }
    Ok(())
}

fn unsupported(path: &Path, what: String, found: usize, allowed: &'static str) -> OutputError {
    OutputError::Unsupported {
        path: path.to_path_buf(),
        what,
        found: found.to_string(),
        allowed,
    }
}

/// Writes what stands before the pieces of a grid of some kind, with the simulated time, s.
pub(super) fn write_opening(writer: &mut dyn Write, kind: &str, time: f64) -> io::Result<()> {
    writeln!(
        writer,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<{kind}>\n<FieldData>"
    )?;
    let attributes = "Name=\"TimeValue\" NumberOfTuples=\"1\"";
    write_array(writer, "Float64", attributes, "s", &time.to_le_bytes())?;
    writeln!(writer, "</FieldData>")
}

/// Writes the positions, m.
pub(super) fn write_points(
    writer: &mut dyn Write,
    positions: &[f64],
    dimension: usize,
) -> io::Result<()> {
    writeln!(writer, "<Points>")?;
    let positions = padded(positions, dimension);
    let attributes = "Name=\"Points\" NumberOfComponents=\"3\"";
    write_array(
        writer,
        "Float64",
        attributes,
        "m",
        &little_endian(&positions),
    )?;
    writeln!(writer, "</Points>")
}

/// Writes fields one after another.
pub(super) fn write_fields(writer: &mut dyn Write, fields: &[Field<'_>]) -> io::Result<()> {
    for field in fields {
        let values = padded(field.values, field.components);
        let attributes = attributes_of(field);
        write_array(
            writer,
            "Float64",
            &attributes,
            field.unit,
            &little_endian(&values),
        )?;
    }
    Ok(())
}

/// Scalars carry no `NumberOfComponents`: some readers would make them columns of width one.
pub(super) fn attributes_of(field: &Field<'_>) -> String {
    let mut text = format!("Name=\"{}\"", escape(field.name));
    match field.components {
        1 => {}
        6 => {
            text.push_str(" NumberOfComponents=\"6\"");
            for (index, name) in TENSOR_COMPONENTS.iter().enumerate() {
                text.push_str(&format!(" ComponentName{index}=\"{name}\""));
            }
        }
        _ => text.push_str(" NumberOfComponents=\"3\""),
    }
    text
}

/// Text as XML; control characters, which XML forbids, become spaces.
pub(super) fn escape(text: &str) -> String {
    let text = text.replace(char::is_control, " ");
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Plane vectors get a third component, because readers expect vectors of space.
pub(super) fn padded(values: &[f64], components: usize) -> Cow<'_, [f64]> {
    if components != 2 {
        return Cow::Borrowed(values);
    }
    let mut padded = vec![0.0; values.len() / 2 * 3];
    for (three, pair) in padded.chunks_exact_mut(3).zip(values.chunks_exact(2)) {
        three[..2].copy_from_slice(pair);
    }
    padded.into()
}

fn little_endian(values: &[f64]) -> Vec<u8> {
    eight_bytes(values.len(), values.iter().map(|value| value.to_le_bytes()))
}

/// Numbers of eight bytes, `count` of them, one after the other.
fn eight_bytes(count: usize, numbers: impl Iterator<Item = [u8; 8]>) -> Vec<u8> {
    let mut bytes = vec![0; 8 * count];
    for (place, number) in bytes.chunks_exact_mut(8).zip(numbers) {
        place.copy_from_slice(&number);
    }
    bytes
}

/// Writes one array. The unit stands behind the numbers, where readers that know no keys do not take it for one.
pub(super) fn write_array(
    writer: &mut dyn Write,
    number_type: &str,
    attributes: &str,
    unit: &str,
    bytes: &[u8],
) -> io::Result<()> {
    writeln!(
        writer,
        "<DataArray type=\"{number_type}\" {attributes} format=\"binary\">"
    )?;
    write_compressed(writer, bytes)?;
    writeln!(writer)?;
    write_unit(writer, unit)?;
    writeln!(writer, "</DataArray>")
}

/// Writes the unit of an array under VTK's own key; nothing for pure numbers.
pub(super) fn write_unit(writer: &mut dyn Write, unit: &str) -> io::Result<()> {
    if unit.is_empty() {
        return Ok(());
    }
    let unit = escape(unit);
    writeln!(
        writer,
        "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey>"
    )
}

/// Header (number of blocks, block size, size of a shorter last block, compressed sizes) and blocks
/// are two separate base64 texts without a gap, as the format prescribes.
fn write_compressed(writer: &mut dyn Write, bytes: &[u8]) -> io::Result<()> {
    let blocks = bytes.len().div_ceil(BLOCK_BYTES);
    let mut header = vec![
        blocks as u64,
        BLOCK_BYTES as u64,
        (bytes.len() % BLOCK_BYTES) as u64,
    ];
    let mut compressed = Vec::with_capacity(bytes.len() / 2);
    for block in bytes.chunks(BLOCK_BYTES) {
        let start = compressed.len();
        // Of a million points 4 takes a third longer than 1, for as many bytes: most are digits without a pattern.
        let mut encoder = ZlibEncoder::new(&mut compressed, Compression::new(1));
        encoder.write_all(block)?;
        encoder.finish()?;
        header.push((compressed.len() - start) as u64);
    }
    let header: Vec<u8> = header
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    writer.write_all(BASE64.encode(header).as_bytes())?;
    writer.write_all(BASE64.encode(compressed).as_bytes())
}
