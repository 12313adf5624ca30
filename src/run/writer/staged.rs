//! The folder of a scene in stages: what the stages have in common.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::super::tables::{WrittenColumn, written};
use super::Hold;
use crate::output::{History, OutputError, Pvd, Table, write_atomically, write_json};

/// A folder whose stages have folders of their own in it.
pub struct StagedFolder {
    folder: PathBuf,
    _hold: Hold,
}

impl StagedFolder {
    /// Prepares a folder, with the list of its stages as JSON.
    ///
    /// # Errors
    /// [`OutputError`] for a folder that cannot be used.
    pub fn create(folder: &Path, list: &str) -> Result<Self, OutputError> {
        let note =
            "# The stages of this run stand in stages.json, and each has a folder of its own.\n";
        let mut hold = Hold::take(folder, note)?;
        hold.begin(note)?;
        write_atomically(folder.join("stages.json"), |file| {
            file.write_all(list.as_bytes())
        })?;
        Ok(StagedFolder {
            folder: folder.to_owned(),
            _hold: hold,
        })
    }

    /// Goes on in such a folder.
    ///
    /// # Errors
    /// [`OutputError`] for a folder that cannot be used.
    pub fn go_on(folder: &Path) -> Result<Self, OutputError> {
        Ok(StagedFolder {
            folder: folder.to_owned(),
            _hold: Hold::go_on(folder)?,
        })
    }

    /// Joins histories and collections of the stages so far: one history with the number of the stage beside
    /// the time, NaN where a stage has no such column.
    ///
    /// # Errors
    /// [`OutputError`] of a file that cannot be read or written.
    pub fn join(&self, stages: &[PathBuf]) -> Result<(), OutputError> {
        let mut whole = Table {
            columns: vec!["time_s".to_owned(), "stage".to_owned()],
            rows: Vec::new(),
        };
        let mut pvd = Pvd::create(self.folder.join("fields.pvd"))?;
        for (number, stage) in stages.iter().enumerate() {
            append(
                &mut whole,
                number + 1,
                &History::read(stage.join("history.csv"))?,
            );
            let own = stage.join("fields.pvd");
            for (time, file) in Pvd::read(&own)? {
                pvd.add(time, stage.join(file))?;
            }
        }
        let path = self.folder.join("history.csv");
        History::create(&path, &whole.columns)?.rewrite(&whole)
    }

    /// The columns of the history of all stages.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be read.
    pub fn columns(&self) -> Result<Vec<WrittenColumn>, OutputError> {
        written(&self.folder.join("history.csv"))
    }

    /// Writes summary.json.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be written.
    pub fn summary(&self, summary: &impl Serialize) -> Result<(), OutputError> {
        write_json(self.folder.join("summary.json"), summary)
    }
}

/// Adds the rows of a stage, whose new columns come behind those that there are.
fn append(whole: &mut Table, stage: usize, own: &Table) {
    let known = whole.columns.len();
    let new = own
        .columns
        .iter()
        .filter(|name| !whole.columns.contains(name));
    let new: Vec<String> = new.cloned().collect();
    whole.columns.extend(new);
    let width = whole.columns.len();
    if width > known {
        whole
            .rows
            .iter_mut()
            .for_each(|row| row.resize(width, f64::NAN));
    }
    let places: Vec<Option<usize>> = (whole.columns.iter())
        .map(|name| own.columns.iter().position(|other| other == name))
        .collect();
    for row in &own.rows {
        let value = |(k, place): (usize, &Option<usize>)| match (k, place) {
            (1, _) => stage as f64,
            (_, Some(place)) => row[*place],
            (_, None) => f64::NAN,
        };
        whole
            .rows
            .push(places.iter().enumerate().map(value).collect());
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn columns_of_later_stages_are_gaps_in_earlier_ones() {
        let table = |columns: &[&str], row: &[f64]| Table {
            columns: columns.iter().map(|name| (*name).to_owned()).collect(),
            rows: vec![row.to_vec()],
        };
        let mut whole = table(&["time_s", "stage"], &[]);
        whole.rows.clear();
        append(&mut whole, 1, &table(&["time_s", "a"], &[0.0, 5.0]));
        append(
            &mut whole,
            2,
            &table(&["time_s", "b", "a"], &[1.0, 7.0, 6.0]),
        );
        assert_eq!(whole.columns, ["time_s", "stage", "a", "b"]);
        assert_eq!(whole.rows[1], [1.0, 2.0, 6.0, 7.0]);
        assert_eq!(whole.rows[0][..3], [0.0, 1.0, 5.0]);
        assert!(whole.rows[0][3].is_nan());
    }
}
