//! Cells between the points of a mesh in space: a polyhedron around every inner node.

use std::collections::{BTreeMap, HashMap};

use super::topology::Topology;
use super::{Mesh, NodeNumber};

/// Faces of the cells, and which two cells have each.
struct Faces {
    /// Nodes and number of each face of a cell.
    of_cell: Vec<Vec<(Vec<NodeNumber>, usize)>>,
    /// Cells of each face; the largest number where there is only one.
    cells: Vec<[u32; 2]>,
}

/// Polyhedra whose corners are the cells around each inner node, by their faces, each a ring of the cells around
/// an edge.
pub(super) fn solids(mesh: &Mesh, topology: &Topology) -> Vec<Vec<Vec<u32>>> {
    let faces = Faces::of(mesh, topology);
    let nodes = 0..mesh.nodes.len() as NodeNumber;
    let around = |node: NodeNumber| faces.around(node, topology.around(node));
    nodes.filter_map(around).collect()
}

impl Faces {
    fn of(mesh: &Mesh, topology: &Topology) -> Self {
        let mut number = HashMap::new();
        let mut faces = Faces {
            of_cell: Vec::with_capacity(topology.cells.len()),
            cells: Vec::new(),
        };
        for (point, cell) in (0_u32..).zip(&topology.cells) {
            let mut own = Vec::new();
            for side in Topology::sides(&mesh.elements[*cell as usize]) {
                let mut key = side.clone();
                key.sort_unstable();
                let face = *number.entry(key).or_insert_with(|| {
                    faces.cells.push([u32::MAX; 2]);
                    faces.cells.len() - 1
                });
                let place = faces.cells[face]
                    .iter()
                    .position(|other| *other == u32::MAX);
                // More than two cells at a face are no mesh of space; their nodes close nowhere.
                if let Some(place) = place {
                    faces.cells[face][place] = point;
                }
                own.push((side, face));
            }
            faces.of_cell.push(own);
        }
        faces
    }

    /// The polyhedron around a node; none where a face at it has a cell on one side only.
    fn around(&self, node: NodeNumber, around: &[u32]) -> Option<Vec<Vec<u32>>> {
        // Cells and their faces at each edge from the node.
        let mut at_edge: BTreeMap<NodeNumber, Vec<(u32, usize)>> = BTreeMap::new();
        for point in around {
            for (ring, face) in &self.of_cell[*point as usize] {
                let Some(at) = ring.iter().position(|own| *own == node) else {
                    continue;
                };
                if self.cells[*face][1] == u32::MAX {
                    return None;
                }
                for beside in [at + 1, at + ring.len() - 1] {
                    let end = ring[beside % ring.len()];
                    at_edge.entry(end).or_default().push((*point, *face));
                }
            }
        }
        let rings = at_edge.values().map(|sides| self.ring(sides));
        let rings = rings.collect::<Option<Vec<Vec<u32>>>>()?;
        (rings.len() > 3).then_some(rings)
    }

    /// The cells around an edge, one after another through the faces between them.
    fn ring(&self, sides: &[(u32, usize)]) -> Option<Vec<u32>> {
        let &(first, mut face) = sides.first()?;
        let (mut ring, mut cell) = (vec![first], first);
        loop {
            let next = self.cells[face].iter().find(|other| **other != cell)?;
            if *next == first {
                break;
            }
            let beyond = sides
                .iter()
                .find(|(own, other)| own == next && *other != face)?;
            (cell, face) = *beyond;
            ring.push(cell);
            if 2 * ring.len() > sides.len() {
                return None;
            }
        }
        (ring.len() > 2 && 2 * ring.len() == sides.len()).then_some(ring)
    }
}
