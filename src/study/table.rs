//! The runs of a study as rows: for a spreadsheet and for programs.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{Measured, Row, StudyError};
use crate::output::OutputError;

/// Measures of every run: name, and where it is found.
type Measure = (&'static str, fn(&Measured) -> f64);

const MEASURES: [Measure; 14] = [
    ("points", Measured::points),
    ("error", Measured::error),
    ("wall_s", Measured::seconds),
    ("wall_s_least", |run| extreme(run, f64::min)),
    ("wall_s_most", |run| extreme(run, f64::max)),
    ("cpu_s", |run| run.typical(|row| row.cpu_s)),
    ("memory_bytes", |run| {
        run.typical(|row: &Row| row.memory_bytes as f64)
    }),
    ("steps", Measured::steps),
    ("rejected", |run| run.figure(|run| run.rejected as f64)),
    ("factorisations", |run| {
        run.solver(|done| done.factorisations)
    }),
    ("solves", |run| run.solver(|done| done.solves)),
    ("krylov_iterations", |run| {
        run.solver(|done| done.iterations)
    }),
    ("coupling_passes", |run| {
        run.figure(|run| run.coupling.map_or(f64::NAN, |own| own.passes as f64))
    }),
    ("relaxation_iterations", |run| {
        run.figure(|run| run.counters.relaxation_iterations as f64)
    }),
];

fn extreme(run: &Measured, pick: fn(f64, f64) -> f64) -> f64 {
    run.rows.iter().map(|row| row.wall_s).fold(f64::NAN, pick)
}

/// A run for report.json.
pub(super) fn entry(run: &Measured) -> Value {
    let measures = MEASURES
        .iter()
        .map(|(name, measure)| ((*name).to_owned(), json!(measure(run))));
    json!({
        "scheme": run.variant.scheme,
        "solver": run.variant.solver,
        "operator": run.variant.operator,
        "varied": run.variant.values,
        "overrides": run.variant.overrides,
        "status": run.first().status,
        "code": run.first().code,
        "reason": run.first().reason,
        "repetitions": run.repetitions(),
        "errors": run.errors(),
        "resolved": run.resolved(),
        "measures": measures.collect::<serde_json::Map<String, Value>>(),
    })
}

/// All runs as a table with commas.
///
/// # Errors
/// [`StudyError::Output`] if it cannot be made.
pub(super) fn csv(runs: &[Measured]) -> Result<Vec<u8>, StudyError> {
    let varied: BTreeSet<&str> = runs
        .iter()
        .flat_map(|run| run.variant.values.keys().copied())
        .collect();
    let fields: BTreeSet<String> = runs
        .iter()
        .flat_map(|run| run.errors().into_keys())
        .collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut head: Vec<String> = ["scheme", "solver", "operator"].map(str::to_owned).into();
    head.extend(varied.iter().map(|name| (*name).to_owned()));
    head.extend(["status", "resolved", "repetitions"].map(str::to_owned));
    head.extend(MEASURES.iter().map(|(name, _)| (*name).to_owned()));
    head.extend(fields.iter().map(|field| format!("error_{field}")));
    head.extend(["reason", "overrides"].map(str::to_owned));
    let failed = |error: csv::Error| {
        OutputError::from_io(std::path::Path::new("table"), "write", error.into())
    };
    writer.write_record(&head).map_err(failed)?;
    for run in runs {
        let (variant, first, errors) = (&run.variant, run.first(), run.errors());
        let mut cells = vec![variant.scheme.clone(), variant.solver.clone()];
        cells.push(variant.operator.clone().unwrap_or_default());
        cells.extend(varied.iter().map(|name| cell(variant.value(name))));
        cells.extend([
            first.status.name().to_owned(),
            run.resolved().to_string(),
            run.repetitions().to_string(),
        ]);
        cells.extend(MEASURES.iter().map(|(_, measure)| cell(measure(run))));
        cells.extend(
            fields
                .iter()
                .map(|f| errors.get(f).map_or(String::new(), |e| cell(*e))),
        );
        cells.push(first.reason.clone().unwrap_or_default());
        cells.push(variant.overrides.join(" "));
        writer.write_record(&cells).map_err(failed)?;
    }
    writer.into_inner().map_err(|error| {
        OutputError::from_io(std::path::Path::new("table"), "write", error.into_error()).into()
    })
}

fn cell(value: f64) -> String {
    match value.is_finite() {
        true => format!("{value}"),
        false => String::new(),
    }
}
