//! Orders in space and time, for every field, with their confidence.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::findings::{count, short};
use super::over_resolved::{OverResolved, SECOND_ORDER};
use super::{
    Fit, Measured, Options, RecordedOutput, ReportContent, Section, Study, StudyCase, StudyError,
    Table, Variant, profile,
};
use crate::output::{LinePlot, LineStyle, Series};

/// The study of convergence.
pub(super) struct Convergence;

/// Steps of the runs that are compared.
const STEPS: [u32; 5] = [8, 16, 32, 64, 128];
/// Steps of the run they are compared with, by the second-order method.
const OVER_RESOLVED: u32 = 2048;
/// Steps of the run that verifies the over-resolved one.
const VERIFYING: u32 = 1024;

impl Study for Convergence {
    fn name(&self) -> &'static str {
        "convergence"
    }

    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        if subject.plan.output.profiles.is_empty() {
            return Err(unsuited(
                subject,
                "the orders in time compare profiles; add one under \
                                          [output.profiles]",
            ));
        }
        let mut variants = self.in_time(subject, options)?;
        variants.extend(self.in_space(subject, options));
        Ok(variants)
    }

    fn findings(&self, _: &StudyCase, runs: &[Measured]) -> ReportContent {
        let (time, time_laws, verified) = in_time(runs);
        let (space, space_laws) = in_space(runs);
        let mut headlines: Vec<String> =
            time_laws.iter().chain(&space_laws).map(Law::line).collect();
        headlines.extend(verified);
        ReportContent {
            facts: json!({ "time": time_laws, "space": space_laws }),
            headlines,
            sections: vec![time, space],
        }
    }
}

fn unsuited(subject: &StudyCase, reason: &str) -> StudyError {
    StudyError::Unsuited {
        study: "the convergence study",
        case: subject.plan.case.clone(),
        reason: reason.to_owned(),
    }
}

impl Convergence {
    /// Constant steps on one cloud, and an over-resolved run: what differs is the error in time alone.
    fn in_time(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        let end = subject.plan.time.end;
        let implicit = subject
            .methods(options)
            .into_iter()
            .filter(|m| m.integrator.is_some());
        // The semi-implicit scheme stops relaxing at a tolerance of its own, which hides the order.
        let methods: Vec<_> = implicit
            .filter(|method| method.scheme != "semi-implicit")
            .collect();
        let Some(best) = methods
            .iter()
            .find(|method| method.integrator == Some("tr-bdf2"))
        else {
            return Err(unsuited(
                subject,
                "it needs an implicit scheme; see --schemes",
            ));
        };
        let grids = subject.grids(options, (60, 1200));
        let grid = grids
            .iter()
            .rev()
            .nth(usize::from(options.quick && grids.len() > 1));
        let run = |method: &super::Method, steps: u32, role: f64| {
            let solvers = subject.solvers(method.scheme, options);
            let mut variant = method
                .variant(solvers.first().map(String::as_str))
                .set(grid.and_then(|grid| grid.overrides.clone()))
                .set([
                    format!("time.step={:?}", end / f64::from(steps)),
                    "output.times=[]".to_owned(),
                    "output.plots=false".to_owned(),
                ])
                .with("steps", f64::from(steps))
                .with("role", role);
            if subject.is_coupled() {
                variant = variant.set(["scheme.coupling_tolerance=1e-11".to_owned()]);
            }
            variant.weight = f64::from(steps);
            variant.kept = RecordedOutput::End;
            variant
        };
        let mut variants = Vec::new();
        let most = if options.quick { 4 } else { 5 };
        for method in &methods {
            variants.extend(STEPS[..most].iter().map(|steps| run(method, *steps, TIME)));
        }
        let halved = if options.quick { 2 } else { 1 };
        variants.push(run(best, VERIFYING / halved, VERIFICATION));
        variants.push(run(best, OVER_RESOLVED / halved, REFERENCE));
        Ok(variants)
    }

    /// Clouds with halved spacing and a tolerance far below the error in space.
    fn in_space(&self, subject: &StudyCase, options: &Options) -> Vec<Variant> {
        if subject.plan.reference.is_none() {
            return Vec::new();
        }
        let most = if options.quick { 1100 } else { 2000 };
        let implicit = subject.methods(options).into_iter();
        let Some(method) = implicit.clone().find(|m| m.integrator == Some("tr-bdf2")) else {
            return Vec::new();
        };
        let solvers = subject.solvers(method.scheme, options);
        let tolerance = if options.quick { "1e-6" } else { "1e-7" };
        let variant = |grid: super::Grid| {
            let mut variant = method
                .variant(solvers.first().map(String::as_str))
                .set(grid.overrides.clone())
                .set([
                    format!("time.tolerance={tolerance}"),
                    "output.plots=false".to_owned(),
                ])
                .with("spacing", grid.spacing)
                .with("role", SPACE);
            variant.weight = 10.0 * grid.points as f64;
            variant
        };
        subject
            .grids(options, (60, most))
            .into_iter()
            .map(variant)
            .collect()
    }
}

/// What a run is for.
const TIME: f64 = 0.0;
const VERIFICATION: f64 = 1.0;
const REFERENCE: f64 = 2.0;
const SPACE: f64 = 3.0;

fn of_role(runs: &[Measured], role: f64) -> impl Iterator<Item = &Measured> {
    let plays = move |run: &&Measured| (run.variant.value("role") - role).abs() < 0.5;
    runs.iter().filter(plays).filter(|run| run.done())
}

/// An order that was seen.
#[derive(Debug, Clone, serde::Serialize)]
struct Law {
    method: String,
    field: String,
    what: &'static str,
    fit: Fit,
    theory: f64,
    pairs: Vec<(f64, f64)>,
}

impl Law {
    fn line(&self) -> String {
        let Law {
            method,
            field,
            what,
            fit,
            theory,
            ..
        } = self;
        format!("{method}: {field} is of order {fit} in {what} (theory {theory:.0}).")
    }

    fn cells(&self) -> Vec<String> {
        vec![
            self.method.clone(),
            self.field.clone(),
            self.fit.to_string(),
            format!("{:.0}", self.theory),
            count(self.fit.pairs as f64),
            self.pairs
                .last()
                .map_or("–".to_owned(), |pair| short(pair.1)),
        ]
    }
}

const HEAD: [&str; 6] = [
    "method",
    "field",
    "order seen",
    "theory",
    "runs",
    "smallest error",
];

fn in_time(runs: &[Measured]) -> (Section, Vec<Law>, Option<String>) {
    let mut section = Section::new("Orders in time");
    section.text.push(
        "Constant steps on one cloud. The error is the distance of the fields along the case's profiles at \
         the end from those of an over-resolved run of the second-order method on the same cloud, so that \
         the error in space does not enter. Runs within ten times the uncertainty of the over-resolved one are \
         left out of the fits."
            .to_owned(),
    );
    let chain = of_role(runs, REFERENCE).chain(of_role(runs, VERIFICATION));
    let exact = of_role(runs, REFERENCE)
        .next()
        .and_then(|_| OverResolved::of(&chain.collect::<Vec<_>>(), profile::apart, SECOND_ORDER));
    let Some(exact) = exact else {
        section
            .text
            .push("The over-resolved run is missing, so there are no orders in time.".to_owned());
        return (section, Vec::new(), None);
    };
    let reference = exact.run;
    let verified = exact.verdict().map(|uncertainties| {
        format!(
            "The over-resolved run ({} steps) is itself good to, by Richardson's rule with a run of half \
             its steps: {uncertainties}.",
            count(reference.variant.value("steps")),
        )
    });
    section.text.extend(verified.clone());
    let end = reference.figure(|run| run.t_end);
    let mut methods: BTreeMap<String, Vec<&Measured>> = BTreeMap::new();
    for run in of_role(runs, TIME) {
        methods
            .entry(run.variant.scheme.clone())
            .or_default()
            .push(run);
    }
    let mut laws = Vec::new();
    for (method, mut runs) in methods {
        runs.sort_by(|a, b| {
            a.variant
                .value("steps")
                .total_cmp(&b.variant.value("steps"))
        });
        for (field, _) in &reference.first().fields {
            let sure = 10.0 * exact.uncertainty.get(field).copied().unwrap_or(0.0);
            let pairs: Vec<(f64, f64)> = runs
                .iter()
                .filter_map(|run| {
                    let distance = *exact.distances(run).get(field)?;
                    Some((end / run.variant.value("steps"), distance))
                })
                .filter(|pair| pair.1 > sure)
                .collect();
            if let Some(fit) = Fit::of(asymptotic(&pairs)) {
                let theory = if method.contains("TR-BDF2") { 2.0 } else { 1.0 };
                laws.push(Law {
                    method: method.clone(),
                    field: field.clone(),
                    what: "time",
                    fit,
                    theory,
                    pairs,
                });
            }
        }
    }
    finish(
        &mut section,
        "convergence-time",
        "Error against step",
        "step [s]",
        &laws,
    );
    (section, laws, verified)
}

/// The four finest: the coarsest runs are not yet where the leading term of the error rules.
fn asymptotic(pairs: &[(f64, f64)]) -> &[(f64, f64)] {
    &pairs[pairs.len().saturating_sub(4)..]
}

fn in_space(runs: &[Measured]) -> (Section, Vec<Law>) {
    let mut section = Section::new("Orders in space");
    section.text.push(
        "Clouds with halved spacing at a small tolerance of the steps: root mean square errors against the \
         exact solution, the largest of all outputs, relative to the range."
            .to_owned(),
    );
    let mut runs: Vec<&Measured> = of_role(runs, SPACE).collect();
    runs.sort_by(|a, b| {
        b.variant
            .value("spacing")
            .total_cmp(&a.variant.value("spacing"))
    });
    let fields: BTreeSet<String> = runs
        .iter()
        .flat_map(|run| run.errors().into_keys())
        .collect();
    let mut laws = Vec::new();
    for field in fields {
        let pairs: Vec<(f64, f64)> = runs
            .iter()
            .filter_map(|run| Some((run.variant.value("spacing"), *run.errors().get(&field)?)))
            .collect();
        let method = runs
            .first()
            .map_or(String::new(), |run| run.variant.scheme.clone());
        if let Some(fit) = Fit::of(asymptotic(&pairs)) {
            laws.push(Law {
                method,
                field,
                what: "space",
                fit,
                theory: 2.0,
                pairs,
            });
        }
    }
    finish(
        &mut section,
        "convergence-space",
        "Error against spacing",
        "spacing [m]",
        &laws,
    );
    (section, laws)
}

fn finish(section: &mut Section, file: &str, title: &str, x_label: &str, laws: &[Law]) {
    let mut table = Table::new(
        "Orders with their 95 % confidence, over the four finest runs",
        &HEAD,
    );
    table.rows.extend(laws.iter().map(Law::cells));
    let columns: Vec<(String, Vec<f64>, Vec<f64>)> = laws
        .iter()
        .map(|law| {
            let (x, y) = law.pairs.iter().copied().unzip();
            (format!("{}, {}", law.method, law.field), x, y)
        })
        .collect();
    let guides = guides(laws);
    let series = columns
        .iter()
        .map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Line,
        })
        .chain(guides.iter().map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Dashed,
        }));
    section.draw(
        file,
        "Straight in logarithms, as steep as the order; dashed: the slopes of theory.",
        &LinePlot {
            title,
            x_label,
            y_label: "relative error",
            x_log: true,
            y_log: true,
            series: &series.collect::<Vec<_>>(),
            note: None,
        },
    );
    section.tables.push(table);
}

/// Lines of the orders of theory, just below the lowest curve that should follow them.
fn guides(laws: &[Law]) -> Vec<(String, Vec<f64>, Vec<f64>)> {
    let mut guides = Vec::new();
    for theory in [1.0_f64, 2.0] {
        let own = laws.iter().filter(|law| (law.theory - theory).abs() < 0.5);
        let pairs: Vec<(f64, f64)> = own.flat_map(|law| law.pairs.iter().copied()).collect();
        let factor = pairs
            .iter()
            .map(|(x, y)| y / x.powf(theory))
            .fold(f64::INFINITY, f64::min);
        let least = pairs
            .iter()
            .map(|pair| pair.0)
            .fold(f64::INFINITY, f64::min);
        let most = pairs.iter().map(|pair| pair.0).fold(0.0, f64::max);
        if most > least {
            let x = vec![least, most];
            let y = x.iter().map(|x| 0.7 * factor * x.powf(theory)).collect();
            guides.push((format!("order {theory:.0}"), x, y));
        }
    }
    guides
}
