//! What operators do to the steady flux, beside what is known of it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::exact::{Known, Measure, driven, known, outlet};
use super::rock::Varied;
use super::{Group, OPERATORS, STEADY, of_operator};
use crate::output::LinePlot;
use crate::study::chart::{Marks, series};
use crate::study::findings::short;
use crate::study::{Coverage, Measured, Section, StudyCase, Table};

/// What the flux showed.
pub(super) struct FluxFindings {
    pub(super) section: Section,
    pub(super) headlines: Vec<String>,
    pub(super) rows: Vec<FluxRow>,
}

/// The steady flux of one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct FluxRow {
    operator: String,
    contrast: f64,
    /// Rate of outflow, m³/s.
    rate: f64,
    /// What is known of it, m³/s.
    known: f64,
    /// |rate/known − 1|.
    error: f64,
}

/// Errors below are drawn there: rounding, or none at all.
const FLOOR: f64 = 1e-16;

/// The name of the flux between two points in pictures and tables.
const TWO_POINT: &str = "two-point flux";

/// Holds the flux of all steady runs against what is known of it.
pub(super) fn section(subject: &StudyCase, groups: &BTreeMap<String, Group<'_>>) -> FluxFindings {
    let mut section = Section::new("Error of the steady flux against contrast");
    let runs: Vec<&Measured> = OPERATORS
        .iter()
        .filter_map(|operator| widest(groups, operator))
        .flatten()
        .copied()
        .collect();
    let coverage = Coverage::of(runs.iter().copied());
    let known = known_at(subject, &runs);
    let rows = rows(subject, &runs, &known);
    let measure = known.first().map(|(_, known)| known.measure);
    let (Some(measure), false) = (measure, rows.is_empty()) else {
        section.text.push(match driven(&subject.plan) {
            Some(_) => format!("No flux was measured: {coverage}."),
            None => "The case is not a plane lattice between two sides of prescribed pressure, so nothing is known of \
                     its flux."
                .to_owned(),
        });
        return FluxFindings {
            section,
            headlines: Vec::new(),
            rows: Vec::new(),
        };
    };
    let curves = curves(&rows, measure, &known);
    section.text.push(words(measure).to_owned());
    if coverage.done() < runs.len() {
        section.text.push(format!("{coverage}."));
    }
    if rows.iter().any(|row| row.error < FLOOR) {
        section
            .text
            .push(format!("Errors below {FLOOR:.0e} are drawn there."));
    }
    draw(&mut section, &curves);
    section.tables.push(table(&curves));
    FluxFindings {
        headlines: headlines(&curves, measure),
        section,
        rows,
    }
}

fn words(measure: Measure) -> &'static str {
    match measure {
        Measure::Series => {
            "All points of a row across the flow are of one rock, so that the flux is that of layers in series, \
             Δp A/∫ds/κ, with their interfaces where the regions of the scene have them. The flux between two \
             points per face takes an interface to lie on the face that the materials of the points put it on."
        }
        Measure::Cylinders => {
            "The domain is one of a square array of cylinders, across which the flux is exact by Rayleigh's method. The flux \
             between two points per face has the cylinder that the materials of the points make."
        }
        Measure::TwoPoint => {
            "The measure is the flux between two points per face on the same points, which has the channels and \
             barriers that the points have; it is itself an approximation, of an error that this study does not tell."
        }
    }
}

/// The steady runs of an operator by one solver, the one with most of them.
fn widest<'a, 'b>(
    groups: &'b BTreeMap<String, Group<'a>>,
    operator: &'b str,
) -> Option<&'b Group<'a>> {
    let steady = of_operator(groups, operator).filter(|(name, _)| name.starts_with(STEADY));
    steady.map(|(_, runs)| runs).max_by_key(|runs| runs.len())
}

/// What is known at every contrast of the runs that are done, by contrast.
fn known_at(subject: &StudyCase, runs: &[&Measured]) -> Vec<(f64, Known)> {
    let Ok(varied) = Varied::of(subject) else {
        return Vec::new();
    };
    let mut contrasts: Vec<f64> = runs
        .iter()
        .filter(|run| run.done())
        .map(|run| run.variant.value("contrast"))
        .collect();
    contrasts.sort_unstable_by(f64::total_cmp);
    contrasts.dedup();
    let at = |contrast: f64| {
        let plan = varied.plan_at(&subject.plan, contrast);
        Some((contrast, known(&plan)?))
    };
    contrasts.into_iter().filter_map(at).collect()
}

fn rows(subject: &StudyCase, runs: &[&Measured], known: &[(f64, Known)]) -> Vec<FluxRow> {
    let Some((axis, _)) = driven(&subject.plan) else {
        return Vec::new();
    };
    let row = |run: &&Measured| {
        let contrast = run.variant.value("contrast");
        let known = known
            .iter()
            .find(|(own, _)| own.total_cmp(&contrast).is_eq())?;
        let rate = *run.summary()?.outflow.get(outlet(axis))?;
        Some(FluxRow {
            operator: run.variant.operator.clone()?,
            contrast,
            rate,
            known: known.1.rate,
            error: (rate / known.1.rate - 1.0).abs(),
        })
    };
    runs.iter().filter_map(row).collect()
}

/// Name and (contrast, error) of every operator, and of the flux between two points where it is not the measure.
fn curves(
    rows: &[FluxRow],
    measure: Measure,
    known: &[(f64, Known)],
) -> Vec<(String, Vec<(f64, f64)>)> {
    let of = |operator: &&str| {
        let own = rows.iter().filter(|row| row.operator == **operator);
        let pairs: Vec<(f64, f64)> = own.map(|row| (row.contrast, row.error)).collect();
        ((*operator).to_owned(), pairs)
    };
    let mut curves: Vec<_> = OPERATORS.iter().map(of).collect();
    if measure != Measure::TwoPoint {
        let own = known.iter();
        let pairs = own.map(|(contrast, own)| (*contrast, (own.two_point / own.rate - 1.0).abs()));
        curves.push((TWO_POINT.to_owned(), pairs.collect()));
    }
    curves.retain(|(_, pairs)| !pairs.is_empty());
    curves
}

fn draw(section: &mut Section, curves: &[(String, Vec<(f64, f64)>)]) {
    let caption = match curves.iter().any(|(name, _)| name == TWO_POINT) {
        true => {
            "Error of the steady flux by operator, a mark per run; the two-point flux is computed without one."
        }
        false => "Error of the steady flux by operator, a mark per run.",
    };
    let curve = |(name, pairs): &(String, Vec<(f64, f64)>)| {
        Marks::joined(name, pairs.iter().map(|(x, error)| (*x, error.max(FLOOR))))
    };
    let marks: Vec<Marks> = curves.iter().map(curve).collect();
    section.draw(
        "contrast-flux",
        caption,
        &LinePlot {
            title: "Error of the steady flux against contrast",
            x_label: "contrast of permeability",
            y_label: "relative error",
            x_log: true,
            y_log: true,
            series: &series(&marks, &[]),
            note: None,
        },
    );
}

fn table(curves: &[(String, Vec<(f64, f64)>)]) -> Table {
    let mut head = vec!["contrast"];
    head.extend(curves.iter().map(|(name, _)| name.as_str()));
    let mut table = Table::new("Relative error of the steady flux", &head);
    let mut contrasts: Vec<f64> = curves
        .iter()
        .flat_map(|(_, pairs)| pairs)
        .map(|p| p.0)
        .collect();
    contrasts.sort_unstable_by(f64::total_cmp);
    contrasts.dedup();
    for contrast in contrasts {
        let cell = |pairs: &[(f64, f64)]| {
            let own = pairs.iter().find(|(x, _)| x.total_cmp(&contrast).is_eq());
            own.map_or("–".to_owned(), |(_, error)| short(*error))
        };
        let mut row = vec![format!("{contrast:.0e}")];
        row.extend(curves.iter().map(|(_, pairs)| cell(pairs)));
        table.rows.push(row);
    }
    table
}

/// The largest error of every curve, and where it is.
fn headlines(curves: &[(String, Vec<(f64, f64)>)], measure: Measure) -> Vec<String> {
    let from = match measure {
        Measure::Series | Measure::Cylinders => "the exact one",
        Measure::TwoPoint => "the two-point flux",
    };
    let line = |(name, pairs): &(String, Vec<(f64, f64)>)| {
        let worst = pairs.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let [low, high] = [pairs.first()?.0, pairs.last()?.0];
        Some(match pairs.len() {
            1 => format!(
                "{name}: steady flux off {from} by {} at {low:.0e}, the only contrast done.",
                short(worst.1)
            ),
            count => format!(
                "{name}: steady flux off {from} by at most {} at {count} contrasts from {low:.0e} to {high:.0e}, \
                 the most at {:.0e}.",
                short(worst.1),
                worst.0
            ),
        })
    };
    curves.iter().filter_map(line).collect()
}
