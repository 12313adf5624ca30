//! Which cells of a mesh meet at a node, and what they leave open.

use std::collections::HashMap;

use super::measure::measure;
use super::solids::solids;
use super::{Element, ElementKind, Mesh, NodeNumber};
use crate::geometry::{CellKind, DualCells};

/// The cells of a mesh as points, and their neighbours.
pub(super) struct Topology {
    /// 2 or 3.
    pub(super) dimension: usize,
    /// Elements that are cells, in the order of the file, which is that of the points.
    pub(super) cells: Vec<u32>,
    /// Point of each element that is a cell; the largest number for others.
    pub(super) point: Vec<u32>,
    /// Points of the cells at each node.
    around: Vec<Vec<u32>>,
}

impl Topology {
    /// The cells of the given dimension.
    pub(super) fn of(mesh: &Mesh, dimension: usize) -> Self {
        let mut topology = Topology {
            dimension,
            cells: Vec::new(),
            point: vec![u32::MAX; mesh.elements.len()],
            around: vec![Vec::new(); mesh.nodes.len()],
        };
        for (number, element) in (0_u32..).zip(&mesh.elements) {
            if element.kind.dimension() != dimension {
                continue;
            }
            let point = topology.cells.len() as u32;
            topology.cells.push(number);
            topology.point[number as usize] = point;
            for node in &element.nodes {
                let around = &mut topology.around[*node as usize];
                // Nodes of an element may be the same.
                if around.last() != Some(&point) {
                    around.push(point);
                }
            }
        }
        topology
    }

    /// Points of the cells at a node.
    pub(in crate::plan::files) fn around(&self, node: NodeNumber) -> &[u32] {
        &self.around[node as usize]
    }

    /// Edges of a plane cell, faces of one in space, by their nodes; of a cell with several corners at a node those
    /// that are left.
    pub(in crate::plan::files) fn sides(element: &Element) -> Vec<Vec<NodeNumber>> {
        let nodes = &element.nodes;
        let mut sides: Vec<Vec<NodeNumber>> = match element.kind.dimension() {
            3 => {
                let faces = element.kind.faces().iter();
                let face = |face: &&[usize]| face.iter().map(|k| nodes[*k]).collect();
                faces.map(face).collect()
            }
            _ => (0..nodes.len())
                .map(|k| vec![nodes[k], nodes[(k + 1) % nodes.len()]])
                .collect(),
        };
        for side in &mut sides {
            side.dedup();
            if side.len() > 1 && side.first() == side.last() {
                side.pop();
            }
        }
        sides.retain(|side| side.len() >= element.kind.dimension());
        sides
    }

    /// Points of the cells that have all of some nodes.
    pub(super) fn with_all(&self, nodes: &[NodeNumber]) -> Vec<u32> {
        let Some((first, others)) = nodes.split_first() else {
            return Vec::new();
        };
        let has = |point: &u32| {
            let mut others = others.iter();
            others.all(|node| self.around[*node as usize].contains(point))
        };
        let first = self.around[*first as usize].iter();
        first.copied().filter(has).collect()
    }

    /// Cells whose corners are points, around every inner node: rings of a plane mesh, polyhedra in space.
    pub(super) fn dual(&self, mesh: &Mesh) -> DualCells {
        let mut dual = DualCells::default();
        if self.dimension != 2 {
            dual.solids = solids(mesh, self);
            return dual;
        }
        let turned = |cell: &u32| {
            let area = measure(&mesh.elements[*cell as usize], &mesh.nodes);
            area.is_ok_and(|area| area.volume < 0.0)
        };
        let turned: Vec<bool> = self.cells.iter().map(turned).collect();
        for (node, around) in (0_u32..).zip(&self.around) {
            let Some(ring) = self.ring(mesh, &turned, node, around) else {
                continue;
            };
            let kind = match ring.len() {
                3 => CellKind::Triangle,
                4 => CellKind::Quadrilateral,
                _ => CellKind::Polygon,
            };
            dual.push(kind, ring);
        }
        dual
    }

    /// The cells around a node counter-clockwise, if they close around it.
    fn ring(
        &self,
        mesh: &Mesh,
        turned: &[bool],
        node: NodeNumber,
        around: &[u32],
    ) -> Option<Vec<u32>> {
        // Nodes after and before this one along the edge of a cell.
        let beside = |point: u32| {
            let nodes = &mesh.elements[self.cells[point as usize] as usize].nodes;
            let at = nodes.iter().position(|own| *own == node)?;
            let after = nodes[(at + 1) % nodes.len()];
            let before = nodes[(at + nodes.len() - 1) % nodes.len()];
            Some(if turned[point as usize] {
                [before, after]
            } else {
                [after, before]
            })
        };
        let mut next = HashMap::new();
        for point in around {
            let [after, before] = beside(*point)?;
            next.insert(after, (*point, before));
        }
        let start = beside(*around.first()?)?[0];
        let (mut ring, mut at) = (Vec::new(), start);
        while ring.len() < around.len() {
            let (point, before) = next.get(&at)?;
            ring.push(*point);
            at = *before;
        }
        (at == start && ring.len() > 2).then_some(ring)
    }
}

impl ElementKind {
    /// The form with a number in VTK, if its edges are straight.
    pub(in crate::plan::files) fn of_vtk(number: u64) -> Option<Self> {
        Some(match number {
            1 => Self::Vertex,
            3 => Self::Line,
            5 => Self::Triangle,
            7 => Self::Polygon,
            9 => Self::Quadrilateral,
            10 => Self::Tetrahedron,
            12 => Self::Hexahedron,
            13 => Self::Wedge,
            14 => Self::Pyramid,
            _ => return None,
        })
    }
}
