//! Histories: one line of numbers per step, as CSV.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::{OutputError, manifest, write_atomically};

/// Column names and rows of a history.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Column names with units, such as `time_s` or `pressure_centre_Pa`.
    pub columns: Vec<String>,
    /// One entry per row, each as long as `columns`.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Values of the first column of that name from top to bottom, if there is one.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let place = self.columns.iter().position(|column| column == name)?;
        let value = |row: &Vec<f64>| row.get(place).copied().unwrap_or(f64::NAN);
        Some(self.rows.iter().map(value).collect())
    }
}

/// A growing CSV file of numbers.
///
/// The first line holds the column names, which carry their units (`time_s`, `pressure_Pa`).
/// Numbers have the fewest digits that read back as the same bits; NaN and infinities are written
/// `NaN`, `inf` and `-inf`. Each row is handed to the operating system in one piece, so that a
/// killed run leaves whole lines.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    file: File,
    columns: usize,
}

impl History {
    /// Starts a new history, replacing an older file.
    ///
    /// # Errors
    /// [`OutputError`] if the file cannot be written.
    pub fn create(path: impl AsRef<Path>, columns: &[String]) -> Result<Self, OutputError> {
        Self::start(path.as_ref(), columns, &[])
    }

    /// Continues a history up to a time, s, or starts a new one.
    ///
    /// # Errors
    /// As [`History::resume`] and [`History::create`].
    pub fn open(
        path: impl AsRef<Path>,
        columns: &[String],
        until: Option<f64>,
    ) -> Result<Self, OutputError> {
        match until {
            Some(until) => Self::resume(path, columns, until),
            None => Self::create(path, columns),
        }
    }

    /// Continues an existing history, keeping the rows whose first column (the time) is at most
    /// `until`; later rows, which a resumed run computes again, are dropped. A missing file is
    /// created.
    ///
    /// # Errors
    /// [`OutputError::Malformed`] if the file has other columns, else [`OutputError`] if it cannot
    /// be read or written.
    pub fn resume(
        path: impl AsRef<Path>,
        columns: &[String],
        until: f64,
    ) -> Result<Self, OutputError> {
        let path = path.as_ref();
        if !path.exists() {
            return Self::create(path, columns);
        }
        let mut table = Self::read(path)?;
        if table.columns != columns {
            let reason = format!(
                "columns are {:?} but this run writes {columns:?}",
                table.columns
            );
            return Err(OutputError::Malformed {
                path: path.to_path_buf(),
                line: 1,
                reason,
            });
        }
        table
            .rows
            .retain(|row| row.first().is_none_or(|&time| time <= until));
        Self::start(path, columns, &table.rows)
    }

    fn start(path: &Path, columns: &[String], rows: &[Vec<f64>]) -> Result<Self, OutputError> {
        let failed = |action| move |source| OutputError::from_io(path, action, source);
        let mut text = csv_line(columns).map_err(failed("write its header"))?;
        rows.iter()
            .for_each(|row| text.extend_from_slice(number_line(row).as_bytes()));
        write_atomically(path, |writer| writer.write_all(&text))?;
        manifest::grows(path)?;
        let file = OpenOptions::new()
            .append(true)
            .open(path)
            .map_err(failed("open it for appending"))?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            columns: columns.len(),
        })
    }

    /// Adds one row, in the order of the columns.
    ///
    /// # Errors
    /// [`OutputError::Shape`] if the row has another length than the header, else [`OutputError`]
    /// if the file cannot be written.
    pub fn append(&mut self, row: &[f64]) -> Result<(), OutputError> {
        OutputError::check_length(&self.path, "a history row", self.columns, row.len())?;
        let failed = |source| OutputError::from_io(&self.path, "append a row", source);
        self.file
            .write_all(number_line(row).as_bytes())
            .map_err(failed)?;
        self.file.flush().map_err(failed)
    }

    /// Replaces all rows by those of `table`, which has the same columns.
    ///
    /// # Errors
    /// As [`History::create`].
    pub fn rewrite(&mut self, table: &Table) -> Result<(), OutputError> {
        *self = Self::start(&self.path, &table.columns, &table.rows)?;
        Ok(())
    }

    /// The names of the columns of a history that is there.
    ///
    /// # Errors
    /// [`OutputError`] if the file cannot be read.
    pub fn columns(path: impl AsRef<Path>) -> Result<Vec<String>, OutputError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|e| OutputError::from_io(path, "read it", e))?;
        let mut reader = csv::Reader::from_reader(file);
        let header = reader.headers().map_err(|e| OutputError::Malformed {
            path: path.to_path_buf(),
            line: 1,
            reason: e.to_string(),
        })?;
        Ok(header.iter().map(str::to_owned).collect())
    }

    /// Reads a history back. A last line without its newline is the torn end of a killed run and
    /// is left out.
    ///
    /// # Errors
    /// [`OutputError::Malformed`] for text that is not a number or rows of unequal length, else
    /// [`OutputError`] if the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Table, OutputError> {
        let path = path.as_ref();
        let mut bytes =
            std::fs::read(path).map_err(|e| OutputError::from_io(path, "read it", e))?;
        bytes.truncate(
            bytes
                .iter()
                .rposition(|&b| b == b'\n')
                .map_or(0, |last| last + 1),
        );
        let mut reader = csv::ReaderBuilder::new().from_reader(bytes.as_slice());
        let malformed = |line, reason| OutputError::Malformed {
            path: path.to_path_buf(),
            line,
            reason,
        };
        let header = reader.headers().map_err(|e| malformed(1, e.to_string()))?;
        let columns = header.iter().map(str::to_owned).collect();
        let mut rows = Vec::new();
        for (index, record) in reader.records().enumerate() {
            let line = index + 2;
            let record = record.map_err(|e| malformed(line, e.to_string()))?;
            let number = |text: &str| {
                text.parse::<f64>()
                    .map_err(|_| malformed(line, format!("{text:?} is no number")))
            };
            rows.push(record.iter().map(number).collect::<Result<_, _>>()?);
        }
        Ok(Table { columns, rows })
    }
}

fn csv_line(cells: &[String]) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells)?;
    writer
        .into_inner()
        .map_err(|e| std::io::Error::other(e.to_string()))
}

/// `Debug` is the shortest text that reads back unchanged, with an exponent for extreme numbers.
fn number_line(row: &[f64]) -> String {
    let cells: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
    cells.join(",") + "\n"
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn a_column_is_found_by_its_name() {
        let table = Table {
            columns: columns(),
            rows: vec![vec![0.0, 1.0, 2.0], vec![3.0, 4.0, 5.0]],
        };
        assert_eq!(table.column("ratio"), Some(vec![2.0, 5.0]));
        assert_eq!(table.column("time"), None);
    }

    fn columns() -> Vec<String> {
        ["time_s", "pressure, centre_Pa", "ratio"]
            .map(str::to_owned)
            .to_vec()
    }

    fn workspace() -> (tempfile::TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("history.csv");
        (directory, path)
    }

    #[test]
    fn every_number_reads_back_to_the_same_bits() {
        let (_directory, path) = workspace();
        let extreme = [0.1 + 0.2, f64::MIN_POSITIVE / 3.0, -1.797e308];
        let odd = [-0.0, f64::INFINITY, f64::NAN];
        let mut history = History::create(&path, &columns()).unwrap();
        history.append(&extreme).unwrap();
        history.append(&odd).unwrap();
        let table = History::read(&path).unwrap();
        assert_eq!(table.columns, columns());
        assert_eq!(History::columns(&path).unwrap(), columns());
        let bits = |row: &[f64]| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&table.rows[0]), bits(&extreme));
        assert_eq!(bits(&table.rows[1][..2]), bits(&odd[..2]));
        assert!(table.rows[1][2].is_nan());
    }

    #[test]
    fn each_row_is_on_disk_before_the_next() {
        let (_directory, path) = workspace();
        let mut history = History::create(&path, &columns()).unwrap();
        for step in 0..5_u8 {
            history.append(&[f64::from(step), 1e9, 1e-9]).unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text.lines().count(), usize::from(step) + 2);
            assert!(text.ends_with("1000000000.0,1e-9\n"));
        }
    }

    #[test]
    fn a_torn_last_line_is_left_out() {
        let (_directory, path) = workspace();
        std::fs::write(&path, "time_s,p_Pa\n0,1\n1,2\n2,3.4").unwrap();
        let table = History::read(&path).unwrap();
        assert_eq!(table.rows, [[0.0, 1.0], [1.0, 2.0]]);
    }

    #[test]
    fn resuming_drops_the_rows_after_the_checkpoint() {
        let (_directory, path) = workspace();
        let mut history = History::create(&path, &columns()).unwrap();
        for time in [0.0, 1.0, 2.0, 3.0] {
            history.append(&[time, 10.0 * time, 0.0]).unwrap();
        }
        drop(history);
        let mut history = History::resume(&path, &columns(), 1.0).unwrap();
        history.append(&[1.5, 0.0, 0.0]).unwrap();
        let times: Vec<f64> = History::read(&path)
            .unwrap()
            .rows
            .iter()
            .map(|r| r[0])
            .collect();
        assert_eq!(times, [0.0, 1.0, 1.5]);
        let other = ["time_s".to_owned()];
        let error = History::resume(&path, &other, 1.0).unwrap_err();
        assert!(matches!(error, OutputError::Malformed { line: 1, .. }));
    }

    #[test]
    fn wrong_lengths_and_words_are_refused_with_their_place() {
        let (_directory, path) = workspace();
        let mut history = History::create(&path, &columns()).unwrap();
        let error = history.append(&[1.0]).unwrap_err();
        assert!(matches!(
            error,
            OutputError::Shape {
                expected: 3,
                found: 1,
                ..
            }
        ));
        std::fs::write(&path, "a,b\n1,2\n3,four\n").unwrap();
        let error = History::read(&path).unwrap_err();
        assert!(error.to_string().contains("line 3") && error.to_string().contains("four"));
    }
}
