//! Points and properties from comma-separated text.

use std::path::Path;

use ::csv::{ReaderBuilder, StringRecord, Trim};

use super::columns::Columns;
use super::values::{Allowed, check};
use super::{FileError, Place, PointTable, Property, utf8};

/// Reads points; see [`super::read_points`].
pub(super) fn read_points(path: &Path, bytes: &[u8]) -> Result<PointTable, FileError> {
    let table = Table::read(path, bytes, "points")?;
    let columns = &table.columns;
    let (x, y) = (columns.find("x", Some("m"))?, columns.find("y", Some("m"))?);
    let z = columns.find("z", Some("m"))?;
    let volume_unit = if z.is_some() { "m3" } else { "m2" };
    let volume = columns.find("volume", Some(volume_unit))?;
    let (Some(x), Some(y), Some(volume)) = (x, y, volume) else {
        let wanted = [("x", x), ("y", y), ("volume", volume)];
        let absent = wanted.iter().filter(|(_, index)| index.is_none());
        return Err(columns.missing(&absent.map(|&(name, _)| name).collect::<Vec<_>>()));
    };
    let permeability = columns.find("permeability", Some("m2"))?;
    let axes = [("x", Some(x)), ("y", Some(y)), ("z", z)];
    let axes = axes
        .into_iter()
        .filter_map(|(name, index)| Some(table.numbers(index?, name, Allowed::Finite)))
        .collect::<Result<Vec<_>, _>>()?;
    let rows = 0..table.rows.len();
    Ok(PointTable {
        dimension: axes.len(),
        position: rows
            .flat_map(|row| axes.iter().map(move |axis| axis[row]))
            .collect(),
        volume: table.numbers(volume, "volume", Allowed::Positive)?,
        material: columns
            .find("material", None)?
            .map(|index| table.words(index))
            .transpose()?,
        permeability: permeability
            .map(|index| table.permeability(index))
            .transpose()?,
    })
}

/// Reads one column of values; see [`super::read_field`].
pub(super) fn read_field(
    path: &Path,
    bytes: &[u8],
    column: Option<&str>,
    property: Property,
) -> Result<Vec<f64>, FileError> {
    let table = Table::read(path, bytes, "values")?;
    let columns = &table.columns;
    let index = match column {
        Some(wanted) => match columns.names().iter().position(|name| name == wanted) {
            Some(index) => index,
            None => columns.need(wanted, property.unit)?,
        },
        None if columns.names().len() == 1 => 0,
        None => {
            let found = columns.listed();
            return Err(FileError::ColumnNeeded {
                path: path.to_path_buf(),
                found,
            });
        }
    };
    if let Some(unit) = property.unit {
        columns.check_unit(index, unit)?;
    }
    table.numbers(index, property.key, property.allowed)
}

/// A table of text with a header.
#[derive(Debug)]
struct Table<'a> {
    path: &'a Path,
    columns: Columns<'a>,
    rows: Vec<Row>,
}

#[derive(Debug)]
struct Row {
    /// Line in the file, counted from 1.
    line: usize,
    cells: StringRecord,
}

impl<'a> Table<'a> {
    /// Splits the text into cells; `what` names the rows in messages.
    fn read(path: &'a Path, bytes: &[u8], what: &'static str) -> Result<Self, FileError> {
        let mut rows = split(path, utf8(path, bytes)?)?.into_iter();
        let empty = || FileError::Empty {
            path: path.to_path_buf(),
            what,
        };
        let header = rows.next().ok_or_else(empty)?;
        if let Some(found) = header.cells.iter().find(|cell| cell.parse::<f64>().is_ok()) {
            let (path, found) = (path.to_path_buf(), found.to_owned());
            return Err(FileError::NoHeader {
                path,
                line: header.line,
                found,
            });
        }
        let names = header.cells.iter().map(str::to_owned).collect();
        let columns = Columns::new(path, "column", names)?;
        let rows: Vec<Row> = rows.collect();
        let expected = header.cells.len();
        if let Some(row) = rows.iter().find(|row| row.cells.len() != expected) {
            let (line, found) = (row.line, row.cells.len());
            return Err(FileError::Ragged {
                path: path.to_path_buf(),
                line,
                expected,
                found,
            });
        }
        if rows.is_empty() {
            return Err(empty());
        }
        Ok(Self {
            path,
            columns,
            rows,
        })
    }

    fn permeability(&self, column: usize) -> Result<Vec<f64>, FileError> {
        self.numbers(column, "permeability", Allowed::Positive)
    }

    fn numbers(
        &self,
        column: usize,
        quantity: &'static str,
        allowed: Allowed,
    ) -> Result<Vec<f64>, FileError> {
        let number = |cell: Result<(usize, &str), FileError>| {
            let (line, text) = cell?;
            text.parse::<f64>().map_err(|_| FileError::NotNumber {
                path: self.path.to_path_buf(),
                line,
                column: self.columns.names()[column].clone(),
                text: text.to_owned(),
            })
        };
        let values = self
            .cells(column)
            .map(number)
            .collect::<Result<Vec<f64>, _>>()?;
        check(self.path, quantity, allowed, &values, |row| {
            Place::Line(self.rows[row].line)
        })?;
        Ok(values)
    }

    fn words(&self, column: usize) -> Result<Vec<String>, FileError> {
        self.cells(column)
            .map(|cell| cell.map(|(_, text)| text.to_owned()))
            .collect()
    }

    /// Line and text of each cell of a column; all must be filled in.
    fn cells(&self, column: usize) -> impl Iterator<Item = Result<(usize, &str), FileError>> {
        self.rows
            .iter()
            .map(move |row| match row.cells.get(column) {
                None | Some("") => Err(FileError::EmptyCell {
                    path: self.path.to_path_buf(),
                    line: row.line,
                    column: self.columns.names()[column].clone(),
                }),
                Some(text) => Ok((row.line, text)),
            })
    }
}

/// Comments and blanks are taken out before the CSV reader sees the text, whose own line numbers
/// point at the comments before a row.
fn split(path: &Path, text: &str) -> Result<Vec<Row>, FileError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (numbers, lines): (Vec<usize>, Vec<&str>) = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line))
        .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
        .unzip();
    let kept = lines.join("\n");
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(kept.as_bytes());
    let mut rows = Vec::with_capacity(numbers.len());
    for record in reader.records() {
        let cells = record.map_err(|error| FileError::Damaged {
            path: path.to_path_buf(),
            place: None,
            reason: error.to_string(),
        })?;
        let kept_line = cells.position().map_or(1, |position| position.line());
        let index = usize::try_from(kept_line).unwrap_or(1).saturating_sub(1);
        rows.push(Row {
            line: numbers.get(index).copied().unwrap_or(1),
            cells,
        });
    }
    Ok(rows)
}

#[cfg(test)]
#[path = "csv_tests.rs"]
mod tests;
