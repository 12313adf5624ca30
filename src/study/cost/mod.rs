//! What accuracy costs: schemes × solvers × grids × tolerances, error against seconds.

mod breaking;
mod judged;
mod laws;
mod reaching;
mod variants;

use std::collections::BTreeMap;

use serde_json::json;

use self::judged::Assessment;
use self::laws::{draw_growth, growth, orders};
use self::reaching::{crossover, draw, headline, reaching};
use self::variants::variants;
use super::over_resolved::{self, OverResolved};
use super::{
    Compared, Measured, Options, ReportContent, Section, Study, StudyCase, StudyError, Variant,
};
use crate::plan::exact_pressure;

/// The study of cost.
pub(super) struct Cost;

/// A run of the study in a picture: seconds and error.
type Pair = (f64, f64);

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
        let groups = groups(&done);
        let (reaching, costs) = reaching(&groups, &done);
        let (crossing, crossover) = crossover(&groups);
        let (orders, order_facts) = orders(&done);
        let (growth, growth_facts) = growth(&done);
        let mut headlines: Vec<String> = costs.iter().filter_map(headline).collect();
        headlines.extend(crossing.clone());
        headlines.extend(judged.as_ref().map(Assessment::line));
        let mut section = Section::new("Error against seconds");
        let breaks = subject.plan.damage.is_some();
        let what = match breaks {
            true => {
                "with one bound of its steps, the same for their length and for the growth of damage"
            }
            false => "on one grid with one tolerance",
        };
        section.text.push(format!(
            "Each mark is a run of {} {what}: the median wall time of the whole \
             process, with its start and its output, against the largest root mean square error of all \
             fields and outputs, relative to the range of the exact field. Runs of all kinds took turns, \
             so that a disturbance of the machine meets all of them.",
            subject.plan.case
        ));
        if steady_only(subject) {
            section.text.push(
                "The exact solution of this case is that of the steady state: errors are those at the end \
                 of the transient, where errors made on the way have died out, and the solve for the steady \
                 state alone is a method too."
                    .to_owned(),
            );
        }
        section
            .text
            .extend(judged.as_ref().map(Assessment::paragraph));
        draw(&mut section, &groups);
        section.tables.push(reaching);
        section.text.extend(crossing);
        let mut laws = Section::new("Orders and growth");
        laws.text.push(
            "Orders in space are fitted over the three finest clouds at the smallest tolerance of each method; where the \
             error in time is not small beside that in space, the order seen is lower. The study of \
             convergence takes the two apart."
                .to_owned(),
        );
        laws.tables.extend([orders, growth]);
        draw_growth(&mut laws, &groups);
        ReportContent {
            facts: json!({
                "over_resolved": judged,
                "cost_to_reach": costs,
                "crossover": crossover,
                "orders": order_facts,
                "growth": growth_facts,
            }),
            headlines,
            // There is only one cloud where rock breaks.
            sections: if breaks {
                vec![section]
            } else {
                vec![section, laws]
            },
        }
    }
}

/// Whether errors exist in the steady state only.
fn steady_only(subject: &StudyCase) -> bool {
    let exact = exact_pressure(&subject.plan).ok().flatten();
    exact.is_some_and(|exact| exact.steady_only())
}

fn groups<'a>(done: &[&'a Measured]) -> BTreeMap<String, Vec<&'a Measured>> {
    let mut groups: BTreeMap<String, Vec<&Measured>> = BTreeMap::new();
    for run in done {
        groups.entry(run.variant.method()).or_default().push(run);
    }
    groups
}

fn pairs(runs: &[&Measured]) -> Vec<Pair> {
    runs.iter()
        .map(|run| (run.seconds(), run.error()))
        .collect()
}
