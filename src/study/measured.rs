//! What the runs of a variant showed.

use std::collections::BTreeMap;

use super::{Row, Status, Variant, median};

/// A variant with its runs.
#[derive(Debug, Clone)]
pub struct Measured {
    /// What was run.
    pub variant: Variant,
    /// Its runs, in order; the first one decides about errors and counters.
    pub rows: Vec<Row>,
    /// What a comparison with other runs told, where the program knows no exact solution.
    pub compared: Option<Compared>,
}

/// Errors from a comparison with other runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Errors per field, as [`Measured::errors`] gives them.
    pub errors: BTreeMap<String, f64>,
    /// Whether the largest is well above what the comparison itself is wrong by.
    pub resolved: bool,
}

impl Measured {
    /// A variant with at least one run.
    pub fn new(variant: Variant, rows: Vec<Row>) -> Self {
        Measured {
            variant,
            rows,
            compared: None,
        }
    }

    /// The first run.
    pub fn first(&self) -> &Row {
        // A variant enters the results with its first run.
        &self.rows[0]
    }

    /// Whether it reached its end.
    pub fn done(&self) -> bool {
        self.first().status == Status::Done
    }

    /// Median of a measure over the runs that reached their end.
    pub fn typical(&self, measure: impl Fn(&Row) -> f64) -> f64 {
        let done = self.rows.iter().filter(|row| row.status == Status::Done);
        median(&done.map(measure).collect::<Vec<f64>>()).unwrap_or(f64::NAN)
    }

    /// Median wall time, s.
    pub fn seconds(&self) -> f64 {
        self.typical(|row| row.wall_s)
    }

    /// A number of the summary by its path, such as `/counters/solver/iterations`.
    pub fn number(&self, path: &str) -> f64 {
        let summary = self.first().summary.as_ref().filter(|_| self.done());
        let value = summary.and_then(|summary| summary.pointer(path));
        value
            .and_then(serde_json::Value::as_f64)
            .unwrap_or(f64::NAN)
    }

    /// Errors per field: root mean square over the range, the largest of all outputs after the start.
    pub fn errors(&self) -> BTreeMap<String, f64> {
        if let Some(compared) = &self.compared {
            return compared.errors.clone();
        }
        let mut errors: BTreeMap<String, f64> = BTreeMap::new();
        let summary = self.first().summary.as_ref().filter(|_| self.done());
        let outputs = summary.and_then(|summary| summary["errors_over_time"].as_array());
        for output in outputs
            .into_iter()
            .flatten()
            .filter_map(|output| output.as_object())
        {
            for (field, error) in output {
                if let Some(error) = error["l2"].as_f64() {
                    let largest = errors.entry(field.clone()).or_insert(0.0);
                    *largest = largest.max(error);
                }
            }
        }
        errors
    }

    /// Whether its error means something: it is one, and well above what it was measured with.
    pub fn resolved(&self) -> bool {
        let sure = |compared: &Compared| compared.resolved;
        self.done() && self.error() > 0.0 && self.compared.as_ref().is_none_or(sure)
    }

    /// The largest error of all fields; NaN without anything to compare with.
    pub fn error(&self) -> f64 {
        self.errors().into_values().fold(f64::NAN, f64::max)
    }
}
