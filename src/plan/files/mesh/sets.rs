//! Named sets of points from the groups of a mesh.

use super::Mesh;
use super::topology::Topology;

/// Points under a name.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSet {
    /// Name of the group in the file.
    pub name: String,
    /// Its points, ascending.
    pub points: Vec<u32>,
}

/// A group of cells has their points. One of edges or faces has the points of all cells that have one of these, and one of nodes
/// those of cells with a side all of whose corners are in it.
pub(super) fn point_sets(mesh: &Mesh, topology: &Topology) -> Vec<PointSet> {
    let mut sets: Vec<PointSet> = Vec::new();
    for group in &mesh.groups {
        let of_element = |number: &u32| {
            let element = &mesh.elements[*number as usize];
            match element.kind.dimension() == topology.dimension {
                true => vec![topology.point[*number as usize]],
                false => topology.with_all(&element.nodes),
            }
        };
        let points = group.members.iter().flat_map(of_element);
        add(&mut sets, &group.name, points);
    }
    for group in &mesh.node_groups {
        let mut within = vec![false; mesh.nodes.len()];
        group
            .members
            .iter()
            .for_each(|node| within[*node as usize] = true);
        let touching = |(_, cell): &(u32, &u32)| {
            let element = &mesh.elements[**cell as usize];
            let sides = Topology::sides(element);
            sides
                .iter()
                .any(|side| side.iter().all(|node| within[*node as usize]))
        };
        let points = (0_u32..).zip(&topology.cells).filter(touching);
        add(&mut sets, &group.name, points.map(|(point, _)| point));
    }
    for set in &mut sets {
        set.points.sort_unstable();
        set.points.dedup();
    }
    sets
}

fn add(sets: &mut Vec<PointSet>, name: &str, points: impl Iterator<Item = u32>) {
    match sets.iter_mut().find(|set| set.name == name) {
        Some(set) => set.points.extend(points),
        None => sets.push(PointSet {
            name: name.to_owned(),
            points: points.collect(),
        }),
    }
}
