//! Files of VTKHDF, version 2.0: an unstructured grid that stays, and fields that grow by one output after the other.
//!
//! The layout is that of "VTKHDF File Format" in the documentation of VTK, section "Transient Data". Points and cells
//! stand there once, and every output refers to them; of a field output k has the rows from k times the number of
//! points on. The file is opened for each output and closed after it, and the number of outputs is written last: what
//! an output that was interrupted has left is overwritten by the next one. A crash of the machine within that may
//! damage the file, as with all of HDF5; it is then refused when a run goes on.

use std::io;
use std::path::Path;

use hdf5::types::FixedAscii;
use hdf5::{Dataset, File, Group, H5Type};
use hdf5_metno as hdf5;
use ndarray::ArrayView2;

use crate::output::vtk::{check_fields, check_positions, padded};
use crate::output::{Field, OutputError, VtuData, manifest};

/// Most rows of a chunk, the piece that is compressed and read at once.
const ROWS: usize = 1 << 14;
/// Effort of the compression, of 9.
const EFFORT: u8 = 3;
const ROOT: &str = "VTKHDF";
const STEPS: &str = "VTKHDF/Steps";
const COUNT: &str = "NSteps";
/// What an output refers to: the first of the parts, points, cells and corners, always.
const OFFSETS: [(&str, bool); 4] = [
    ("PartOffsets", false),
    ("PointOffsets", false),
    ("CellOffsets", true),
    ("ConnectivityIdOffsets", true),
];

/// Begins a file with points, cells and, without an output yet, the fields of `data`; replaces an older file.
///
/// # Errors
/// As [`write_vtu`](crate::output::write_vtu), and [`OutputError::Unsupported`] for polyhedra and pieces.
pub fn create_vtkhdf(path: impl AsRef<Path>, data: &VtuData<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    let points = check_positions(path, data.positions, data.dimension)?;
    check_fields(path, data.fields, points)?;
    data.cells.check(path, points)?;
    if !data.cells.faces.is_empty() || data.ghosts.is_some() {
        return Err(OutputError::Unsupported {
            path: path.to_owned(),
            what: "the grid".to_owned(),
            found: "one with polyhedra, or a piece".to_owned(),
            allowed: "whole and without polyhedra; write .vtu",
        });
    }
    if let Some(list) = manifest::of(manifest::directory(path)) {
        list.make_room(path)?;
    }
    manifest::grows(path)?;
    let made = File::create(path).and_then(|file| {
        write_grid(&file, data, points)?;
        write_steps(&file)?;
        let fields = file.create_group("VTKHDF/PointData")?;
        let offsets = file.create_group("VTKHDF/Steps/PointDataOffsets")?;
        for field in data.fields {
            create_field(&fields, field, points)?;
            growing::<i64>(&offsets, field.name, None, ROWS)?;
        }
        file.close()
    });
    made.map_err(|error| failed(path, "begin it", &error))
}

/// Adds an output at `time` (s) with the fields that the file was begun with.
///
/// # Errors
/// [`OutputError`] if the file is damaged or cannot be written, [`OutputError::Shape`] for fields of another length.
pub fn append_vtkhdf(
    path: impl AsRef<Path>,
    time: f64,
    fields: &[Field<'_>],
) -> Result<(), OutputError> {
    let path = path.as_ref();
    let points = number_of_points(path)?;
    check_fields(path, fields, points)?;
    let added = File::open_rw(path).and_then(|file| {
        let step = steps(&file)?;
        let group = file.group(ROOT)?;
        for field in fields {
            add_rows(
                &group.dataset(&format!("PointData/{}", field.name))?,
                step,
                field,
            )?;
            let offset = i64::try_from(step * points).unwrap_or(i64::MAX);
            add(
                &group.dataset(&format!("Steps/PointDataOffsets/{}", field.name))?,
                step,
                offset,
            )?;
        }
        let group = file.group(STEPS)?;
        for (name, by_topology) in OFFSETS {
            let own = group.dataset(name)?;
            match by_topology {
                true => add_row(&own, step, 0)?,
                false => add(&own, step, 0_i64)?,
            }
        }
        add(&group.dataset("NumberOfParts")?, step, 1_i64)?;
        add(&group.dataset("Values")?, step, time)?;
        set_steps(&group, step + 1)?;
        file.close()
    });
    added.map_err(|error| failed(path, "add an output to it", &error))
}

/// Leaves out all outputs after the first `count`.
///
/// # Errors
/// [`OutputError::Shape`] if there are fewer, else [`OutputError`] if the file is damaged or cannot be written.
pub fn cut_vtkhdf(path: impl AsRef<Path>, count: usize) -> Result<(), OutputError> {
    let path = path.as_ref();
    let opened = File::open_rw(path).and_then(|file| Ok((steps(&file)?, file)));
    let (found, file) = opened.map_err(|error| failed(path, "go on with it", &error))?;
    OutputError::check_length(
        path,
        "the file of the outputs so far",
        count,
        found.min(count),
    )?;
    manifest::grows(path)?;
    let cut = file.group(STEPS).and_then(|group| set_steps(&group, count));
    cut.and_then(|()| file.close())
        .map_err(|error| failed(path, "go on with it", &error))
}

/// The grid as one part.
fn write_grid(file: &File, data: &VtuData<'_>, points: usize) -> hdf5::Result<()> {
    let root = file.create_group(ROOT)?;
    root.new_attr_builder()
        .with_data(&[2_i64, 0])
        .create("Version")?;
    let kind: FixedAscii<16> = FixedAscii::from_ascii("UnstructuredGrid")
        .map_err(|error| hdf5::Error::from(error.to_string()))?;
    root.new_attr::<FixedAscii<16>>()
        .create("Type")?
        .write_scalar(&kind)?;
    let cells = &data.cells;
    for (name, count) in [
        ("NumberOfPoints", points),
        ("NumberOfCells", cells.ends.len()),
        ("NumberOfConnectivityIds", cells.corners.len()),
    ] {
        constant(&root, name, &[count as i64])?;
    }
    let positions = padded(data.positions, data.dimension);
    let rows = ArrayView2::from_shape((points, 3), &positions[..]);
    let rows = rows.map_err(|error| hdf5::Error::from(error.to_string()))?;
    let made = root
        .new_dataset_builder()
        .chunk((ROWS.min(points.max(1)), 3));
    unit(&made.deflate(EFFORT).with_data(rows).create("Points")?, "m")?;
    let corners: Vec<i64> = cells
        .corners
        .iter()
        .map(|corner| i64::from(*corner))
        .collect();
    constant(&root, "Connectivity", &corners)?;
    let ends = cells.ends.iter().map(|end| *end as i64);
    let offsets: Vec<i64> = std::iter::once(0).chain(ends).collect();
    constant(&root, "Offsets", &offsets)?;
    constant(&root, "Types", data.kinds)
}

/// Empty tables of the outputs.
fn write_steps(file: &File) -> hdf5::Result<()> {
    let group = file.create_group(STEPS)?;
    group.new_attr::<i64>().create(COUNT)?.write_scalar(&0)?;
    unit(&growing::<f64>(&group, "Values", None, ROWS)?, "s")?;
    growing::<i64>(&group, "NumberOfParts", None, ROWS)?;
    for (name, by_topology) in OFFSETS {
        growing::<i64>(&group, name, by_topology.then_some(1), ROWS)?;
    }
    Ok(())
}

/// An empty field, a row for every point of every output.
fn create_field(group: &Group, field: &Field<'_>, points: usize) -> hdf5::Result<()> {
    let width = match field.components {
        1 => None,
        2 => Some(3),
        more => Some(more),
    };
    let rows = ROWS.min(points.max(1));
    unit(&growing::<f64>(group, field.name, width, rows)?, field.unit)
}

/// A list that stays as it is.
fn constant<T: H5Type>(group: &Group, name: &str, values: &[T]) -> hdf5::Result<()> {
    let made = group.new_dataset_builder();
    match values.is_empty() {
        // A list without entries has no chunks.
        true => made.with_data(values).create(name)?,
        false => made
            .chunk(ROWS.min(values.len()))
            .deflate(EFFORT)
            .with_data(values)
            .create(name)?,
    };
    Ok(())
}

/// An empty list, or table with rows of some `width`, that may grow.
fn growing<T: H5Type>(
    group: &Group,
    name: &str,
    width: Option<usize>,
    rows: usize,
) -> hdf5::Result<Dataset> {
    let made = group.new_dataset::<T>().deflate(EFFORT);
    match width {
        None => made.chunk(rows).shape(0..).create(name),
        Some(width) => made.chunk((rows, width)).shape((0.., width)).create(name),
    }
}

/// Tells the unit as VTK's XML files do.
fn unit(dataset: &Dataset, unit: &str) -> hdf5::Result<()> {
    let text = FixedAscii::<16>::from_ascii(unit);
    let text = text.map_err(|error| hdf5::Error::from(error.to_string()))?;
    let attribute = dataset.new_attr::<FixedAscii<16>>().create("UNITS_LABEL")?;
    attribute.write_scalar(&text)
}

/// Sets an entry of a list, which ends there.
fn add<T: H5Type>(list: &Dataset, step: usize, value: T) -> hdf5::Result<()> {
    list.resize(step + 1)?;
    list.write_slice(&[value], step..=step)
}

/// The same for a table with one column.
fn add_row(table: &Dataset, step: usize, value: i64) -> hdf5::Result<()> {
    table.resize((step + 1, 1))?;
    table.write_slice(&ndarray::arr2(&[[value]]), (step..=step, ..))
}

/// Sets the rows of a field at an output.
fn add_rows(dataset: &Dataset, step: usize, field: &Field<'_>) -> hdf5::Result<()> {
    let values = padded(field.values, field.components);
    let width = if field.components == 2 {
        3
    } else {
        field.components
    };
    let points = values.len() / width;
    let (begin, end) = (step * points, (step + 1) * points);
    if width == 1 {
        dataset.resize(end)?;
        return dataset.write_slice(&values[..], begin..end);
    }
    dataset.resize((end, width))?;
    let rows = ArrayView2::from_shape((points, width), &values[..]);
    let rows = rows.map_err(|error| hdf5::Error::from(error.to_string()))?;
    dataset.write_slice(rows, (begin..end, ..))
}

/// Number of outputs.
fn steps(file: &File) -> hdf5::Result<usize> {
    let count: i64 = file.group(STEPS)?.attr(COUNT)?.read_scalar()?;
    usize::try_from(count).map_err(|_| format!("it has {count} outputs").into())
}

fn set_steps(group: &Group, count: usize) -> hdf5::Result<()> {
    group.attr(COUNT)?.write_scalar(&(count as i64))
}

fn number_of_points(path: &Path) -> Result<usize, OutputError> {
    let read = File::open(path).and_then(|file| {
        let counts: Vec<i64> = file.dataset("VTKHDF/NumberOfPoints")?.read_raw()?;
        let count = counts
            .first()
            .and_then(|count| usize::try_from(*count).ok());
        count.ok_or_else(|| "it does not tell the number of its points".into())
    });
    read.map_err(|error| failed(path, "read it", &error))
}

fn failed(path: &Path, action: &'static str, error: &hdf5::Error) -> OutputError {
    OutputError::from_io(path, action, io::Error::other(error.to_string()))
}
