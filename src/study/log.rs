//! The log of a study: one line of JSON per finished run, so that an interrupted study goes on.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::StudyError;
use crate::output::OutputError;
use crate::run::Summary;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Status {
    /// It reached its end.
    Done,
    /// It was refused before it started (exit codes 2 and 3).
    Refused,
    /// It stopped on the way: not converged, unstable, too many steps.
    Failed,
    /// It took longer than a run may.
    TimedOut,
    /// It was not started, because a cheaper run of the same kind took too long already.
    Skipped,
    /// It was not started, because another setting of its method was cheaper on a coarser cloud.
    Beaten,
    /// Its turn did not come before the budget was used up or the study was interrupted.
    NotRun,
}

impl Status {
    /// As in tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Status::Done => "done",
            Status::Refused => "refused",
            Status::Failed => "failed",
            Status::TimedOut => "timed out",
            Status::Skipped => "skipped",
            Status::Beaten => "beaten",
            Status::NotRun => "not run",
        }
    }
}

/// One finished run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Row {
    /// What was run: build of the program, scene and overrides.
    pub key: String,
    /// 0 for the first run of a variant.
    pub repetition: u32,
    /// How it ended.
    pub status: Status,
    /// Exit code, if it was started and no signal ended it.
    pub code: Option<i32>,
    /// Why it is not done.
    pub reason: Option<String>,
    /// Wall time of the process, s.
    pub wall_s: f64,
    /// Processor time of all its threads, s.
    pub cpu_s: f64,
    /// Largest resident memory, bytes.
    pub memory_bytes: u64,
    /// What `run --json` printed.
    pub summary: Option<Summary>,
    /// Fields at the end, where the study compares runs with each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<(String, Vec<f64>)>,
}

impl Row {
    /// A run that was not started.
    pub(crate) fn unmeasured(key: String, repetition: u32, status: Status, reason: String) -> Self {
        Row {
            key,
            repetition,
            status,
            code: None,
            reason: Some(reason),
            wall_s: f64::NAN,
            cpu_s: f64::NAN,
            memory_bytes: 0,
            summary: None,
            fields: Vec::new(),
        }
    }
}

impl Row {
    /// Errors per field: root mean square over the range, the largest of all outputs after the start; nothing without
    /// an exact solution.
    pub(crate) fn errors(&self) -> BTreeMap<String, f64> {
        let mut errors: BTreeMap<String, f64> = BTreeMap::new();
        let outputs = self.summary.as_ref();
        let outputs = outputs.map_or(&[][..], |run| &run.errors_over_time);
        let all = outputs.iter().flat_map(|output| &output.errors);
        for (field, error) in all.filter(|(_, error)| !error.l2.is_nan()) {
            let largest = errors.entry(field.to_string()).or_insert(0.0);
            *largest = largest.max(error.l2);
        }
        errors
    }

    /// The largest of them; NaN without any.
    pub(crate) fn error(&self) -> f64 {
        self.errors().into_values().fold(f64::NAN, f64::max)
    }
}

/// The log, open for more rows.
#[derive(Debug)]
pub(crate) struct Log {
    path: PathBuf,
    file: File,
    rows: Vec<Row>,
}

impl Log {
    /// Opens the log, or begins one. What a killed study left of its last line is cut off.
    ///
    /// # Errors
    /// [`StudyError::Output`] if the file cannot be read or written.
    pub(crate) fn open(path: &Path) -> Result<Self, StudyError> {
        let failed = |action| move |error| OutputError::from_io(path, action, error);
        let mut file = OpenOptions::new()
            .create(true)
            .read(true)
            .append(true)
            .open(path)
            .map_err(failed("open"))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed("read"))?;
        let whole = bytes
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |at| at + 1);
        if whole < bytes.len() {
            file.set_len(whole as u64).map_err(failed("cut"))?;
            file.seek(SeekFrom::End(0)).map_err(failed("cut"))?;
        }
        let text = String::from_utf8_lossy(&bytes[..whole]);
        // Rows of an older version may have another shape; they are run again.
        let rows = text
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok())
            .collect();
        Ok(Log {
            path: path.to_owned(),
            file,
            rows,
        })
    }

    /// The row of a run, if it is there.
    pub(crate) fn find(&self, key: &str, repetition: u32) -> Option<&Row> {
        let fits = |row: &&Row| row.key == key && row.repetition == repetition;
        self.rows.iter().rev().find(fits)
    }

    /// Adds a finished run.
    ///
    /// # Errors
    /// [`StudyError::Output`] if it cannot be written.
    pub(crate) fn add(&mut self, row: Row) -> Result<(), StudyError> {
        let mut line = serde_json::to_string(&row).map_err(|source| OutputError::Json {
            path: self.path.clone(),
            source,
        })?;
        line.push('\n');
        let written = self
            .file
            .write_all(line.as_bytes())
            .and_then(|()| self.file.sync_data());
        written.map_err(|error| OutputError::from_io(&self.path, "write", error))?;
        self.rows.push(row);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn row(key: &str, repetition: u32) -> Row {
        Row {
            key: key.to_owned(),
            repetition,
            status: Status::Done,
            code: Some(0),
            reason: None,
            wall_s: 0.1 + 0.2,
            cpu_s: 0.5,
            memory_bytes: 7,
            summary: serde_json::from_str(r#"{ "steps": 3 }"#).ok(),
            fields: Vec::new(),
        }
    }

    /// Every figure of the row in the log.
    fn found(log: &Log, key: &str, repetition: u32) -> Option<String> {
        let row = log.find(key, repetition)?;
        serde_json::to_string(row).ok()
    }

    fn written(row: &Row) -> Option<String> {
        serde_json::to_string(row).ok()
    }

    #[test]
    fn a_log_with_a_half_written_last_line_goes_on_after_the_last_whole_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.jsonl");
        Log::open(&path).unwrap().add(row("a", 0)).unwrap();
        let whole = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{whole}{}", &whole[..whole.len() / 2])).unwrap();
        let mut log = Log::open(&path).unwrap();
        assert_eq!(found(&log, "a", 0), written(&row("a", 0)));
        assert!(log.find("a", 1).is_none());
        log.add(row("b", 1)).unwrap();
        let log = Log::open(&path).unwrap();
        assert_eq!(found(&log, "a", 0), written(&row("a", 0)));
        assert_eq!(found(&log, "b", 1), written(&row("b", 1)));
        assert_eq!(fs::read_to_string(&path).unwrap().lines().count(), 2);
    }
}
