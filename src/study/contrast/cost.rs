//! What a contrast costs: seconds, steps and iterations of whole runs.

use std::collections::BTreeMap;

use super::{Group, OPERATORS, columns, of_operator, told};
use crate::output::{LinePlot, LineStyle, Series};
use crate::study::findings::{count, seconds};
use crate::study::{Fit, Measured, Section, Table};

/// Steps of an explicit run that are worth waiting for; beyond, its cost follows from the limit.
const MOST_STEPS: f64 = 1e6;

/// Extrapolations of all explicit methods, by name.
pub(super) type Laws = BTreeMap<String, Law>;

/// The laws of runs to the time `end`, s.
pub(super) fn laws(groups: &BTreeMap<String, Group<'_>>, end: f64) -> Laws {
    let own = groups.iter();
    own.filter_map(|(name, runs)| Some((name.clone(), Law::of(runs, end)?)))
        .collect()
}

/// Seconds of whole runs.
pub(super) fn section(groups: &BTreeMap<String, Group<'_>>, laws: &Laws) -> Section {
    let mut section = Section::new("Seconds against contrast");
    section
        .text
        .push("Wall time of whole runs, from a contrast of 1 on.".to_owned());
    let beyond = laws.iter().any(|(_, law)| law.run_to < most(groups));
    if beyond {
        section.text.push(
            "Where an explicit run would take too long, the dashed curve continues it by the steps that its own \
             stability limit asks for and the seconds per step measured."
                .to_owned(),
        );
    }
    for operator in OPERATORS {
        let own: BTreeMap<String, Group<'_>> = of_operator(groups, operator)
            .map(|(name, runs)| (name.clone(), told(runs)))
            .collect();
        draw_seconds(&mut section, operator, &own, laws);
    }
    section.tables.push(growth(groups, laws));
    section
}

/// Largest contrast that was asked for.
fn most(groups: &BTreeMap<String, Group<'_>>) -> f64 {
    let runs = groups.values().flatten();
    runs.map(|run| run.variant.value("contrast"))
        .fold(1.0, f64::max)
}

/// Seconds of an explicit method beyond what was run: steps of the limit times seconds per step.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct Law {
    /// Seconds per step.
    per_step: f64,
    /// Seconds without steps.
    start: f64,
    /// Steps at a contrast of one, which the largest mobility multiplies.
    steps: f64,
    /// Largest contrast that was run.
    run_to: f64,
}

impl Law {
    fn of(runs: &[&Measured], end: f64) -> Option<Law> {
        let done: Vec<&&Measured> = runs.iter().filter(|run| run.done()).collect();
        let first = done
            .first()
            .filter(|run| run.variant.scheme == "explicit")?;
        // A single run tells nothing about what a step costs beside the start of the program.
        let last = done.last().filter(|_| done.len() > 1)?;
        let limit = last.figure(|run| run.limit.as_ref().map_or(f64::NAN, |limit| limit.dt));
        let more = |measure: fn(&Measured) -> f64| measure(last) - measure(first);
        let per_step = more(Measured::seconds).max(0.0) / more(|run| run.steps()).max(1.0);
        // Steps per contrast from the limit of the last run: the stable step goes with its inverse.
        let steps = last.steps() / last.variant.value("contrast");
        (limit.is_finite() && limit < end).then_some(Law {
            per_step,
            start: first.seconds() - per_step * first.steps(),
            steps,
            run_to: last.variant.value("contrast"),
        })
    }

    fn seconds(&self, contrast: f64) -> f64 {
        self.start.max(0.0) + self.per_step * self.steps * contrast
    }
}

fn draw_seconds(
    section: &mut Section,
    operator: &str,
    groups: &BTreeMap<String, Group<'_>>,
    laws: &Laws,
) {
    let columns = columns(groups, Measured::seconds);
    if columns.is_empty() {
        return;
    }
    let most = most(groups);
    let beyond: Vec<(String, Vec<f64>, Vec<f64>)> = laws
        .iter()
        .filter(|(name, law)| name.ends_with(operator) && law.run_to < most)
        .map(|(name, law)| {
            let x: Vec<f64> = (0..=40)
                .map(|k| law.run_to * (most / law.run_to).powf(f64::from(k) / 40.0))
                .collect();
            let y = x.iter().map(|x| law.seconds(*x)).collect();
            (format!("{name}: expected"), x, y)
        })
        .collect();
    let series = columns
        .iter()
        .map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Line,
        })
        .chain(beyond.iter().map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Dashed,
        }));
    section.draw(
        &format!("contrast-seconds-{operator}"),
        "Wall time of whole runs against the contrast.",
        &LinePlot {
            title: &format!("Wall time against contrast, {operator} operator"),
            x_label: "contrast of permeability",
            y_label: "wall time [s]",
            x_log: true,
            y_log: true,
            series: &series.collect::<Vec<_>>(),
            note: None,
        },
    );
}

fn growth(groups: &BTreeMap<String, Group<'_>>, laws: &Laws) -> Table {
    let mut table = Table::new(
        "Growth with the contrast c over the runs made: seconds ∝ c^exponent",
        &[
            "method",
            "exponent of seconds",
            "at least contrast",
            "at most contrast",
            "steps there",
        ],
    );
    for (name, runs) in groups {
        let done: Group<'_> = told(runs).into_iter().filter(|run| run.done()).collect();
        let (Some(first), Some(last)) = (done.first(), done.last()) else {
            continue;
        };
        let pairs: Vec<(f64, f64)> = done
            .iter()
            .map(|run| (run.variant.value("contrast"), run.seconds()))
            .collect();
        let at = |run: &Measured| {
            format!(
                "{} at {:.0e}",
                seconds(run.seconds()),
                run.variant.value("contrast")
            )
        };
        let mut end = at(last);
        if let Some(law) = laws
            .get(name)
            .filter(|law| law.steps * law.run_to < MOST_STEPS)
        {
            let text = seconds(law.seconds(1e12));
            end += &format!("; ≈ {text} at 1e12");
        }
        table.rows.push(vec![
            name.clone(),
            Fit::of(&pairs).map_or("–".to_owned(), |fit| fit.to_string()),
            at(first),
            end,
            count(last.steps()),
        ]);
    }
    table
}

/// What the first solver of every scheme takes at both ends of the contrasts; the table has the others.
pub(super) fn headlines(groups: &BTreeMap<String, Group<'_>>, laws: &Laws) -> Vec<String> {
    let mut lines = Vec::new();
    let stepped = |name: &str| name.starts_with("explicit") || name.starts_with("implicit");
    for (name, runs) in groups.iter().filter(|(name, _)| stepped(name)) {
        let done: Group<'_> = told(runs).into_iter().filter(|run| run.done()).collect();
        let (Some(first), Some(last)) = (done.first(), done.last()) else {
            continue;
        };
        let ends = format!(
            "{name}: {} at contrast {:.0e}, {} at {:.0e}",
            seconds(first.seconds()),
            first.variant.value("contrast"),
            seconds(last.seconds()),
            last.variant.value("contrast"),
        );
        let beyond = laws.get(name).map(|law| {
            format!(
                ", about {} at 1e12 by its stable step",
                seconds(law.seconds(1e12))
            )
        });
        lines.push(format!("{ends}{}.", beyond.unwrap_or_default()));
    }
    lines
}
