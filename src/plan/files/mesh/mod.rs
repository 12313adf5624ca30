//! Meshes of finite elements as clouds: each cell becomes a point at its centroid, with its volume.

mod border;
mod inp;
mod measure;
mod msh;
mod points;
mod sets;
mod solids;
mod topology;

use std::path::Path;

use super::{FileError, extension, read_bytes, vtu, wrong_extension};

pub(crate) use points::MeshTable;
pub use sets::PointSet;

/// A mesh as a file has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::plan::files) struct Mesh {
    /// Positions of the nodes, in units of the file.
    pub(in crate::plan::files) nodes: Vec<[f64; 3]>,
    /// Cells, and the edges and faces that groups hold.
    pub(in crate::plan::files) elements: Vec<Element>,
    /// Named groups of elements.
    pub(in crate::plan::files) groups: Vec<Group<ElementNumber>>,
    /// Named groups of nodes.
    pub(in crate::plan::files) node_groups: Vec<Group<NodeNumber>>,
}

/// Place of an element in [`Mesh::elements`].
pub(in crate::plan::files) type ElementNumber = u32;
/// Place of a node in [`Mesh::nodes`].
pub(in crate::plan::files) type NodeNumber = u32;

/// One element.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::plan::files) struct Element {
    /// Number in the file.
    pub(in crate::plan::files) label: u64,
    /// Its form.
    pub(in crate::plan::files) kind: ElementKind,
    /// Its nodes, in the order of VTK.
    pub(in crate::plan::files) nodes: Vec<NodeNumber>,
}

/// Elements or nodes under a name.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::plan::files) struct Group<T> {
    /// Name in the file; its number where it has none.
    pub(in crate::plan::files) name: String,
    /// Its members, in the order of the file.
    pub(in crate::plan::files) members: Vec<T>,
}

/// Form of an element with straight edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::plan::files) enum ElementKind {
    /// A node.
    Vertex,
    /// An edge.
    Line,
    /// A triangle.
    Triangle,
    /// Four corners in a ring.
    Quadrilateral,
    /// Any number of corners in a ring.
    Polygon,
    /// Four corners in space.
    Tetrahedron,
    /// A quadrilateral and an apex.
    Pyramid,
    /// Two triangles.
    Wedge,
    /// Two quadrilaterals.
    Hexahedron,
}

impl ElementKind {
    /// The form with a name in the format of a file.
    pub(in crate::plan::files) fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Line => "line",
            Self::Triangle => "triangle",
            Self::Quadrilateral => "quadrilateral",
            Self::Polygon => "polygon",
            Self::Tetrahedron => "tetrahedron",
            Self::Pyramid => "pyramid",
            Self::Wedge => "wedge",
            Self::Hexahedron => "hexahedron",
        }
    }

    /// Dimension of what it fills.
    pub(in crate::plan::files) fn dimension(self) -> usize {
        match self {
            Self::Vertex => 0,
            Self::Line => 1,
            Self::Triangle | Self::Quadrilateral | Self::Polygon => 2,
            Self::Tetrahedron | Self::Pyramid | Self::Wedge | Self::Hexahedron => 3,
        }
    }

    /// Number of corners; none for polygons, which have any.
    pub(in crate::plan::files) fn corners(self) -> Option<usize> {
        Some(match self {
            Self::Vertex => 1,
            Self::Line => 2,
            Self::Triangle => 3,
            Self::Quadrilateral | Self::Tetrahedron => 4,
            Self::Polygon => return None,
            Self::Pyramid => 5,
            Self::Wedge => 6,
            Self::Hexahedron => 8,
        })
    }

    /// Faces of a cell in space by its corners, normals outwards.
    pub(in crate::plan::files) fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Self::Pyramid => &[
                &[0, 3, 2, 1],
                &[0, 1, 4],
                &[1, 2, 4],
                &[2, 3, 4],
                &[3, 0, 4],
            ],
            Self::Wedge => &[
                &[0, 2, 1],
                &[3, 4, 5],
                &[0, 1, 4, 3],
                &[1, 2, 5, 4],
                &[2, 0, 3, 5],
            ],
            Self::Hexahedron => &[
                &[0, 3, 2, 1],
                &[4, 5, 6, 7],
                &[0, 1, 5, 4],
                &[1, 2, 6, 5],
                &[2, 3, 7, 6],
                &[3, 0, 4, 7],
            ],
            Self::Vertex | Self::Line | Self::Triangle | Self::Quadrilateral | Self::Polygon => &[],
        }
    }
}

/// Reads a mesh from a `.msh` (Gmsh 4.1, text or binary), `.inp` (Abaqus) or `.vtu` file, as points in metres;
/// `unit` is the length of one unit of the file, m.
///
/// The cells are the elements of the highest dimension. Those of lower ones count for groups alone.
///
/// # Errors
/// [`FileError`] for a file that cannot be read, has another format, curved or folded elements, or a surface that is
/// no plane of constant z.
pub(crate) fn read_mesh(path: &Path, unit: f64) -> Result<MeshTable, FileError> {
    let mesh = match extension(path)?.as_str() {
        "msh" => msh::read(path, &read_bytes(path)?)?,
        "inp" => inp::read(path, &read_bytes(path)?)?,
        "vtu" => vtu::read_mesh(path, &read_bytes(path)?)?,
        other => return Err(wrong_extension(path, other, "`.msh`, `.inp` and `.vtu`")),
    };
    MeshTable::of(path, &mesh, unit)
}

#[cfg(test)]
mod tests;
