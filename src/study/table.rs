//! The runs of a study as rows: for a spreadsheet and for programs.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{Measured, Row, StudyError};
use crate::output::OutputError;
use crate::run::Column;

const FILE: &str = "KIND.csv";

/// The columns of the table of a study, KIND; FIELD stands for a field with an error.
#[rustfmt::skip] // one a line, as the table that it is
pub(crate) const COLUMNS: &[Column] = &[
    Column::new(FILE, "scheme", "", "always", "time scheme"),
    Column::new(FILE, "solver", "", "always", "linear solver as typed"),
    Column::new(FILE, "setting", "", "always", "how the method is set where several ways are tried, else empty: what the program takes by itself"),
    Column::new(FILE, "operator", "", "always", "operator of flow where it is varied, else empty"),
    Column::new(FILE, "contrast", "1", "contrast, stability of flow", "ratio of the permeabilities"),
    Column::new(FILE, "strength", "1", "stability of coupled cases", "strength of the coupling, α²/(s(λ + 2μ))"),
    Column::new(FILE, "step_ratio", "1", "stability", "step over the limit of stability"),
    Column::new(FILE, "spacing", "m", "cost, convergence", "spacing of the points"),
    Column::new(FILE, "steps", "1", "convergence", "number of fixed steps that is asked for"),
    Column::new(FILE, "tolerance", "1", "cost", "`time.tolerance`"),
    Column::new(FILE, "step", "s", "cost", "`time.step`, the length of all steps"),
    Column::new(FILE, "role", "1", "convergence", "what the run is for: 0 order in time, 1 verification of the reference, 2 the reference, 3 order in space"),
    Column::new(FILE, "level", "1", "without an exact solution", "place in the chain of over-resolved runs, from 0, the coarsest"),
    Column::new(FILE, "status", "", "always", "`done`, or what became of it"),
    Column::new(FILE, "resolved", "", "always", "whether the error is well above that of what it was measured with"),
    Column::new(FILE, "repetitions", "1", "always", "how often it was run; measures are medians"),
    Column::new(FILE, "points", "1", "always", "number of points"),
    Column::new(FILE, "error", "1", "always", "largest of the errors of all fields, over the range of each"),
    Column::new(FILE, "wall_s", "s", "always", "wall time of the run"),
    Column::new(FILE, "wall_s_least", "s", "always", "shortest wall time of all repetitions"),
    Column::new(FILE, "wall_s_most", "s", "always", "longest wall time of all repetitions"),
    Column::new(FILE, "cpu_s", "s", "always", "time of all processors"),
    Column::new(FILE, "memory_bytes", "B", "always", "largest memory that the process held"),
    Column::new(FILE, "steps", "1", "always", "accepted steps"),
    Column::new(FILE, "rejected", "1", "always", "rejected steps"),
    Column::new(FILE, "factorisations", "1", "always", "factorisations of matrices"),
    Column::new(FILE, "solves", "1", "always", "linear systems that were solved"),
    Column::new(FILE, "krylov_iterations", "1", "always", "iterations of linear solvers"),
    Column::new(FILE, "coupling_passes", "1", "always", "passes between flow and mechanics"),
    Column::new(FILE, "relaxation_iterations", "1", "always", "iterations of dynamic relaxation"),
    Column::new(FILE, "error_FIELD", "1", "always", "root mean square error of a field over its range, the largest of all outputs after the start"),
    Column::new(FILE, "reason", "", "always", "why a run failed"),
    Column::new(FILE, "overrides", "", "always", "keys that were set"),
];

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
        "setting": run.variant.setting,
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
    let mut head: Vec<String> = ["scheme", "solver", "setting", "operator"]
        .map(str::to_owned)
        .into();
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
        cells.push(variant.setting.unwrap_or_default().to_owned());
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
