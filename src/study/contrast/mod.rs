//! What a contrast of permeability costs and what it does to the flux: 1e-12 … 1e12 × schemes × solvers × flow
//! operators.

mod cost;
mod exact;
mod flux;
mod rock;

use std::collections::BTreeMap;

use serde_json::json;

use super::chart::{Marks, series};
use super::variant::Method;
use super::{Measured, Options, ReportContent, Section, Study, StudyCase, StudyError, Variant};
use crate::output::LinePlot;
use crate::plan::TimeMode;
use rock::Varied;

/// The study of contrast.
pub(super) struct Contrast;

const OPERATORS: [&str; 3] = ["path", "bond", "correspondence"];

/// Decades of the contrast, of all methods and, where the varied rock is the worse one, of the steady flux alone;
/// then those of quick studies.
const DECADES: [&[i32]; 2] = [
    &[0, 1, 2, 3, 4, 6, 8, 10, 12],
    &[-12, -10, -8, -6, -4, -3, -2, -1],
];
const QUICK: [&[i32]; 2] = [&[0, 2, 4, 8, 12], &[-12, -8, -4, -2]];

/// Error that has no place in a picture with errors of discretisation.
const VANISHING: f64 = 1e-9;

fn visible(error: f64) -> f64 {
    if error > VANISHING { error } else { f64::NAN }
}

/// Runs that differ in the contrast alone, by it.
type Group<'a> = Vec<&'a Measured>;

/// Steady runs with the operator of a variant.
const STEADY: &str = "steady";

impl Study for Contrast {
    fn name(&self) -> &'static str {
        "contrast"
    }

    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        let varied = Varied::of(subject)?;
        let [better, worse] = if options.quick { QUICK } else { DECADES };
        let mut solvers = subject.solvers("implicit", options);
        if options.solvers.is_empty() {
            solvers.push("faer-cg:preconditioner=jacobi".to_owned());
        }
        let mut variants = Vec::new();
        for (method, mode) in methods(subject, options) {
            let none = ["-".to_owned()];
            let solvers = match method.scheme {
                "explicit" => &none[..],
                _ => &solvers[..],
            };
            let one = |operator, solver: &String, decade: &i32| {
                variant(&varied, (method, mode), operator, solver, *decade)
            };
            for operator in OPERATORS {
                for solver in solvers {
                    variants.extend(better.iter().map(|decade| one(operator, solver, decade)));
                }
                if mode == STEADY {
                    variants.extend(
                        worse
                            .iter()
                            .map(|decade| one(operator, &solvers[0], decade)),
                    );
                }
            }
        }
        Ok(variants)
    }

    fn findings(&self, subject: &StudyCase, runs: &[Measured]) -> ReportContent {
        let groups = groups(runs);
        let laws = cost::laws(&groups, subject.plan.time.end);
        let flux = flux::section(subject, &groups);
        let mut headlines = flux.headlines;
        headlines.extend(cost::headlines(&groups, &laws));
        let mut sections = vec![flux.section];
        sections.push(cost::section(&groups, &laws));
        sections.extend(fields(&groups));
        ReportContent {
            facts: json!({ "flux": flux.rows, "laws": laws, "headlines": headlines }),
            headlines,
            sections,
        }
    }
}

/// Methods of a study; a case that is steady itself has no history to step through.
fn methods(subject: &StudyCase, options: &Options) -> Vec<(Method, &'static str)> {
    let method = Method::new;
    let all = [
        (method("implicit", Some("tr-bdf2")), "transient"),
        (method("implicit", None), STEADY),
        (method("explicit", None), "transient"),
    ];
    let steady = subject.plan.time.mode == TimeMode::Steady;
    let wanted = |(method, mode): &(Method, &str)| {
        options.wants_scheme(method.scheme) && (!steady || *mode == STEADY)
    };
    all.into_iter().filter(wanted).collect()
}

fn variant(
    varied: &Varied,
    (method, mode): (Method, &str),
    operator: &str,
    solver: &str,
    decade: i32,
) -> Variant {
    let contrast = 10_f64.powi(decade);
    let mut variant = method
        .variant(Some(solver))
        .set([
            format!("time.mode=\"{mode}\""),
            format!("flow.operator=\"{operator}\""),
            varied.override_for(contrast),
        ])
        .with("contrast", contrast);
    if mode == STEADY {
        variant.scheme = STEADY.to_owned();
    }
    variant.operator = Some(operator.to_owned());
    let far = 1.0 + 0.01 * f64::from(decade.abs());
    variant.weight = match (method.scheme, mode) {
        // One solution each, which tells the flux: first whatever the budget, seconds of other runs later.
        (_, STEADY) => 1e-6 * far,
        // What an explicit run takes to a contrast of 1e4 is worth knowing early.
        ("explicit", _) => 1e-4 * contrast,
        _ => far,
    };
    // The seconds of these are not told.
    variant.once = decade < 0;
    variant
}

/// Runs by their method, sorted by contrast.
fn groups(runs: &[Measured]) -> BTreeMap<String, Group<'_>> {
    let mut groups: BTreeMap<String, Group<'_>> = BTreeMap::new();
    for run in runs {
        groups.entry(run.variant.method()).or_default().push(run);
    }
    let contrast = |run: &Measured| run.variant.value("contrast");
    for runs in groups.values_mut() {
        runs.sort_by(|a, b| contrast(a).total_cmp(&contrast(b)));
    }
    groups
}

/// Those of a group whose seconds, steps and iterations are told: contrasts from 1.
fn told<'a>(runs: &[&'a Measured]) -> Group<'a> {
    let from_one = runs.iter().filter(|run| !run.variant.once);
    from_one.copied().collect()
}

/// Errors of the pressure where there is an exact solution, iterations and steps.
fn fields(groups: &BTreeMap<String, Group<'_>>) -> Vec<Section> {
    let mut errors = Section::new("Error of the pressure against contrast");
    let mut effort = Section::new("Iterations and steps");
    let pressure: fn(&Measured) -> f64 =
        |run| visible(run.errors().get("pressure").copied().unwrap_or(f64::NAN));
    let iterations: fn(&Measured) -> f64 =
        |run| run.solver(|done| done.iterations) / run.solver(|done| done.solves);
    let steps: fn(&Measured) -> f64 = Measured::steps;
    for operator in OPERATORS {
        let own: BTreeMap<String, Group<'_>> = of_operator(groups, operator)
            .map(|(name, runs)| (name.clone(), told(runs)))
            .collect();
        let title = |what: &str| format!("{what}, {operator} operator");
        let drawn = |section: &mut Section, file: &str, (what, label), measure| {
            let file = format!("contrast-{file}-{operator}");
            draw(section, &file, &title(what), label, &own, measure);
        };
        let names = ("Error of the pressure", "relative error");
        drawn(&mut errors, "pressure", names, pressure);
        let names = ("Krylov iterations per solve", "iterations");
        drawn(&mut effort, "iterations", names, iterations);
        drawn(&mut effort, "steps", ("Steps", "steps"), steps);
    }
    if !errors.figures.is_empty() {
        errors.text.push(format!(
            "Errors below {VANISHING:.0e} are left out of the pictures."
        ));
    }
    let drawn = |section: &Section| !section.figures.is_empty();
    [errors, effort].into_iter().filter(drawn).collect()
}

fn of_operator<'a, 'b>(
    groups: &'b BTreeMap<String, Group<'a>>,
    operator: &'b str,
) -> impl Iterator<Item = (&'b String, &'b Group<'a>)> {
    groups
        .iter()
        .filter(move |(name, _)| name.ends_with(operator))
}

/// The curve of a measure over the contrast, where it is above zero; `None` if it is nowhere.
fn curve(name: &str, runs: &[&Measured], measure: impl Fn(&Measured) -> f64) -> Option<Marks> {
    let pairs = runs
        .iter()
        .map(|run| (run.variant.value("contrast"), measure(run)));
    let pairs: Vec<(f64, f64)> = pairs.filter(|pair| pair.1 > 0.0).collect();
    (!pairs.is_empty()).then(|| Marks::joined(name, pairs))
}

fn draw(
    section: &mut Section,
    file: &str,
    title: &str,
    y_label: &str,
    groups: &BTreeMap<String, Group<'_>>,
    measure: impl Fn(&Measured) -> f64,
) {
    let curves = groups.iter();
    let curves: Vec<Marks> = curves
        .filter_map(|(name, runs)| curve(name, runs, &measure))
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
            series: &series(&curves, &[]),
            note: None,
        },
    );
}
