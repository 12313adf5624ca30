//! Fields at points as VTK unstructured grids (`.vtu`).

use std::io::{self, Write};
use std::path::Path;

use super::vtk::{
    Cells, Field, check_fields, check_positions, write_array, write_fields, write_opening,
    write_points,
};
use super::{OutputError, write_atomically};

/// Everything that goes into one `.vtu` file.
#[derive(Debug, Clone, Copy)]
pub struct VtuData<'a> {
    /// Coordinates point by point, m. Shape `(points · dimension,)`.
    pub positions: &'a [f64],
    /// Space dimension, 2 or 3; a plane gets z = 0.
    pub dimension: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Cells between the points.
    pub cells: Cells<'a>,
    /// Number that VTK gives to the kind of each cell. Shape `(cells,)`.
    pub kinds: &'a [u8],
    /// Fields at the points.
    pub fields: &'a [Field<'a>],
    /// Of a piece of several, how many of the last points are those of other pieces, which cells need.
    pub ghosts: Option<usize>,
}

/// Array by which VTK knows points that belong to another piece; its value for them.
pub(super) const GHOSTS: &str = "Name=\"vtkGhostType\"";
const DUPLICATE: u8 = 1;

/// Writes points, the cells between them and their fields as a `.vtu` file, atomically.
///
/// # Errors
/// [`OutputError::Unsupported`] for a dimension or number of components the format lacks,
/// [`OutputError::Shape`] for arrays of the wrong length, else those of [`write_atomically`].
pub fn write_vtu(path: impl AsRef<Path>, data: &VtuData<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    let points = check_positions(path, data.positions, data.dimension)?;
    check_fields(path, data.fields, points)?;
    data.cells.check(path, points)?;
    let cells = data.cells.ends.len();
    OutputError::check_length(path, "the kinds of cells", cells, data.kinds.len())?;
    write_atomically(path, |writer| write_document(writer, data, points))
}

fn write_document(writer: &mut dyn Write, data: &VtuData<'_>, points: usize) -> io::Result<()> {
    write_opening(writer, "UnstructuredGrid", data.time)?;
    let cells = data.cells.ends.len();
    writeln!(
        writer,
        "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
    )?;
    write_points(writer, data.positions, data.dimension)?;
    writeln!(writer, "<Cells>")?;
    data.cells.write(writer)?;
    write_array(writer, "UInt8", "Name=\"types\"", "", data.kinds)?;
    writeln!(writer, "</Cells>\n<PointData>")?;
    write_fields(writer, data.fields)?;
    if let Some(ghosts) = data.ghosts {
        let mut kinds = vec![0; points.saturating_sub(ghosts)];
        kinds.resize(points, DUPLICATE);
        write_array(writer, "UInt8", GHOSTS, "", &kinds)?;
    }
    writeln!(
        writer,
        "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>"
    )
}

#[cfg(test)]
#[path = "vtu_tests.rs"]
mod tests;
