//! Cells of VTK unstructured grids, as a mesh.

use std::path::Path;

use roxmltree::{Document, Node};

use super::document::separate;
use super::{Grid, arrays, children};
use crate::plan::files::error::Place;
use crate::plan::files::mesh::{Element, ElementKind, Mesh};
use crate::plan::files::{FileError, utf8};

/// VTK's boxes along the axes, whose corners stand in another order.
const PIXEL: u64 = 8;
const VOXEL: u64 = 11;

/// Reads the nodes and cells of all pieces; a cell has its number in the file, from 0. There are no groups.
pub(in crate::plan::files) fn read_mesh(path: &Path, bytes: &[u8]) -> Result<Mesh, FileError> {
    let (xml, appended) = separate(path, bytes)?;
    let document = Document::parse(utf8(path, &xml)?).map_err(|error| FileError::Damaged {
        path: path.to_path_buf(),
        place: Some(Place::Line(error.pos().row as usize)),
        reason: error.to_string(),
    })?;
    let file = Grid::open(path, &document, appended)?;
    let mut mesh = Mesh::default();
    let grids = children(document.root_element(), "UnstructuredGrid");
    for piece in grids.flat_map(|grid| children(grid, "Piece")) {
        file.read_cells(piece, &mut mesh)?;
    }
    Ok(mesh)
}

impl Grid<'_, '_> {
    fn read_cells(&self, piece: Node<'_, '_>, mesh: &mut Mesh) -> Result<(), FileError> {
        let [points, cells] = [
            self.count(piece, "NumberOfPoints")?,
            self.count(piece, "NumberOfCells")?,
        ];
        if cells == 0 {
            return Ok(());
        }
        let first = mesh.nodes.len();
        let Some(positions) = arrays(piece, "Points").next() else {
            return Err(self.damaged(piece, "the piece has no <Points>".to_owned()));
        };
        let positions = self.values(positions, 3, points)?;
        mesh.nodes
            .extend(positions.chunks_exact(3).map(|x| [x[0], x[1], x[2]]));
        let kinds = self.whole(piece, "types", cells)?;
        let ends = self.whole(piece, "offsets", cells)?;
        let corners = ends.last().copied().unwrap_or(0) as usize;
        let corners = self.whole(piece, "connectivity", corners)?;
        let mut start = 0;
        for (kind, end) in kinds.into_iter().zip(ends) {
            let end = end as usize;
            let label = mesh.elements.len() as u64;
            let own = corners
                .get(start..end)
                .filter(|own| own.iter().all(|k| *k < points as u64));
            let Some(own) = own else {
                let reason = format!("cell {label} has corners that are not there");
                return Err(self.damaged(piece, reason));
            };
            let nodes = own
                .iter()
                .map(|corner| first as u32 + *corner as u32)
                .collect();
            mesh.elements.push(self.element(label, kind, nodes)?);
            start = end;
        }
        Ok(())
    }

    fn element(&self, label: u64, number: u64, mut nodes: Vec<u32>) -> Result<Element, FileError> {
        let (known, order): (u64, &[usize]) = match number {
            PIXEL => (9, &[0, 1, 3, 2]),
            VOXEL => (12, &[0, 1, 3, 2, 4, 5, 7, 6]),
            other => (other, &[]),
        };
        let kind = ElementKind::of_vtk(known).ok_or_else(|| FileError::Unsupported {
            path: self.path.to_path_buf(),
            what: "the type of cells",
            found: format!("{number} (cell {label})"),
            remedy: "save cells with straight edges; curved ones have numbers from 21 on, a polyhedron has 42",
        })?;
        let right = kind
            .corners()
            .map_or(nodes.len() > 2, |corners| corners == nodes.len());
        if !right {
            let fault = format!("it has {} corners; write the file again", nodes.len());
            return Err(FileError::Element {
                path: self.path.to_path_buf(),
                label,
                kind: kind.name(),
                fault,
            });
        }
        if !order.is_empty() {
            nodes = order.iter().map(|k| nodes[*k]).collect();
        }
        Ok(Element { label, kind, nodes })
    }

    fn count(&self, piece: Node<'_, '_>, name: &str) -> Result<usize, FileError> {
        let count = piece
            .attribute(name)
            .and_then(|text| text.trim().parse().ok());
        count.ok_or_else(|| self.damaged(piece, format!("{name} is missing or no number")))
    }

    /// Whole numbers of an array of the cells.
    fn whole(&self, piece: Node<'_, '_>, name: &str, count: usize) -> Result<Vec<u64>, FileError> {
        let node = arrays(piece, "Cells").find(|node| node.attribute("Name") == Some(name));
        let node =
            node.ok_or_else(|| self.damaged(piece, format!("its cells have no array `{name}`")))?;
        let values = self.values(node, 1, count)?;
        let whole = |value: f64| (value >= 0.0 && value.fract() == 0.0).then_some(value as u64);
        let values = values.into_iter().map(whole).collect::<Option<Vec<u64>>>();
        values.ok_or_else(|| {
            self.damaged(
                node,
                format!("array `{name}` has negative or broken numbers"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::files::{MeshTable, read_mesh};

    fn read(text: String) -> Result<MeshTable, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        std::fs::write(&path, text).unwrap();
        read_mesh(&path, 1.0)
    }

    fn refused(text: String, parts: &[&str]) {
        let message = read(text).unwrap_err().to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }

    fn near(found: &[f64], exact: &[f64]) {
        assert_eq!(found.len(), exact.len());
        assert!(
            found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12),
            "{found:?}"
        );
    }

    #[test]
    fn cells_of_a_vtu_file_are_read_and_pixels_put_in_order() {
        let file = |types: &str, cells: &str, ends: &str| {
            let array = |name: &str, text: &str| {
                format!(
                    "<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">{text}</DataArray>"
                )
            };
            format!(
                "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"6\" NumberOfCells=\"2\"><Points>\
                 <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 1 1 0 3 0 0 3 1 0</DataArray>\
                 </Points><Cells>{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
                array("connectivity", cells),
                array("offsets", ends),
                array("types", types)
            )
        };
        let mesh = read(file("8 9", "0 1 2 3 1 4 5 3", "4 8")).unwrap();
        near(&mesh.table.position, &[0.5, 0.5, 2.0, 0.5]);
        near(&mesh.table.volume, &[1.0, 2.0]);
        refused(file("22 9", "0 1 2 3 1 4 5 3", "4 8"), &["22 (cell 0)"]);
        refused(
            file("9 9", "0 1 2 3 1 4 5 9", "4 8"),
            &["cell 1 has corners"],
        );
        refused(file("9 9", "0 1 3 2 1 4 5 3", "4 3"), &["connectivity"]);
        refused(
            file("5 9", "0 1 3 2 1 4 5 3", "4 8"),
            &["element 0", "triangle", "4 corners"],
        );
    }
}
