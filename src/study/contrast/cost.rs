//! What a contrast costs: seconds, steps and iterations of whole runs.

use std::collections::BTreeMap;

use super::{Group, OPERATORS, curve, of_operator, told};
use crate::output::LinePlot;
use crate::study::chart::{self, Marks, legend, series};
use crate::study::findings::{count, seconds};
use crate::study::{Coverage, Fit, Measured, Section, Table};

/// How many times as long the last run must take as the first for its steps to be told from the start of the program.
const TOLD_APART: f64 = 1.5;

/// Extrapolations of all explicit methods, by name.
pub(super) type Laws = BTreeMap<String, Law>;

/// The laws of runs to the time `end`, s, of methods that were not run up to the largest contrast.
pub(super) fn laws(groups: &BTreeMap<String, Group<'_>>, end: f64) -> Laws {
    let most = most(groups);
    let own = groups.iter();
    own.filter_map(|(name, runs)| Some((name.clone(), Law::of(runs, end, most)?)))
        .collect()
}

/// Seconds of whole runs.
pub(super) fn section(groups: &BTreeMap<String, Group<'_>>, laws: &Laws) -> Section {
    let mut section = Section::new("Seconds against contrast");
    let runs: Group<'_> = groups.values().flat_map(|runs| told(runs)).collect();
    let coverage = Coverage::of(runs.iter().copied());
    if coverage.done() == 0 {
        section.text.push(format!(
            "No run from a contrast of 1 on tells its seconds: {coverage}."
        ));
        return section;
    }
    section.text.push(format!(
        "Wall time of whole runs, from a contrast of 1 on: {coverage}."
    ));
    if !laws.is_empty() {
        section.text.push(
            "Dashed curves are extrapolated beyond the largest contrast that an explicit method was run at, by the \
             steps that its own stability limit asks for and the seconds per step measured."
                .to_owned(),
        );
    }
    for operator in OPERATORS {
        let own: BTreeMap<String, Group<'_>> = of_operator(groups, operator)
            .map(|(name, runs)| (name.clone(), told(runs)))
            .collect();
        draw_seconds(&mut section, operator, &own, laws);
    }
    section.tables.push(growth(groups));
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
    /// Largest contrast that was asked for.
    asked: f64,
}

impl Law {
    /// The law of an explicit method that was run at two contrasts at least, the last of which took so much longer
    /// that this tells what a step costs; `None` for all others and where nothing is left to extrapolate to.
    fn of(runs: &[&Measured], end: f64, asked: f64) -> Option<Law> {
        let done: Vec<&&Measured> = runs.iter().filter(|run| run.done()).collect();
        let (first, last) = (done.first()?, done.last()?);
        let run_to = last.variant.value("contrast");
        let limit = last.figure(|run| run.limit.as_ref().map_or(f64::NAN, |limit| limit.dt));
        let more = |measure: fn(&Measured) -> f64| measure(last) - measure(first);
        let tells = first.variant.scheme == "explicit"
            && run_to < asked
            && limit < end
            && more(|run| run.steps()) > 0.0
            && last.seconds() > TOLD_APART * first.seconds();
        let per_step = more(Measured::seconds) / more(|run| run.steps());
        tells.then(|| Law {
            per_step,
            start: (first.seconds() - per_step * first.steps()).max(0.0),
            // From the limit of the last run: the stable step goes with the inverse of the contrast.
            steps: last.steps() / run_to,
            run_to,
            asked,
        })
    }

    fn seconds(&self, contrast: f64) -> f64 {
        self.start + self.per_step * self.steps * contrast
    }

    /// From the largest contrast that was run to the largest that was asked for.
    fn curve(&self) -> impl Iterator<Item = (f64, f64)> {
        let at = |k: i32| self.run_to * (self.asked / self.run_to).powf(f64::from(k) / 40.0);
        (0..=40).map(at).map(|x| (x, self.seconds(x)))
    }
}

fn draw_seconds(
    section: &mut Section,
    operator: &str,
    groups: &BTreeMap<String, Group<'_>>,
    laws: &Laws,
) {
    let own = laws.iter().filter(|(name, _)| name.ends_with(operator));
    let beyond: Vec<chart::Law> = own
        .map(|(name, law)| chart::Law::new(&format!("{name}: extrapolated"), law.curve()))
        .collect();
    let ranged = |(name, runs): (&String, &Group<'_>)| {
        let place = |run: &Measured, wall| (run.variant.value("contrast"), wall);
        Some(curve(name, runs, Measured::seconds)?.ranged(runs, place))
    };
    let marks: Vec<Marks> = groups.iter().filter_map(ranged).collect();
    section.draw(
        &format!("contrast-seconds-{operator}"),
        &format!(
            "Wall time of whole runs against the contrast. {}",
            legend(groups.values().flatten().copied())
        ),
        &LinePlot {
            title: &format!("Wall time against contrast, {operator} operator"),
            x_label: "contrast of permeability",
            y_label: "wall time [s]",
            x_log: true,
            y_log: true,
            series: &series(&marks, &beyond),
            note: None,
        },
    );
}

/// The runs of a method that tell their seconds.
fn timed<'a>(runs: &[&'a Measured]) -> Group<'a> {
    told(runs).into_iter().filter(|run| run.done()).collect()
}

/// Wall time of a run and where it was taken.
fn at(run: &Measured) -> String {
    let contrast = run.variant.value("contrast");
    format!("{} at {contrast:.0e}", seconds(run.seconds()))
}

fn growth(groups: &BTreeMap<String, Group<'_>>) -> Table {
    let mut table = Table::new(
        "Growth with the contrast c over the runs made: seconds ∝ c^exponent, from three runs on",
        &[
            "method",
            "runs",
            "exponent of seconds",
            "at least contrast",
            "at most contrast",
            "steps there",
        ],
    );
    for (name, runs) in groups {
        let done = timed(runs);
        let (Some(first), Some(last)) = (done.first(), done.last()) else {
            continue;
        };
        let pairs: Vec<(f64, f64)> = done
            .iter()
            .map(|run| (run.variant.value("contrast"), run.seconds()))
            .collect();
        table.rows.push(vec![
            name.clone(),
            format!("{} of {}", done.len(), told(runs).len()),
            Fit::confident(&pairs).map_or("–".to_owned(), |fit| fit.to_string()),
            at(first),
            at(last),
            count(last.steps()),
        ]);
    }
    table
}

/// What time stepping takes at the least and the largest contrast run, and by extrapolation at the largest asked for.
pub(super) fn headlines(groups: &BTreeMap<String, Group<'_>>, laws: &Laws) -> Vec<String> {
    let stepped = |name: &str| name.starts_with("explicit") || name.starts_with("implicit");
    let line = |(name, runs): (&String, &Group<'_>)| {
        let done = timed(runs);
        let (first, last) = (done.first()?, done.last()?);
        let law = laws.get(name).map_or(String::new(), |law| {
            let beyond = seconds(law.seconds(law.asked));
            format!(
                "; extrapolated by its stable step: about {beyond} at {:.0e}",
                law.asked
            )
        });
        Some(match done.len() {
            1 => format!("{name}: {}, the only contrast done.", at(first)),
            _ => format!("{name}: {}, {}{law}.", at(first), at(last)),
        })
    };
    let own = groups.iter().filter(|(name, _)| stepped(name));
    own.filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Row, Status, Variant};

    /// A run at a contrast, done in so many seconds or not at all.
    fn run(contrast: f64, wall_s: Option<f64>) -> Measured {
        let variant = Variant {
            scheme: "implicit".to_owned(),
            solver: "-".to_owned(),
            operator: Some("path".to_owned()),
            ..Variant::default()
        };
        let status = wall_s.map_or(Status::NotRun, |_| Status::Done);
        let mut row = Row::unmeasured(String::new(), 0, status, String::new());
        row.wall_s = wall_s.unwrap_or(f64::NAN);
        Measured::new(variant.with("contrast", contrast), vec![row])
    }

    fn lines(runs: &[Measured]) -> (Vec<String>, Vec<String>) {
        let groups = super::super::groups(runs);
        let rows = growth(&groups).rows;
        (headlines(&groups, &Laws::new()), rows.concat())
    }

    #[test]
    fn seconds_are_told_of_contrasts_that_were_run_only() {
        let (told, rows) = lines(&[run(1.0, None), run(1e4, None)]);
        assert!(told.is_empty() && rows.is_empty());
        let (told, rows) = lines(&[run(1.0, Some(1.0)), run(1e4, None)]);
        assert_eq!(
            told,
            ["implicit, path: 1.00 s at 1e0, the only contrast done."]
        );
        assert_eq!(rows[1..3], ["1 of 2", "–"]);
        let (told, rows) = lines(&[run(1.0, Some(1.0)), run(1e4, Some(2.0)), run(1e12, None)]);
        assert_eq!(told, ["implicit, path: 1.00 s at 1e0, 2.00 s at 1e4."]);
        assert_eq!(rows[1..3], ["2 of 3", "–"], "two runs tell no exponent");
    }

    #[test]
    fn a_section_without_a_run_says_so_and_shows_nothing() {
        let runs = [run(1.0, None), run(1e4, None)];
        let section = section(&super::super::groups(&runs), &Laws::new());
        assert!(section.figures.is_empty() && section.tables.is_empty());
        let text = section.text.concat();
        assert!(text.contains("0 of 2 runs done, 2 not run"), "{text}");
    }
}
