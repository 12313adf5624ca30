//! Points of a mesh: one for each cell.

use std::path::Path;

use super::measure::measure;
use super::sets::{PointSet, point_sets};
use super::topology::Topology;
use super::{ElementKind, Mesh};
use crate::geometry::DualCells;
use crate::plan::files::{FileError, PointTable};

/// Points in SI units, with what a mesh tells of them beyond places and volumes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshTable {
    /// The points.
    pub table: PointTable,
    /// Smallest and largest coordinates of the cells, m.
    pub bounds: (Vec<f64>, Vec<f64>),
    /// Named sets, in the order of the file.
    pub sets: Vec<PointSet>,
    /// Cells whose corners are the points: around inner nodes, rings in a plane and polyhedra in space.
    pub dual: DualCells,
    /// Corners of each cell of a plane mesh in their order, m; empty in space.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Area of the cells on each side of the bounds, m^(D−1); shape `(2D,)`, low and high side of each axis.
    pub side_area: Vec<f64>,
    /// Balls that touch the free surfaces, which are the faces off the bounds, from outside: centre and radius, m.
    pub surface: Vec<(Vec<f64>, f64)>,
}

/// Coordinates may differ by this much of the largest extent along an axis across which they should not: rounding of a
/// text with ten digits.
const FLATNESS: f64 = 1e-9;
/// Share by which cells may overfill their bounds: rounding of coordinates.
const OVERFULL: f64 = 1e-9;

impl MeshTable {
    /// The points of a mesh in units of `unit` metres.
    ///
    /// # Errors
    /// [`FileError`] for meshes that are none of a plane or of space, and elements that fill nothing.
    pub(super) fn of(path: &Path, mesh: &Mesh, unit: f64) -> Result<Self, FileError> {
        let kinds = || mesh.elements.iter().map(|element| element.kind);
        let dimension = kinds().map(ElementKind::dimension).max().unwrap_or(0);
        if dimension < 2 {
            let what = "triangles, quadrilaterals or cells in space";
            return Err(FileError::Empty {
                path: path.to_path_buf(),
                what,
            });
        }
        let topology = Topology::of(mesh, dimension);
        check_distinct(path, mesh, &topology)?;
        let (lower, upper) = extremes(path, mesh, &topology)?;
        let largest = (0..3)
            .map(|axis| upper[axis] - lower[axis])
            .fold(0.0, f64::max);
        let high = upper[2] - lower[2];
        if dimension == 2 && high > FLATNESS * largest {
            return Err(FileError::Unsupported {
                path: path.to_path_buf(),
                what: "a surface that rises",
                found: format!("from z = {} to {}", lower[2], upper[2]),
                remedy: "mesh a plane of constant z, or a solid",
            });
        }
        let scaled = |corner: [f64; 3]| corner[..dimension].iter().map(|x| x * unit).collect();
        let bounds: (Vec<f64>, Vec<f64>) = (scaled(lower), scaled(upper));
        let table = points(path, mesh, &topology, unit)?;
        check_filling(path, &table, &bounds)?;
        let border = topology.border(mesh, [lower, upper], FLATNESS * largest, unit);
        Ok(MeshTable {
            sets: point_sets(mesh, &topology),
            dual: topology.dual(mesh),
            outlines: outlines(mesh, &topology, unit),
            side_area: border.side_area,
            surface: border.surface,
            table,
            bounds,
        })
    }
}

/// Corners of the cells of a plane mesh, m.
fn outlines(mesh: &Mesh, topology: &Topology, unit: f64) -> Vec<Vec<[f64; 2]>> {
    if topology.dimension > 2 {
        return Vec::new();
    }
    let corner = |node: &u32| {
        let [x, y, _] = mesh.nodes[*node as usize];
        [x * unit, y * unit]
    };
    let cells = topology
        .cells
        .iter()
        .map(|cell| &mesh.elements[*cell as usize].nodes);
    cells
        .map(|nodes| nodes.iter().map(corner).collect())
        .collect()
}

fn points(
    path: &Path,
    mesh: &Mesh,
    topology: &Topology,
    unit: f64,
) -> Result<PointTable, FileError> {
    let dimension = topology.dimension;
    let mut table = PointTable {
        dimension,
        ..PointTable::default()
    };
    for cell in &topology.cells {
        let element = &mesh.elements[*cell as usize];
        let measure = measure(element, &mesh.nodes).map_err(|fault| FileError::Element {
            path: path.to_path_buf(),
            label: element.label,
            kind: element.kind.name(),
            fault: fault.to_owned(),
        })?;
        table
            .position
            .extend(measure.centroid[..dimension].iter().map(|x| x * unit));
        table
            .volume
            .push(measure.volume.abs() * unit.powi(dimension as i32));
    }
    Ok(table)
}

/// Smallest and largest coordinates of the nodes that cells have.
fn extremes(
    path: &Path,
    mesh: &Mesh,
    topology: &Topology,
) -> Result<([f64; 3], [f64; 3]), FileError> {
    let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for cell in &topology.cells {
        let element = &mesh.elements[*cell as usize];
        for x in element.nodes.iter().map(|node| mesh.nodes[*node as usize]) {
            if x.iter().any(|x| !x.is_finite()) {
                return Err(FileError::Element {
                    path: path.to_path_buf(),
                    label: element.label,
                    kind: element.kind.name(),
                    fault: format!("it has a node at {x:?}; correct its coordinates"),
                });
            }
            for axis in 0..3 {
                lower[axis] = lower[axis].min(x[axis]);
                upper[axis] = upper[axis].max(x[axis]);
            }
        }
    }
    Ok((lower, upper))
}

/// Refuses cells with the same nodes.
fn check_distinct(path: &Path, mesh: &Mesh, topology: &Topology) -> Result<(), FileError> {
    let sorted = |cell: &u32| {
        let mut nodes = mesh.elements[*cell as usize].nodes.clone();
        nodes.sort_unstable();
        nodes
    };
    let mut order = topology.cells.clone();
    order.sort_by_cached_key(sorted);
    let same = order
        .windows(2)
        .find(|pair| sorted(&pair[0]) == sorted(&pair[1]));
    same.map_or(Ok(()), |pair| {
        let [first, second] = [pair[0], pair[1]].map(|cell| &mesh.elements[cell as usize]);
        Err(FileError::Element {
            path: path.to_path_buf(),
            label: second.label,
            kind: second.kind.name(),
            fault: format!("element {} has the same nodes; remove one", first.label),
        })
    })
}

/// Cells that overlap fill more than there is.
fn check_filling(
    path: &Path,
    table: &PointTable,
    (lower, upper): &(Vec<f64>, Vec<f64>),
) -> Result<(), FileError> {
    let filled: f64 = table.volume.iter().sum();
    let room: f64 = lower
        .iter()
        .zip(upper)
        .map(|(low, high)| high - low)
        .product();
    match filled <= room * (1.0 + OVERFULL) {
        true => Ok(()),
        false => Err(FileError::Damaged {
            path: path.to_path_buf(),
            place: None,
            reason: format!(
                "the cells overlap: they add up to {filled:e}, and their bounds hold {room:e}"
            ),
        }),
    }
}
