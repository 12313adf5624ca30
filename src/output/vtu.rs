//! Point fields as VTK unstructured grids (`.vtu`).
//!
//! Layout (VTK file format, XML, version 1.0): one vertex cell per point, zlib-compressed blocks,
//! inline base64, 64-bit headers, little endian. Read by `ParaView`, `PyVista` and meshio.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{OutputError, write_atomically};

/// Uncompressed bytes per zlib block: large enough to compress well, small enough to read in parts.
const BLOCK_BYTES: usize = 1 << 18;

/// Order of the six components of a symmetric tensor in the file.
const TENSOR_COMPONENTS: [&str; 6] = ["XX", "YY", "ZZ", "XY", "YZ", "XZ"];

/// One field given at every point.
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

/// Everything that goes into one `.vtu` file.
#[derive(Debug, Clone, Copy)]
pub struct VtuData<'a> {
    /// Coordinates point by point, m. Shape `(points · dimension,)`.
    pub positions: &'a [f64],
    /// Space dimension, 2 or 3; a plane gets z = 0.
    pub dimension: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Fields at the points.
    pub fields: &'a [Field<'a>],
}

/// Writes points and their fields as a `.vtu` file, atomically.
///
/// Units are kept in a `Unit` attribute of each array, which readers ignore.
///
/// # Errors
/// [`OutputError::Unsupported`] for a dimension or number of components the format lacks,
/// [`OutputError::Shape`] for arrays of the wrong length, else those of [`write_atomically`].
pub fn write_vtu(path: impl AsRef<Path>, data: &VtuData<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    let points = check(path, data)?;
    write_atomically(path, |writer| write_document(writer, data, points))
}

fn check(path: &Path, data: &VtuData<'_>) -> Result<usize, OutputError> {
    let unsupported = |what: String, found: usize, allowed| OutputError::Unsupported {
        path: path.to_path_buf(),
        what,
        found: found.to_string(),
        allowed,
    };
    if !matches!(data.dimension, 2 | 3) {
        return Err(unsupported(
            "the dimension".to_owned(),
            data.dimension,
            "2 or 3",
        ));
    }
    let points = data.positions.len() / data.dimension;
    let whole = points * data.dimension;
    OutputError::check_length(path, "the positions", whole, data.positions.len())?;
    for field in data.fields {
        if !matches!(field.components, 1 | 2 | 3 | 6) {
            let what = format!("the number of components of field {:?}", field.name);
            return Err(unsupported(what, field.components, "1, 2, 3 or 6"));
        }
        let what = format!("field {:?}", field.name);
        OutputError::check_length(path, &what, points * field.components, field.values.len())?;
    }
    Ok(points)
}

fn write_document(writer: &mut dyn Write, data: &VtuData<'_>, points: usize) -> io::Result<()> {
    writer.write_all(
        b"<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
          byte_order=\"LittleEndian\" header_type=\"UInt64\" \
          compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n",
    )?;
    writer.write_all(b"<FieldData>\n")?;
    let time = "Name=\"TimeValue\" NumberOfTuples=\"1\"";
    write_array(writer, "Float64", time, &data.time.to_le_bytes())?;
    writeln!(writer, "</FieldData>")?;
    writeln!(
        writer,
        "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{points}\">"
    )?;
    writeln!(writer, "<Points>")?;
    let positions = padded(data.positions, data.dimension);
    let attributes = "Name=\"Points\" NumberOfComponents=\"3\" Unit=\"m\"";
    write_array(writer, "Float64", attributes, &little_endian(&positions))?;
    writeln!(writer, "</Points>")?;
    write_vertices(writer, points)?;
    writeln!(writer, "<PointData>")?;
    for field in data.fields {
        let values = padded(field.values, field.components);
        write_array(
            writer,
            "Float64",
            &attributes_of(field),
            &little_endian(&values),
        )?;
    }
    writeln!(
        writer,
        "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>"
    )
}

fn write_vertices(writer: &mut dyn Write, points: usize) -> io::Result<()> {
    const VTK_VERTEX: u8 = 1;
    let count = points as u64;
    let indices: Vec<u8> = (0..count).flat_map(u64::to_le_bytes).collect();
    let offsets: Vec<u8> = (1..=count).flat_map(u64::to_le_bytes).collect();
    writeln!(writer, "<Cells>")?;
    write_array(writer, "Int64", "Name=\"connectivity\"", &indices)?;
    write_array(writer, "Int64", "Name=\"offsets\"", &offsets)?;
    write_array(writer, "UInt8", "Name=\"types\"", &vec![VTK_VERTEX; points])?;
    writeln!(writer, "</Cells>")
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
    if !field.unit.is_empty() {
        text.push_str(&format!(" Unit=\"{}\"", escape(field.unit)));
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
fn padded(values: &[f64], components: usize) -> Cow<'_, [f64]> {
    if components != 2 {
        return Cow::Borrowed(values);
    }
    values
        .chunks_exact(2)
        .flat_map(|pair| [pair[0], pair[1], 0.0])
        .collect::<Vec<_>>()
        .into()
}

fn little_endian(values: &[f64]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

fn write_array(
    writer: &mut dyn Write,
    number_type: &str,
    attributes: &str,
    bytes: &[u8],
) -> io::Result<()> {
    writeln!(
        writer,
        "<DataArray type=\"{number_type}\" {attributes} format=\"binary\">"
    )?;
    write_compressed(writer, bytes)?;
    writeln!(writer, "\n</DataArray>")
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
        let mut encoder = ZlibEncoder::new(&mut compressed, Compression::new(4));
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

#[cfg(test)]
#[path = "vtu_tests.rs"]
mod tests;
