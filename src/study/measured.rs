//! What the runs of a variant showed.

use std::collections::BTreeMap;

use perifrac_solvers::SolverCounters;

use super::{Row, Status, Variant, median};
use crate::run::{FieldError, Summary};

/// A variant with its runs.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// What was run.
    pub variant: Variant,
    /// Its runs, in order; the first one decides about errors and counters.
    pub rows: Vec<Row>,
    /// What a comparison with other runs told, where the program knows no exact solution.
    pub compared: Option<Compared>,
}

/// Errors from a comparison with other runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Compared {
    /// Errors per field, as [`Measured::errors`] gives them.
    pub errors: BTreeMap<String, f64>,
    /// Whether the largest is well above what the comparison itself is wrong by.
    pub resolved: bool,
}

impl Measured {
    /// A variant with at least one run.
    pub(crate) fn new(variant: Variant, rows: Vec<Row>) -> Self {
        Measured {
            variant,
            rows,
            compared: None,
        }
    }

    /// The first run.
    pub(crate) fn first(&self) -> &Row {
        // A variant enters the results with its first run.
        &self.rows[0]
    }

    /// How often it was started.
    pub(crate) fn repetitions(&self) -> usize {
        let idle = |row: &&Row| {
            matches!(
                row.status,
                Status::Skipped | Status::Beaten | Status::NotRun
            )
        };
        self.rows.iter().filter(|row| !idle(row)).count()
    }

    /// Whether it reached its end.
    pub(crate) fn done(&self) -> bool {
        self.first().status == Status::Done
    }

    /// Median of a measure over the runs that reached their end.
    pub(crate) fn typical(&self, measure: impl Fn(&Row) -> f64) -> f64 {
        let done = self.rows.iter().filter(|row| row.status == Status::Done);
        median(&done.map(measure).collect::<Vec<f64>>()).unwrap_or(f64::NAN)
    }

    /// Least and most wall time of a run that was repeated, s.
    pub(crate) fn range(&self) -> Option<(f64, f64)> {
        let walls = || {
            let done = self.rows.iter().filter(|row| row.status == Status::Done);
            done.map(|row| row.wall_s)
        };
        let (least, most) = (walls().reduce(f64::min)?, walls().reduce(f64::max)?);
        (walls().count() > 1).then_some((least, most))
    }

    /// Median wall time, s.
    pub(crate) fn seconds(&self) -> f64 {
        self.typical(|row| row.wall_s)
    }

    /// What the first run printed at its end; nothing where it did not reach it.
    pub(crate) fn summary(&self) -> Option<&Summary> {
        self.first().summary.as_ref().filter(|_| self.done())
    }

    /// A figure of the summary; NaN without one.
    pub(crate) fn figure(&self, figure: impl Fn(&Summary) -> f64) -> f64 {
        self.summary().map_or(f64::NAN, figure)
    }

    /// Number of points.
    pub(crate) fn points(&self) -> f64 {
        self.figure(|run| run.points as f64)
    }

    /// Accepted steps.
    pub(crate) fn steps(&self) -> f64 {
        self.figure(|run| run.steps as f64)
    }

    /// A count of what the linear solver of flow, or of flow and mechanics, did.
    pub(crate) fn solver(&self, count: impl Fn(&SolverCounters) -> u64) -> f64 {
        self.figure(|run| count(&run.counters.solver) as f64)
    }

    /// A figure of the error of a field at the end; NaN without an exact solution.
    pub(crate) fn error_of(&self, field: &str, figure: impl Fn(&FieldError) -> f64) -> f64 {
        self.figure(|run| run.errors.get(field).map_or(f64::NAN, &figure))
    }

    /// Errors per field: root mean square over the range, the largest of all outputs after the start.
    pub(crate) fn errors(&self) -> BTreeMap<String, f64> {
        if let Some(compared) = &self.compared {
            return compared.errors.clone();
        }
        match self.done() {
            true => self.first().errors(),
            false => BTreeMap::new(),
        }
    }

    /// Whether its error means something: it is one, and well above what it was measured with.
    pub(crate) fn resolved(&self) -> bool {
        let sure = |compared: &Compared| compared.resolved;
        self.done() && self.error() > 0.0 && self.compared.as_ref().is_none_or(sure)
    }

    /// The largest error of all fields; NaN without anything to compare with.
    pub(crate) fn error(&self) -> f64 {
        self.errors().into_values().fold(f64::NAN, f64::max)
    }
}
