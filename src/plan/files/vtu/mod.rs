//! Points from VTK unstructured grids (`.vtu`, VTK XML file format).

mod array;
mod cells;
mod document;

use std::collections::BTreeMap;
use std::path::Path;

use roxmltree::{Document, Node};

pub(super) use self::cells::read_mesh;
use self::document::{Appended, Layout, separate};
use super::columns::Columns;
use super::values::{Allowed, check};
use super::{FileError, Place, PointTable, utf8};

/// z may differ by this much of the largest extent in a plane: rounding of the writer.
const FLATNESS: f64 = 1e-12;

/// Reads points; see [`super::read_points`].
pub(super) fn read_points(path: &Path, bytes: &[u8]) -> Result<PointTable, FileError> {
    let (xml, appended) = separate(path, bytes)?;
    let document = Document::parse(utf8(path, &xml)?).map_err(|error| {
        let place = Some(Place::Line(error.pos().row as usize));
        FileError::Damaged {
            path: path.to_path_buf(),
            place,
            reason: error.to_string(),
        }
    })?;
    let file = Grid::open(path, &document, appended)?;
    let mut found = Found::default();
    for piece in children(document.root_element(), "UnstructuredGrid")
        .flat_map(|grid| children(grid, "Piece"))
    {
        file.read_piece(piece, &mut found)?;
    }
    found.into_table(path)
}

/// Values of an array of one component per point, as this program writes it.
///
/// # Errors
/// [`FileError`] if the file is no such grid or has no such array.
pub fn read_array(path: &Path, name: &str) -> Result<Vec<f64>, FileError> {
    in_first_piece(path, |file, piece, count| {
        let mut all = arrays(piece, "PointData");
        match all.find(|node| node.attribute("Name") == Some(name)) {
            Some(node) => file.values(node, 1, count),
            None => Err(FileError::Damaged {
                path: path.to_path_buf(),
                place: None,
                reason: format!("it has no array `{name}`"),
            }),
        }
    })
}

/// All that a file has at its points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointFields {
    /// Simulated time, s, if the file tells it.
    pub time: Option<f64>,
    /// Three coordinates per point, m.
    pub positions: Vec<f64>,
    /// Components per point and values of each array by its name.
    pub arrays: BTreeMap<String, (usize, Vec<f64>)>,
}

/// Places of the points and all arrays at them, of a file that this program wrote.
///
/// # Errors
/// [`FileError`] if the file is no such grid.
pub fn read_fields(path: &Path) -> Result<PointFields, FileError> {
    in_first_piece(path, |file, piece, count| {
        let mut fields = PointFields::default();
        let mut whole = piece
            .parent()
            .into_iter()
            .flat_map(|grid| arrays(grid, "FieldData"));
        if let Some(time) = whole.find(|node| node.attribute("Name") == Some("TimeValue")) {
            fields.time = file.values(time, 1, 1)?.first().copied();
        }
        if let Some(points) = arrays(piece, "Points").next() {
            fields.positions = file.values(points, 3, count)?;
        }
        for node in arrays(piece, "PointData") {
            let components = node.attribute("NumberOfComponents").unwrap_or("1").trim();
            let components = components.parse().unwrap_or(1);
            let name = node.attribute("Name").unwrap_or("").to_owned();
            let values = file.values(node, components, count)?;
            fields.arrays.insert(name, (components, values));
        }
        Ok(fields)
    })
}

/// Reads what is wanted of the first piece, with its number of points.
fn in_first_piece<T>(
    path: &Path,
    read: impl FnOnce(&Grid<'_, '_>, Node<'_, '_>, usize) -> Result<T, FileError>,
) -> Result<T, FileError> {
    let bytes = super::read_bytes(path)?;
    let (xml, appended) = separate(path, &bytes)?;
    let damaged = |reason: String| FileError::Damaged {
        path: path.to_path_buf(),
        place: None,
        reason,
    };
    let document = Document::parse(utf8(path, &xml)?).map_err(|e| damaged(e.to_string()))?;
    let file = Grid::open(path, &document, appended)?;
    let grids = children(document.root_element(), "UnstructuredGrid");
    let Some(piece) = grids.flat_map(|grid| children(grid, "Piece")).next() else {
        return Err(damaged("it has no piece".to_owned()));
    };
    let count = piece.attribute("NumberOfPoints");
    let count = count.and_then(|text| text.trim().parse().ok()).unwrap_or(0);
    read(&file, piece, count)
}

/// Values joined from all pieces.
#[derive(Debug, Default)]
struct Found {
    /// Three per point, m.
    position: Vec<f64>,
    volume: Vec<f64>,
    /// Empty if the file gives none.
    permeability: Vec<f64>,
    /// Unit in the name of `volume`, if there is one.
    volume_unit: Option<&'static str>,
}

impl Found {
    fn into_table(self, path: &Path) -> Result<PointTable, FileError> {
        self.check(path)?;
        let dimension = if is_flat(&self.position) { 2 } else { 3 };
        let unit = if dimension == 2 { "m2" } else { "m3" };
        if let Some(found) = self.volume_unit.filter(|&found| found != unit) {
            return Err(FileError::WrongUnit {
                path: path.to_path_buf(),
                column: format!("volume_{found}"),
                name: "volume".to_owned(),
                unit: found.to_owned(),
                expected: unit,
            });
        }
        let position = self
            .position
            .chunks_exact(3)
            .flat_map(|point| &point[..dimension]);
        Ok(PointTable {
            dimension,
            position: position.copied().collect(),
            volume: self.volume,
            material: None,
            permeability: (!self.permeability.is_empty()).then_some(self.permeability),
        })
    }

    fn check(&self, path: &Path) -> Result<(), FileError> {
        if self.volume.is_empty() {
            return Err(FileError::Empty {
                path: path.to_path_buf(),
                what: "points",
            });
        }
        let point = |index| Place::Index(index / 3);
        check(path, "a coordinate", Allowed::Finite, &self.position, point)?;
        check(
            path,
            "volume",
            Allowed::Positive,
            &self.volume,
            Place::Index,
        )?;
        check(
            path,
            "permeability",
            Allowed::Positive,
            &self.permeability,
            Place::Index,
        )
    }
}

fn is_flat(position: &[f64]) -> bool {
    let extent = |axis: usize| {
        let values = position.iter().skip(axis).step_by(3);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
            (low.min(value), high.max(value))
        });
        high - low
    };
    extent(2) <= FLATNESS * extent(0).max(extent(1)).max(extent(2))
}

/// An opened file: its layout and its path for messages.
#[derive(Debug)]
struct Grid<'a, 'input> {
    path: &'a Path,
    document: &'a Document<'input>,
    layout: Layout<'a>,
}

impl<'a, 'input> Grid<'a, 'input> {
    fn open(
        path: &'a Path,
        document: &'a Document<'input>,
        appended: Option<Appended<'a>>,
    ) -> Result<Self, FileError> {
        let layout = Layout::new(path, document.root_element(), appended)?;
        Ok(Self {
            path,
            document,
            layout,
        })
    }

    fn read_piece(&self, piece: Node<'_, '_>, found: &mut Found) -> Result<(), FileError> {
        let count: Option<usize> = piece
            .attribute("NumberOfPoints")
            .and_then(|text| text.trim().parse().ok());
        let Some(count) = count else {
            return Err(self.damaged(piece, "NumberOfPoints is missing or no number".to_owned()));
        };
        if count == 0 {
            return Ok(());
        }
        let Some(points) = arrays(piece, "Points").next() else {
            return Err(self.damaged(piece, "the piece has no <Points>".to_owned()));
        };
        found.position.extend(self.values(points, 3, count)?);
        let data: Vec<_> = arrays(piece, "PointData").collect();
        let names = data
            .iter()
            .map(|node| node.attribute("Name").unwrap_or("").to_owned());
        let columns = Columns::new(self.path, "point data", names.collect())?;
        let (volume, unit) = volume_of(&columns)?;
        found.volume_unit = found.volume_unit.or(unit);
        found.volume.extend(self.values(data[volume], 1, count)?);
        let permeability = columns.find("permeability", Some("m2"))?;
        if let Some(index) = permeability {
            found
                .permeability
                .extend(self.values(data[index], 1, count)?);
        }
        // Part of a field is no field.
        if !found.permeability.is_empty() && found.permeability.len() != found.volume.len() {
            return Err(self.damaged(piece, "only some pieces have `permeability`".to_owned()));
        }
        Ok(())
    }

    fn values(
        &self,
        node: Node<'_, '_>,
        components: usize,
        count: usize,
    ) -> Result<Vec<f64>, FileError> {
        let name = node.attribute("Name").unwrap_or("Points");
        let found = node.attribute("NumberOfComponents").map_or("1", str::trim);
        if found != components.to_string() {
            let reason =
                format!("array `{name}` has {found} components per point, needs {components}");
            return Err(self.damaged(node, reason));
        }
        count
            .checked_mul(components)
            .ok_or_else(|| format!("{count} points are impossible"))
            .and_then(|numbers| self.layout.values(node, numbers))
            .map_err(|reason| self.damaged(node, format!("array `{name}`: {reason}")))
    }

    fn damaged(&self, node: Node<'_, '_>, reason: String) -> FileError {
        let row = self.document.text_pos_at(node.range().start).row;
        let place = Some(Place::Line(row as usize));
        FileError::Damaged {
            path: self.path.to_path_buf(),
            place,
            reason,
        }
    }
}

/// The dimension is known only after all positions are, so that both units are possible here.
fn volume_of(columns: &Columns<'_>) -> Result<(usize, Option<&'static str>), FileError> {
    for unit in ["m2", "m3"] {
        let name = format!("volume_{unit}");
        if columns.names().contains(&name) {
            return Ok((columns.need("volume", Some(unit))?, Some(unit)));
        }
    }
    Ok((columns.need("volume", Some("m3"))?, None))
}

fn children<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children()
        .filter(move |child| child.has_tag_name(name))
}

fn arrays<'a, 'input>(
    piece: Node<'a, 'input>,
    group: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    children(piece, group).flat_map(|group| children(group, "DataArray"))
}

#[cfg(test)]
pub(super) mod tests;
