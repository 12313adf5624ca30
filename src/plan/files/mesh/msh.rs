//! Meshes in the format of Gmsh, version 4.1, as text or binary.
//!
//! Sections that say nothing of nodes, elements and groups are skipped.

mod cursor;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::{Element, ElementKind, Group, Mesh};
use crate::plan::files::FileError;
use cursor::Cursor;

/// Reads a mesh; see [`super::read_mesh`].
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Mesh, FileError> {
    let mut cursor = Cursor::open(path, bytes)?;
    let mut file = File::default();
    while let Some(section) = cursor.section()? {
        match section.as_str() {
            "PhysicalNames" => file.names(&mut cursor)?,
            "Entities" => file.entities(&mut cursor)?,
            "Nodes" => file.nodes(&mut cursor)?,
            "Elements" => file.elements(&mut cursor)?,
            "PartitionedEntities" => {
                return Err(FileError::Unsupported {
                    path: path.to_path_buf(),
                    what: "the section",
                    found: section,
                    remedy: "save the mesh without partitions (in Gmsh: Mesh, Unpartition)",
                });
            }
            _ => cursor.skip(&section)?,
        }
        cursor.end(&section)?;
    }
    Ok(file.mesh)
}

/// Dimension and number of an entity of the geometry, or of a physical group.
type Key = (i32, i32);

/// What is known of the file so far.
#[derive(Default)]
struct File {
    mesh: Mesh,
    /// Names of physical groups.
    names: BTreeMap<Key, String>,
    /// Physical groups of the entities.
    physical: HashMap<Key, Vec<i32>>,
    /// Places of the nodes by their numbers in the file.
    place: HashMap<u64, u32>,
    /// Place of each group in the mesh.
    groups: HashMap<Key, usize>,
}

impl File {
    /// Lines of dimension, number and quoted name; text in binary files as well.
    fn names(&mut self, cursor: &mut Cursor<'_>) -> Result<(), FileError> {
        let count: u64 = cursor.number("the number of names")?;
        for _ in 0..count {
            let key = (cursor.number("a dimension")?, cursor.number("a group")?);
            self.names.insert(key, cursor.quoted()?);
        }
        Ok(())
    }

    fn entities(&mut self, cursor: &mut Cursor<'_>) -> Result<(), FileError> {
        let counts = [(); 4].map(|()| cursor.size("a number of entities"));
        for (dimension, count) in (0_i32..).zip(counts) {
            for _ in 0..count? {
                let tag = cursor.int("an entity")?;
                // A place, or the corners of a box.
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    cursor.real("a coordinate of an entity")?;
                }
                let mut groups = Vec::new();
                for _ in 0..cursor.size("a number of groups")? {
                    // The sign tells an orientation.
                    groups.push(cursor.int("a group")?.saturating_abs());
                }
                if dimension > 0 {
                    for _ in 0..cursor.size("a number of bounding entities")? {
                        cursor.int("a bounding entity")?;
                    }
                }
                self.physical.insert((dimension, tag), groups);
            }
        }
        Ok(())
    }

    fn nodes(&mut self, cursor: &mut Cursor<'_>) -> Result<(), FileError> {
        let blocks = cursor.size("the number of blocks")?;
        for what in ["the number of nodes", "the lowest node", "the highest node"] {
            cursor.size(what)?;
        }
        for _ in 0..blocks {
            let dimension = cursor.int("a dimension")?;
            cursor.int("an entity")?;
            let parametric = cursor.int("whether nodes are parametric")? != 0;
            let count = cursor.size("the number of nodes of a block")?;
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(cursor.size("a node")?);
            }
            let parameters = if parametric { dimension.clamp(0, 3) } else { 0 };
            for tag in tags {
                let mut node = [0.0; 3];
                for x in &mut node {
                    *x = cursor.real("a coordinate")?;
                }
                for _ in 0..parameters {
                    cursor.real("a parameter of a node")?;
                }
                if self
                    .place
                    .insert(tag, self.mesh.nodes.len() as u32)
                    .is_some()
                {
                    return Err(cursor.damaged(format!("node {tag} is there twice")));
                }
                self.mesh.nodes.push(node);
            }
        }
        Ok(())
    }

    fn elements(&mut self, cursor: &mut Cursor<'_>) -> Result<(), FileError> {
        let blocks = cursor.size("the number of blocks")?;
        for what in [
            "the number of elements",
            "the lowest element",
            "the highest element",
        ] {
            cursor.size(what)?;
        }
        for _ in 0..blocks {
            let entity = (cursor.int("a dimension")?, cursor.int("an entity")?);
            let (kind, corners) = kind(cursor)?;
            let groups = self.groups_of(entity);
            for _ in 0..cursor.size("the number of elements of a block")? {
                let label = cursor.size("an element")?;
                let mut nodes = Vec::with_capacity(corners);
                for _ in 0..corners {
                    let tag = cursor.size("a node of an element")?;
                    let place = self.place.get(&tag).copied();
                    nodes.push(place.ok_or_else(|| {
                        cursor.damaged(format!(
                            "element {label} has node {tag}, which is not there"
                        ))
                    })?);
                }
                let number = self.mesh.elements.len() as u32;
                self.mesh.elements.push(Element { label, kind, nodes });
                for group in &groups {
                    self.mesh.groups[*group].members.push(number);
                }
            }
        }
        Ok(())
    }

    /// Places of the groups that an entity belongs to.
    fn groups_of(&mut self, entity: Key) -> Vec<usize> {
        let tags = self.physical.get(&entity).cloned().unwrap_or_default();
        let mut place = |tag: i32| {
            let key = (entity.0, tag);
            *self.groups.entry(key).or_insert_with(|| {
                let name = self.names.get(&key).cloned();
                let name = name.unwrap_or_else(|| tag.to_string());
                let members = Vec::new();
                self.mesh.groups.push(Group { name, members });
                self.mesh.groups.len() - 1
            })
        };
        tags.into_iter().map(&mut place).collect()
    }
}

/// Form and number of corners of the elements of a block.
fn kind(cursor: &mut Cursor<'_>) -> Result<(ElementKind, usize), FileError> {
    let number = cursor.int("a type of elements")?;
    let kind = match number {
        15 => ElementKind::Vertex,
        1 => ElementKind::Line,
        2 => ElementKind::Triangle,
        3 => ElementKind::Quadrilateral,
        4 => ElementKind::Tetrahedron,
        5 => ElementKind::Hexahedron,
        6 => ElementKind::Wedge,
        7 => ElementKind::Pyramid,
        other => {
            return Err(FileError::Unsupported {
                path: cursor.path().to_path_buf(),
                what: "the type of elements",
                found: match name_of_curved(other) {
                    Some(name) => format!("{name} ({other})"),
                    None => other.to_string(),
                },
                remedy: "mesh with straight edges (in Gmsh: Mesh, Set order 1, or Mesh.ElementOrder = 1)",
            });
        }
    };
    // Only polygons have any number, and Gmsh writes none.
    Ok((kind, kind.corners().unwrap_or(0)))
}

/// Names of Gmsh's elements of second order.
fn name_of_curved(number: i32) -> Option<&'static str> {
    Some(match number {
        8 => "3-node line",
        9 => "6-node triangle",
        10 => "9-node quadrilateral",
        11 => "10-node tetrahedron",
        12 => "27-node hexahedron",
        13 => "18-node prism",
        14 => "14-node pyramid",
        16 => "8-node quadrilateral",
        17 => "20-node hexahedron",
        18 => "15-node prism",
        19 => "13-node pyramid",
        _ => return None,
    })
}
