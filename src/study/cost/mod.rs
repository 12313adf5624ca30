//! What accuracy costs: schemes × solvers × grids × tolerances, error against seconds.

mod laws;
mod reaching;

use std::collections::BTreeMap;

use serde_json::json;

use self::laws::{draw_growth, growth, orders};
use self::reaching::{crossover, draw, headline, reaching};
use super::{Findings, Measured, Method, Options, Section, Study, StudyError, Subject, Variant};
use crate::plan::{TimeMode, exact_pressure};

/// The study of cost.
pub struct Cost;

/// A run of the study in a picture: seconds and error.
type Pair = (f64, f64);

impl Study for Cost {
    fn name(&self) -> &'static str {
        "cost"
    }

    fn repetitions(&self) -> u32 {
        3
    }

    fn variants(&self, subject: &Subject, options: &Options) -> Result<Vec<Variant>, StudyError> {
        if subject.plan.reference.is_none() {
            return Err(StudyError::Unsuited {
                study: "the cost study",
                case: subject.plan.case.clone(),
                reason:
                    "it names no exact solution to measure errors with; choose a case whose scene \
                         has a [reference]"
                        .to_owned(),
            });
        }
        let coupled = subject.is_coupled();
        let range = match (coupled, options.quick) {
            (true, false) => (60, 6000),
            (true, true) => (60, 400),
            (false, false) => (100, 40_000),
            (false, true) => (100, 2500),
        };
        let tolerances: &[f64] = match options.quick {
            true => &[1e-2, 1e-3],
            false => &[1e-2, 1e-3, 1e-4],
        };
        let mut variants = Vec::new();
        for grid in subject.grids(options, range) {
            for method in subject.methods(options) {
                let solvers = subject.solvers(method.scheme, options);
                let main = method.integrator == Some("tr-bdf2") && method.scheme != "semi-implicit";
                let solvers = if main { &solvers[..] } else { &solvers[..1] };
                let adaptive =
                    method.integrator.is_some() && subject.plan.time.mode == TimeMode::Transient;
                let tolerances = if adaptive { tolerances } else { &[f64::NAN] };
                for (solver, &tolerance) in solvers
                    .iter()
                    .flat_map(|s| tolerances.iter().map(move |t| (s, t)))
                {
                    let mut variant = method
                        .variant(Some(solver))
                        .set(grid.overrides.clone())
                        .with("spacing", grid.spacing);
                    if adaptive {
                        variant = variant
                            .set([format!("time.tolerance={tolerance:?}")])
                            .with("tolerance", tolerance);
                    }
                    variant.weight = weight(method.scheme, grid.points, tolerance);
                    variants.push(variant);
                }
            }
        }
        if steady_only(subject) && options.wants_scheme("implicit") {
            variants.extend(steady(subject, options, range));
        }
        Ok(variants)
    }

    fn findings(&self, subject: &Subject, runs: &[Measured]) -> Findings {
        let done: Vec<&Measured> = runs
            .iter()
            .filter(|run| run.done() && run.error().is_finite() && run.error() > 0.0)
            .collect();
        let groups = groups(&done);
        let (reaching, costs) = reaching(&groups, &done);
        let (crossing, crossover) = crossover(&groups);
        let (orders, order_facts) = orders(&done);
        let (growth, growth_facts) = growth(&done);
        let mut headlines: Vec<String> = costs.iter().filter_map(headline).collect();
        headlines.extend(crossing.clone());
        let mut section = Section::new("Error against seconds");
        section.text.push(format!(
            "Each mark is a run of {} on one grid with one tolerance: the median wall time of the whole \
             process, with its start, its output and its pictures, against the largest root mean square \
             error of all fields and outputs, relative to the range of the exact field. Runs of all kinds \
             took turns, so that a disturbance of the machine meets all of them.",
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
        Findings {
            facts: json!({
                "cost_to_reach": costs,
                "crossover": crossover,
                "orders": order_facts,
                "growth": growth_facts,
            }),
            headlines,
            sections: vec![section, laws],
        }
    }
}

/// Whether errors exist in the steady state only.
fn steady_only(subject: &Subject) -> bool {
    let exact = exact_pressure(&subject.plan).ok().flatten();
    exact.is_some_and(|exact| exact.steady_only())
}

/// The steady state in one solve, by every solver on every cloud.
fn steady(subject: &Subject, options: &Options, range: (usize, usize)) -> Vec<Variant> {
    let method = Method {
        scheme: "implicit",
        integrator: None,
    };
    let solvers = subject.solvers(method.scheme, options);
    let grids = subject.grids(options, range);
    let pairs = grids
        .iter()
        .flat_map(|grid| solvers.iter().map(move |solver| (grid, solver)));
    pairs
        .map(|(grid, solver)| {
            let mut variant = method
                .variant(Some(solver))
                .set(grid.overrides.clone())
                .set(["time.mode=\"steady\"".to_owned()])
                .with("spacing", grid.spacing);
            variant.scheme = "steady".to_owned();
            variant.weight = grid.points as f64;
            variant
        })
        .collect()
}

/// Cheap first: points, tighter tolerances, and the many steps of methods without a linear system.
fn weight(scheme: &str, points: usize, tolerance: f64) -> f64 {
    let points = points as f64;
    let steps = match tolerance.is_finite() {
        true => (1e-2 / tolerance).powf(0.3),
        false => 1.0,
    };
    match scheme {
        "explicit" => points * points,
        "semi-implicit" => 30.0 * points * steps,
        _ => 10.0 * points * steps,
    }
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
