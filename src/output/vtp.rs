//! Lines with values as VTK poly data (`.vtp`).

use std::io::{self, Write};
use std::path::Path;

use super::vtk::{
    Cells, Field, check_fields, check_positions, write_fields, write_opening, write_points,
};
use super::{OutputError, write_atomically};

/// Everything that goes into one `.vtp` file.
#[derive(Debug, Clone, Copy)]
pub struct VtpData<'a> {
    /// Coordinates point by point, m. Shape `(points · dimension,)`.
    pub positions: &'a [f64],
    /// Space dimension, 2 or 3; a plane gets z = 0.
    pub dimension: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Chains of straight lines between the points.
    pub lines: Cells<'a>,
    /// Values of the chains.
    pub fields: &'a [Field<'a>],
}

/// Writes chains of lines and their values as a `.vtp` file, atomically.
///
/// # Errors
/// As [`write_vtu`](super::write_vtu).
pub fn write_vtp(path: impl AsRef<Path>, data: &VtpData<'_>) -> Result<(), OutputError> {
    let path = path.as_ref();
    let points = check_positions(path, data.positions, data.dimension)?;
    check_fields(path, data.fields, data.lines.ends.len())?;
    data.lines.check(path, points)?;
    write_atomically(path, |writer| write_document(writer, data, points))
}

fn write_document(writer: &mut dyn Write, data: &VtpData<'_>, points: usize) -> io::Result<()> {
    write_opening(writer, "PolyData", data.time)?;
    let lines = data.lines.ends.len();
    writeln!(
        writer,
        "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"{lines}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\">"
    )?;
    write_points(writer, data.positions, data.dimension)?;
    writeln!(writer, "<Lines>")?;
    data.lines.write(writer)?;
    writeln!(writer, "</Lines>\n<CellData>")?;
    write_fields(writer, data.fields)?;
    writeln!(writer, "</CellData>\n</Piece>\n</PolyData>\n</VTKFile>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_their_corners_and_values() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cracks.vtp");
        let fields = [Field {
            name: "opening",
            unit: "m",
            components: 1,
            values: &[1e-3, 2e-3],
        }];
        let data = VtpData {
            positions: &[0.0, 0.0, 1.0, 0.0, 1.0, 2.0],
            dimension: 2,
            time: 3.0,
            lines: Cells {
                corners: &[0, 1, 1, 2],
                ends: &[2, 4],
                ..Cells::default()
            },
            fields: &fields,
        };
        write_vtp(&path, &data).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let piece = document
            .descendants()
            .find(|node| node.has_tag_name("Piece"));
        assert_eq!(piece.unwrap().attribute("NumberOfLines"), Some("2"));
        let mut key = document
            .descendants()
            .filter(|node| node.has_tag_name("InformationKey"));
        assert_eq!(key.next_back().unwrap().text(), Some("m"));
        let beyond = VtpData {
            lines: Cells {
                corners: &[0, 1, 1, 3],
                ..data.lines
            },
            ..data
        };
        let refused = write_vtp(&path, &beyond);
        assert!(matches!(refused, Err(OutputError::Shape { found: 3, .. })));
    }
}
