//! What accuracy costs: schemes × solvers × grids × tolerances, error against seconds.

mod breaking;
mod crossover;
mod judged;
mod laws;
mod reaching;
mod settings;
mod tried;
mod variants;

use std::collections::BTreeMap;

use serde_json::json;

use self::crossover::crossover;
use self::judged::Assessment;
use self::laws::{CLOUDS, draw_growth, growth, orders};
use self::reaching::{draw, headlines, reaching};
use self::variants::variants;
use super::over_resolved::{self, OverResolved};
use super::{
    Compared, Coverage, Measured, Options, PRINTED, ReportContent, Section, Study, StudyCase,
    StudyError, Table, Variant,
};
use crate::plan::exact_pressure;

/// The study of cost.
pub(super) struct Cost;

/// Runs that solve for the steady state alone.
const STEADY: &str = "steady";

/// A run of the study in a picture: seconds and error.
type Pair = (f64, f64);

/// Runs by their method.
type Groups<'a> = BTreeMap<String, Vec<&'a Measured>>;

impl Study for Cost {
    fn name(&self) -> &'static str {
        "cost"
    }

    fn repetitions(&self) -> u32 {
        3
    }

    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        variants(subject, options)
    }

    fn compare(&self, runs: &mut [Measured]) {
        let Some(exact) = OverResolved::among(runs) else {
            return;
        };
        let least = over_resolved::RESOLVED * exact.largest_uncertainty();
        let compared: Vec<Option<Compared>> = runs
            .iter()
            .map(|run| {
                let errors = exact.distances(run);
                let largest = errors.values().copied().fold(f64::NAN, f64::max);
                let measured = run.done() && !over_resolved::is_level(&run.variant);
                measured.then_some(Compared {
                    errors,
                    resolved: largest >= least,
                })
            })
            .collect();
        for (run, compared) in runs.iter_mut().zip(compared) {
            run.compared = compared;
        }
    }

    fn findings(&self, subject: &StudyCase, runs: &[Measured]) -> ReportContent {
        let done: Vec<&Measured> = runs.iter().filter(|run| run.resolved()).collect();
        let judged = subject
            .plan
            .reference
            .is_none()
            .then(|| Assessment::of(runs));
        let groups = groups(runs);
        let (reaching, costs) = reaching(&groups, &done);
        let (crossing, crossover) = crossover(&groups);
        let (orders, order_facts) = orders(&done);
        let (growth, growth_facts) = growth(&done);
        let mut headlines = headlines(&costs);
        headlines.extend(crossing);
        headlines.extend(judged.as_ref().map(Assessment::line));
        let breaks = subject.plan.damage.is_some();
        let mut section = Section::new("Error against seconds");
        section.text = match done.is_empty() {
            true => vec![nothing(runs)],
            false => words(subject, &done),
        };
        let judgement = judged.as_ref().and_then(Assessment::paragraph);
        section.text.extend(judgement);
        draw(&mut section, &groups);
        section.tables.push(reaching);
        tried::tell(&mut section, runs, &groups);
        let mut sections = vec![section];
        // There is only one cloud where rock breaks.
        if !breaks && !done.is_empty() {
            sections.push(laws(&groups, [orders, growth]));
        }
        ReportContent {
            facts: json!({
                "over_resolved": judged,
                "cost_to_reach": costs,
                "crossover": crossover,
                "orders": order_facts,
                "growth": growth_facts,
            }),
            headlines,
            sections,
        }
    }
}

/// Why there is nothing to show.
fn nothing(runs: &[Measured]) -> String {
    let own = runs
        .iter()
        .filter(|run| !over_resolved::is_level(&run.variant));
    format!(
        "No run has an error that is resolved, so nothing is told of costs: {}.",
        Coverage::of(own)
    )
}

/// What the marks are.
fn words(subject: &StudyCase, done: &[&Measured]) -> Vec<String> {
    let what = match subject.plan.damage.is_some() {
        true => {
            "with one bound of its steps, the same for their length and for the growth of damage"
        }
        false => "on one grid with one tolerance or one constant step",
    };
    let repetitions = || done.iter().map(|run| run.repetitions());
    let (least, most) = (repetitions().min(), repetitions().max());
    let wall = match (least.unwrap_or(1), most.unwrap_or(1)) {
        (_, 1) => "the wall time of the whole process, run once".to_owned(),
        (least, most) if least == most => {
            format!(
                "the median wall time of the whole process, run {most} times in turn with all others"
            )
        }
        (least, most) => format!(
            "the median wall time of the whole process, run {least} to {most} times in turn with all others"
        ),
    };
    let mut words = vec![format!(
        "Each mark is a run of {} {what}: {wall}, with its start and its output, against the largest root mean square \
         error of all fields and outputs, relative to the range of the exact field.",
        subject.plan.case
    )];
    if done.iter().any(|run| run.variant.scheme.ends_with(PRINTED)) {
        words.push(format!(
            "The explicit scheme{PRINTED} relaxes with the local damping of Eqs. 65 to 68 to 1e-6; all else is as in the \
             explicit one."
        ));
    }
    if steady_only(subject) {
        words.push(
            "The exact solution of this case is that of the steady state: errors are those at the end \
             of the transient, where errors made on the way have died out, and the solve for the steady \
             state alone is a method too."
                .to_owned(),
        );
    }
    words
}

/// Orders in space and growth with the number of points.
fn laws(groups: &Groups<'_>, tables: [Table; 2]) -> Section {
    let mut section = Section::new("Orders and growth");
    section.text.push(match tables.iter().all(|table| table.rows.is_empty()) {
        true => format!(
            "No method has runs on {CLOUDS} clouds at its smallest tolerance, which an order or an exponent takes."
        ),
        false => format!(
            "Orders in space are fitted over the {CLOUDS} finest clouds at the smallest tolerance of each method that \
             has so many; where the error in time is not small beside that in space, the order seen is lower. The \
             study of convergence takes the two apart."
        ),
    });
    section.tables.extend(tables);
    draw_growth(&mut section, groups);
    section
}

/// Whether errors exist in the steady state only.
fn steady_only(subject: &StudyCase) -> bool {
    let exact = exact_pressure(&subject.plan).ok().flatten();
    exact.is_some_and(|exact| exact.steady_only())
}

/// Runs with an error by their method; none of a method of which nothing is resolved.
fn groups(runs: &[Measured]) -> Groups<'_> {
    let mut groups = Groups::new();
    for run in runs
        .iter()
        .filter(|run| !over_resolved::is_level(&run.variant))
    {
        let own = groups.entry(run.variant.method()).or_default();
        own.extend(Some(run).filter(|run| run.resolved()));
    }
    groups
}

fn pairs(runs: &[&Measured]) -> Vec<Pair> {
    runs.iter()
        .map(|run| (run.seconds(), run.error()))
        .collect()
}

#[cfg(test)]
pub(super) mod tests;
