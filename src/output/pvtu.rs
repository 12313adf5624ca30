//! The index of fields that several processes wrote piece by piece (`.pvtu`).

use std::io::{self, Write};
use std::path::Path;

use super::vtk::{Field, attributes_of, escape, write_unit};
use super::vtu::GHOSTS;
use super::{OutputError, write_atomically};

/// Writes the index of `pieces`, files beside it that hold the same fields at different points.
///
/// # Errors
/// Those of [`write_atomically`].
pub fn write_pvtu(
    path: impl AsRef<Path>,
    fields: &[Field<'_>],
    pieces: &[String],
) -> Result<(), OutputError> {
    write_atomically(path.as_ref(), |writer| write_index(writer, fields, pieces))
}

fn write_index(writer: &mut dyn Write, fields: &[Field<'_>], pieces: &[String]) -> io::Result<()> {
    writeln!(
        writer,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">\n<PUnstructuredGrid GhostLevel=\"0\">\n<PPoints>\n\
         <PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n</PPoints>\n\
         <PPointData>"
    )?;
    for field in fields {
        let attributes = attributes_of(field);
        writeln!(writer, "<PDataArray type=\"Float64\" {attributes}>")?;
        write_unit(writer, field.unit)?;
        writeln!(writer, "</PDataArray>")?;
    }
    writeln!(
        writer,
        "<PDataArray type=\"UInt8\" {GHOSTS}/>\n</PPointData>"
    )?;
    for piece in pieces {
        writeln!(writer, "<Piece Source=\"{}\"/>", escape(piece))?;
    }
    writeln!(writer, "</PUnstructuredGrid>\n</VTKFile>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_lists_every_field_once_and_every_piece() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fields-0000.pvtu");
        let field = |name, components| Field {
            name,
            unit: "Pa",
            components,
            values: &[],
        };
        let pieces = [
            "fields-0000-0.vtu".to_owned(),
            "fields-0000-1.vtu".to_owned(),
        ];
        write_pvtu(&path, &[field("pressure", 1), field("stress", 6)], &pieces).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let named = |tag: &str, attribute: &str| -> Vec<String> {
            let nodes = document.descendants().filter(|n| n.has_tag_name(tag));
            nodes
                .filter_map(|n| n.attribute(attribute).map(str::to_owned))
                .collect()
        };
        assert_eq!(named("Piece", "Source"), pieces);
        assert_eq!(
            named("PDataArray", "Name"),
            ["Points", "pressure", "stress", "vtkGhostType"]
        );
        assert_eq!(named("PDataArray", "NumberOfComponents"), ["3", "6"]);
        assert_eq!(named("InformationKey", "name"), ["UNITS_LABEL"; 2]);
    }
}
