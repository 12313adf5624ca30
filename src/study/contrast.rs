//! What a contrast of permeability costs: 1 … 1e12 × schemes × solvers × flow operators.

use std::collections::BTreeMap;

use serde_json::json;

use super::findings::{count, seconds, short};
use super::variant::Method;
use super::{
    Fit, Measured, Options, ReportContent, Section, Study, StudyCase, StudyError, Table, Variant,
};
use crate::output::{LinePlot, LineStyle, Series};
use crate::plan::PermeabilityPlan;

/// The study of contrast.
pub(super) struct Contrast;

const OPERATORS: [&str; 3] = ["path", "bond", "correspondence"];

/// Steps of an explicit run that are worth waiting for; beyond, its cost follows from the limit.
const MOST_STEPS: f64 = 1e6;

/// Error that has no place in a picture with errors of discretisation.
const VANISHING: f64 = 1e-9;

fn visible(error: f64) -> f64 {
    if error > VANISHING { error } else { f64::NAN }
}

impl Study for Contrast {
    fn name(&self) -> &'static str {
        "contrast"
    }

    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        let key = Layered::of(subject)?;
        let decades: &[i32] = match options.quick {
            true => &[0, 2, 4, 8, 12],
            false => &[0, 1, 2, 3, 4, 6, 8, 10, 12],
        };
        let method = |scheme, integrator| Method { scheme, integrator };
        let methods = [
            (method("implicit", Some("tr-bdf2")), "transient"),
            (method("implicit", None), "steady"),
            (method("explicit", None), "transient"),
        ];
        let mut solvers = subject.solvers("implicit", options);
        if options.solvers.is_empty() {
            solvers.push("faer-cg:preconditioner=jacobi".to_owned());
        }
        let mut variants = Vec::new();
        for (method, mode) in methods {
            if !options.wants_scheme(method.scheme) {
                continue;
            }
            let none = ["-".to_owned()];
            let solvers = if method.scheme == "explicit" {
                &none[..]
            } else {
                &solvers[..]
            };
            for (operator, solver) in OPERATORS
                .iter()
                .flat_map(|o| solvers.iter().map(move |s| (o, s)))
            {
                for &decade in decades {
                    let contrast = 10_f64.powi(decade);
                    let mut variant = method
                        .variant(Some(solver))
                        .set([
                            format!("time.mode=\"{mode}\""),
                            format!("flow.operator=\"{operator}\""),
                            format!(
                                "materials.{}.permeability={:e}",
                                key.name,
                                contrast * key.other
                            ),
                        ])
                        .with("contrast", contrast);
                    if mode == "steady" {
                        variant.scheme = "steady".to_owned();
                    }
                    variant.operator = Some((*operator).to_owned());
                    variant.weight = match method.scheme {
                        // What an explicit run takes to a contrast of 1e4 is worth knowing early.
                        "explicit" => 1e-4 * contrast,
                        _ => 1.0 + 0.01 * f64::from(decade),
                    };
                    variants.push(variant);
                }
            }
        }
        Ok(variants)
    }

    fn findings(&self, subject: &StudyCase, runs: &[Measured]) -> ReportContent {
        let mut groups: BTreeMap<String, Vec<&Measured>> = BTreeMap::new();
        for run in runs {
            groups.entry(run.variant.method()).or_default().push(run);
        }
        for runs in groups.values_mut() {
            runs.sort_by(|a, b| {
                a.variant
                    .value("contrast")
                    .total_cmp(&b.variant.value("contrast"))
            });
        }
        let end = subject.plan.time.end;
        let laws: BTreeMap<&String, Law> = groups
            .iter()
            .filter_map(|(name, runs)| Some((name, Law::of(runs, end)?)))
            .collect();
        let mut cost = Section::new("Seconds against contrast");
        cost.text.push(
            "Wall time of whole runs. The explicit scheme is as fast as its stable step lets it be, and \
             that shrinks with the largest mobility; where a run would take too long, the dashed curve \
             continues it by the steps that its own limit asks for and the seconds per step measured."
                .to_owned(),
        );
        let by_operator = |operator: &str| -> BTreeMap<String, Vec<&Measured>> {
            let own = groups.iter().filter(|(name, _)| name.ends_with(operator));
            own.map(|(name, runs)| (name.clone(), runs.clone()))
                .collect()
        };
        for operator in OPERATORS {
            draw_seconds(&mut cost, operator, &by_operator(operator), &laws);
        }
        cost.tables.push(growth(&groups, &laws));
        let mut errors = Section::new("Error against contrast");
        errors.text.push(
            "The path operator takes what lies between the points of cells that touch, the bond operator the \
             harmonic mean of the mobilities at both ends of a bond, the correspondence operator that of the \
             point: across an interface it overrates the flux."
                .to_owned(),
        );
        errors.text.push(format!(
            "Errors below {VANISHING:.0e}, as without a contrast, are left out of the pictures."
        ));
        let mut effort = Section::new("Iterations and steps");
        type Picture = (
            &'static str,
            &'static str,
            &'static str,
            fn(&Measured) -> f64,
        );
        let of_error: [Picture; 2] = [
            (
                "pressure",
                "Error of the pressure",
                "relative error",
                |run| visible(run.errors().get("pressure").copied().unwrap_or(f64::NAN)),
            ),
            (
                "flux",
                "Error of the steady flux",
                "relative error",
                |run| visible(run.error_of("flux", |error| error.max)),
            ),
        ];
        let of_effort: [Picture; 2] = [
            (
                "iterations",
                "Krylov iterations per solve",
                "iterations",
                |run| run.solver(|done| done.iterations) / run.solver(|done| done.solves),
            ),
            ("steps", "Steps", "steps", |run| run.steps()),
        ];
        for operator in OPERATORS {
            let own = by_operator(operator);
            for (section, pictures) in [(&mut errors, of_error), (&mut effort, of_effort)] {
                for (file, title, label, measure) in pictures {
                    let file = format!("contrast-{file}-{operator}");
                    let title = format!("{title}, {operator} operator");
                    draw(section, &file, &title, label, &own, measure);
                }
            }
        }
        let headlines = headlines(&groups, &laws);
        ReportContent {
            facts: json!({ "laws": laws, "headlines": headlines }),
            headlines,
            sections: vec![cost, errors, effort],
        }
    }
}

/// The material whose permeability is varied, and that of the other.
struct Layered {
    name: String,
    other: f64,
}

impl Layered {
    fn of(subject: &StudyCase) -> Result<Self, StudyError> {
        let uniform: Vec<(&String, f64)> = subject
            .plan
            .materials
            .iter()
            .filter_map(|material| match material.permeability {
                Some(PermeabilityPlan::Uniform(value)) => Some((&material.name, value)),
                _ => None,
            })
            .collect();
        let most = uniform.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let least = uniform.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        match (most, least, uniform.len(), subject.plan.materials.len()) {
            (Some(most), Some(least), 2, 2) => Ok(Layered {
                name: most.0.clone(),
                other: least.1,
            }),
            _ => Err(StudyError::Unsuited {
                study: "the contrast study",
                case: subject.plan.case.clone(),
                reason: "it needs exactly two materials with one permeability each; two-layer, \
                         channel and barrier are such cases"
                    .to_owned(),
            }),
        }
    }
}

/// Seconds of an explicit method beyond what was run: steps of the limit times seconds per step.
#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Law {
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
    groups: &BTreeMap<String, Vec<&Measured>>,
    laws: &BTreeMap<&String, Law>,
) {
    let columns = columns(groups, Measured::seconds);
    let most = groups
        .values()
        .flatten()
        .map(|run| run.variant.value("contrast"));
    let most = most.fold(1.0, f64::max);
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
        "The explicit cost grows with the contrast, the implicit cost stays flat.",
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

fn columns(
    groups: &BTreeMap<String, Vec<&Measured>>,
    measure: impl Fn(&Measured) -> f64,
) -> Vec<(String, Vec<f64>, Vec<f64>)> {
    let column = |(name, runs): (&String, &Vec<&Measured>)| {
        let pairs = runs
            .iter()
            .map(|run| (run.variant.value("contrast"), measure(run)));
        let (x, y): (Vec<f64>, Vec<f64>) = pairs.filter(|pair| pair.1 > 0.0).unzip();
        (name.clone(), x, y)
    };
    groups
        .iter()
        .map(column)
        .filter(|(_, x, _)| !x.is_empty())
        .collect()
}

fn draw(
    section: &mut Section,
    file: &str,
    title: &str,
    y_label: &str,
    groups: &BTreeMap<String, Vec<&Measured>>,
    measure: impl Fn(&Measured) -> f64,
) {
    let columns = columns(groups, measure);
    let lines = columns.iter();
    let series: Vec<Series<'_>> = lines
        .map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Line,
        })
        .collect();
    section.draw(
        file,
        title,
        &LinePlot {
            title,
            x_label: "contrast of permeability",
            y_label,
            x_log: true,
            y_log: true,
            series: &series,
            note: None,
        },
    );
}

fn growth(groups: &BTreeMap<String, Vec<&Measured>>, laws: &BTreeMap<&String, Law>) -> Table {
    let mut table = Table::new(
        "Growth with the contrast c over the runs made: seconds ∝ c^exponent",
        &[
            "method",
            "exponent of seconds",
            "at least contrast",
            "at most contrast",
            "steps there",
            "flux error there",
        ],
    );
    for (name, runs) in groups {
        let done: Vec<&&Measured> = runs.iter().filter(|run| run.done()).collect();
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
            short(last.error_of("flux", |error| error.max)),
        ]);
    }
    table
}

fn headlines(
    groups: &BTreeMap<String, Vec<&Measured>>,
    laws: &BTreeMap<&String, Law>,
) -> Vec<String> {
    let mut lines = Vec::new();
    // The first solver stands for the implicit schemes; the table has the others.
    let told = |name: &str| name.starts_with("explicit") || name.starts_with("implicit");
    for (name, runs) in groups.iter().filter(|(name, _)| told(name)) {
        let done: Vec<&&Measured> = runs.iter().filter(|run| run.done()).collect();
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
