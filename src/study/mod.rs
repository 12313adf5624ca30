//! Studies: many runs of one case, as a user would start them, and what they show together.
//!
//! A [`Study`] names its [`Variant`]s. A [`Campaign`] runs each as a child process, measures it and
//! keeps it in a [`Log`], so that an interrupted study goes on where it stopped. From the rows the
//! study draws its [`ReportContent`], which become `KIND.csv`, `report.json` and a `report.html` that needs
//! no network. A new kind is one file and one line in [`study`].

mod analysis;
mod beaten;
mod campaign;
mod chart;
mod contrast;
mod convergence;
mod cost;
mod coverage;
mod error;
mod fields;
mod findings;
mod forecast;
mod frames;
mod html;
mod log;
mod machine;
mod measured;
mod over_resolved;
mod profile;
mod runner;
mod scene;
mod single;
mod stability;
mod subject;
mod table;
mod variant;

use std::path::Path;

pub(crate) use analysis::{Fit, median, pareto, reach};
pub(crate) use campaign::{Campaign, Watcher};
pub(crate) use coverage::{Coverage, Request};
pub use error::StudyError;
pub(crate) use findings::{ReportContent, Section, Table};
pub(crate) use forecast::{calibration, compare_costs, forecast};
pub use frames::draw_frames;
pub(crate) use log::{Log, Row, Status};
pub(crate) use machine::Machine;
pub(crate) use measured::{Compared, Measured};
pub(crate) use profile::RecordedOutput;
pub(crate) use runner::Runner;
pub use single::report_run;
pub(crate) use subject::{Grid, StudyCase};
pub(crate) use table::COLUMNS;
pub(crate) use variant::{Method, PRINTED, Variant};

use crate::output::{write_atomically, write_json};

/// What the user may choose about a study.
#[derive(Debug, Clone, Default)]
pub(crate) struct Options {
    /// Time schemes; those that suit the case if empty.
    pub schemes: Vec<String>,
    /// Linear solvers; a direct and an iterative one if empty.
    pub solvers: Vec<String>,
    /// Points along the longest side; the study's choice if empty.
    pub points: Vec<usize>,
    /// Few and small runs.
    pub quick: bool,
    /// Methods as they come only: no settings are tried that may be cheaper.
    pub defaults: bool,
}

impl Options {
    /// Whether the user wants this scheme.
    fn wants_scheme(&self, name: &str) -> bool {
        self.schemes.is_empty() || self.schemes.iter().any(|wish| wish == name)
    }
}

/// A kind of study.
pub(crate) trait Study {
    /// Name on the command line and of its table.
    fn name(&self) -> &'static str;

    /// The runs it needs.
    ///
    /// # Errors
    /// [`StudyError::Unsuited`] if the case has not what the study varies.
    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError>;

    /// Gives runs the errors that only a comparison of runs can tell.
    fn compare(&self, _: &mut [Measured]) {}

    /// What the runs show.
    fn findings(&self, subject: &StudyCase, runs: &[Measured]) -> ReportContent;

    /// Repetitions without a wish of the user: more where seconds are compared.
    fn repetitions(&self) -> u32 {
        1
    }
}

/// The study of a name.
pub(crate) fn study(name: &str) -> Option<Box<dyn Study>> {
    Some(match name {
        "cost" => Box::new(cost::Cost),
        "contrast" => Box::new(contrast::Contrast),
        "stability" => Box::new(stability::Stability),
        "convergence" => Box::new(convergence::Convergence),
        _ => return None,
    })
}

/// Names of all studies.
pub(crate) const NAMES: [&str; 4] = ["cost", "contrast", "stability", "convergence"];

/// Writes table, numbers and report of a study into its folder, each file whole or not at all.
///
/// # Errors
/// [`StudyError::Output`] if a file cannot be written.
pub(crate) fn write_report(
    folder: &Path,
    (study, request): (&dyn Study, &Request),
    subject: &StudyCase,
    runs: &[Measured],
) -> Result<serde_json::Value, StudyError> {
    let machine = Machine::here();
    let findings = study.findings(subject, runs);
    let csv = table::csv(runs)?;
    write_atomically(folder.join(format!("{}.csv", study.name())), |out| {
        out.write_all(&csv)
    })?;
    let report = serde_json::json!({
        "study": study.name(),
        "case": subject.plan.case,
        "overrides": subject.overrides,
        "command": request.command,
        "version": env!("CARGO_PKG_VERSION"),
        "machine": machine,
        "complete": request.complete,
        "coverage": Coverage::of(runs).facts(),
        "headlines": findings.headlines,
        "findings": findings.facts,
        "runs": runs.iter().map(table::entry).collect::<Vec<_>>(),
    });
    write_json(folder.join("report.json"), &report)?;
    for (name, svg) in findings.pictures() {
        write_atomically(folder.join(name), |out| out.write_all(svg.as_bytes()))?;
    }
    let page = html::study_page((study.name(), request), subject, &machine, &findings, runs);
    write_atomically(folder.join("report.html"), |out| {
        out.write_all(page.as_bytes())
    })?;
    Ok(report)
}

#[cfg(test)]
mod tests;
