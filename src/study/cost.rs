//! What accuracy costs: schemes × solvers × grids × tolerances, error against seconds.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::findings::{seconds, short};
use super::{
    Findings, Fit, Grounds, Measured, Method, Options, Reach, Section, Study, StudyError, Subject,
    Table, Variant, pareto, reach,
};
use crate::output::{LinePlot, LineStyle, Series};
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

fn draw(section: &mut Section, groups: &BTreeMap<String, Vec<&Measured>>) {
    let all: Vec<Pair> = groups.values().flat_map(|runs| pairs(runs)).collect();
    let columns: Vec<(&String, Vec<f64>, Vec<f64>)> = groups
        .iter()
        .map(|(name, runs)| {
            let (x, y) = pairs(runs).into_iter().unzip();
            (name, x, y)
        })
        .collect();
    let (front_x, front_y): (Vec<f64>, Vec<f64>) = pareto(&all).into_iter().map(|i| all[i]).unzip();
    let mut series: Vec<Series<'_>> = columns
        .iter()
        .map(|(name, x, y)| Series {
            label: name,
            x,
            y,
            style: LineStyle::Markers,
        })
        .collect();
    series.push(Series {
        label: "Pareto front",
        x: &front_x,
        y: &front_y,
        style: LineStyle::Dashed,
    });
    section.draw(
        "cost",
        "Down and left is better: less error, fewer seconds. Nothing beats the runs on the dashed front \
         in both.",
        &LinePlot {
            title: "Error against wall time",
            x_label: "wall time [s]",
            y_label: "relative error",
            x_log: true,
            y_log: true,
            series: &series,
            note: None,
        },
    );
}

/// What it costs every method to reach an error.
#[derive(Debug, Clone, serde::Serialize)]
struct CostToReach {
    error: f64,
    cheapest: Option<String>,
    seconds: Option<f64>,
    methods: BTreeMap<String, Option<Reach>>,
}

fn reaching(
    groups: &BTreeMap<String, Vec<&Measured>>,
    done: &[&Measured],
) -> (Table, Vec<CostToReach>) {
    let least = done
        .iter()
        .map(|run| run.error())
        .fold(f64::INFINITY, f64::min);
    let most = done.iter().map(|run| run.error()).fold(0.0, f64::max);
    let decades = (-9..=0)
        .rev()
        .flat_map(|k| [3.0, 1.0].map(|m| m * 10_f64.powi(k)));
    let targets = decades.filter(|error| (0.99 * least..=most).contains(error));
    let costs: Vec<CostToReach> = targets
        .map(|error| {
            let methods: BTreeMap<String, Option<Reach>> = groups
                .iter()
                .map(|(name, runs)| {
                    (
                        name.clone(),
                        reach(&pairs(runs), error).or_else(|| by_theory(runs, error)),
                    )
                })
                .collect();
            let known = methods
                .iter()
                .filter_map(|(name, cost)| Some((name, (*cost)?)));
            let measured = known.filter(|(_, cost)| cost.grounds == Grounds::Measured);
            let best = measured.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
            CostToReach {
                error,
                cheapest: best.map(|(name, _)| name.clone()),
                seconds: best.map(|(_, cost)| cost.cost),
                methods: methods.clone(),
            }
        })
        .collect();
    let mut table = Table::new(
        "Seconds to reach an error, and how many times the cheapest that is. Interpolated between \
         runs; ≈ marks what the power law through a method's own best runs continues beyond them, \
         ≈≈ what the orders of theory do from the only cloud that an explicit scheme could do in time.",
        &["error ≤", "cheapest"],
    );
    table.head.extend(groups.keys().cloned());
    for cost in &costs {
        let mut cells = vec![format!("{:.0e}", cost.error)];
        cells.push(cost.cheapest.clone().unwrap_or_else(|| "–".to_owned()));
        cells.extend(cost.methods.values().map(|reach| match reach {
            None => "not reached".to_owned(),
            Some(reach) => {
                let mark = match reach.grounds {
                    Grounds::Measured => "",
                    Grounds::Extrapolated => "≈ ",
                    Grounds::Theory => "≈≈ ",
                };
                let times = cost.seconds.map(|best| reach.cost / best);
                let times = times.map_or(String::new(), |times| format!(" ({times:.1}×)"));
                format!("{mark}{}{times}", seconds(reach.cost))
            }
        }));
        table.rows.push(cells);
    }
    (table, costs)
}

/// Cost of an explicit scheme beyond its only run: error ∝ Δx², points ∝ Δx^−D, steps ∝ Δx^−2.
fn by_theory(runs: &[&Measured], error: f64) -> Option<Reach> {
    let [run] = runs else { return None };
    let (dimension, own) = (run.number("/dimension"), run.error());
    let near = run.variant.scheme == "explicit" && own > error && own < 100.0 * error;
    near.then(|| Reach {
        cost: run.seconds() * (own / error).powf(0.5 * (dimension + 2.0)),
        grounds: Grounds::Theory,
    })
}

fn headline(cost: &CostToReach) -> Option<String> {
    let (cheapest, best) = (cost.cheapest.as_ref()?, cost.seconds?);
    let explicit = cost.methods.get("explicit").copied().flatten();
    let against = explicit
        .filter(|_| cheapest != "explicit")
        .map_or(String::new(), |reach| {
            let about = match reach.grounds {
                Grounds::Measured => "",
                Grounds::Extrapolated => "about ",
                Grounds::Theory => "by theory about ",
            };
            format!(
                "; explicit: {about}{}, {:.0}×",
                seconds(reach.cost),
                reach.cost / best
            )
        });
    Some(format!(
        "Cheapest for {:.0e}: {cheapest}, {}{against}.",
        cost.error,
        seconds(best)
    ))
}

/// Where the best implicit method begins to cost less than the explicit one.
fn crossover(groups: &BTreeMap<String, Vec<&Measured>>) -> (Option<String>, serde_json::Value) {
    let Some(explicit) = groups.get("explicit").map(|runs| pairs(runs)) else {
        return (None, json!(null));
    };
    let implicit: Vec<Pair> = groups
        .iter()
        .filter(|(name, _)| !name.starts_with("explicit"))
        .flat_map(|(_, runs)| pairs(runs))
        .collect();
    let errors = |pairs: &[Pair]| {
        let errors = pairs.iter().map(|pair| pair.1);
        let least = errors.clone().fold(f64::INFINITY, f64::min);
        (least, errors.fold(0.0, f64::max))
    };
    let ((low_a, high_a), (low_b, high_b)) = (errors(&explicit), errors(&implicit));
    let (low, high) = (low_a.max(low_b), high_a.min(high_b));
    if low.is_nan() || low > high {
        return (None, json!(null));
    }
    // From loose to tight, at fifty errors between the loosest and the tightest both reach.
    let at = |part: f64| high * (low / high).powf(part);
    let ratios: Vec<(f64, f64)> = (0..=50)
        .map(|k| at(f64::from(k) / 50.0))
        .filter_map(|error| {
            let (a, b) = (reach(&explicit, error)?, reach(&implicit, error)?);
            Some((error, a.cost / b.cost))
        })
        .collect();
    let (Some(first), Some(last)) = (ratios.first(), ratios.last()) else {
        return (None, json!(null));
    };
    let wins = ratios.iter().position(|(_, ratio)| *ratio > 1.0);
    let text = match wins {
        Some(0) => format!(
            "Implicit wins over the whole range both reach, from an error of {} ({:.1}×) to {} ({:.1}×).",
            short(first.0),
            first.1,
            short(last.0),
            last.1
        ),
        Some(index) => format!(
            "Implicit starts to win at an error of {}; at {} it is {:.1} times as fast.",
            short(ratios[index].0),
            short(last.0),
            last.1
        ),
        None => format!(
            "Explicit wins over the whole range both reach; at an error of {} implicit takes {:.1} \
             times as long.",
            short(last.0),
            1.0 / last.1
        ),
    };
    let facts = json!({
        "error": wins.map(|index| ratios[index].0),
        "from": { "error": first.0, "explicit_over_implicit": first.1 },
        "to": { "error": last.0, "explicit_over_implicit": last.1 },
    });
    (Some(text), facts)
}

/// Runs of every method at its smallest tolerance, one per grid.
fn finest_in_time<'a>(done: &[&'a Measured]) -> BTreeMap<String, Vec<&'a Measured>> {
    let mut chosen = groups(done);
    for runs in chosen.values_mut() {
        let tolerance = |run: &Measured| run.variant.value("tolerance");
        let least = runs
            .iter()
            .map(|run| tolerance(run))
            .fold(f64::NAN, f64::min);
        runs.retain(|run| least.is_nan() || tolerance(run) <= least);
    }
    chosen
}

fn orders(done: &[&Measured]) -> (Table, serde_json::Value) {
    let mut table = Table::new(
        "Order in space with its 95 % confidence; theory says 2 for horizons that shrink with Δx",
        &["method", "field", "order seen", "theory", "grids"],
    );
    let mut facts = Vec::new();
    for (name, mut runs) in finest_in_time(done) {
        // The coarsest clouds are not yet where the leading term of the error rules.
        runs.sort_by(|a, b| {
            let spacing = |run: &Measured| run.variant.value("spacing");
            spacing(a).total_cmp(&spacing(b))
        });
        runs.truncate(3);
        let fields: BTreeSet<String> = runs
            .iter()
            .flat_map(|run| run.errors().into_keys())
            .collect();
        for field in fields {
            let pairs: Vec<Pair> = runs
                .iter()
                .filter_map(|run| Some((run.variant.value("spacing"), *run.errors().get(&field)?)))
                .collect();
            let Some(fit) = Fit::of(&pairs) else { continue };
            table.rows.push(vec![
                name.clone(),
                field.clone(),
                fit.to_string(),
                "2".to_owned(),
                fit.pairs.to_string(),
            ]);
            facts.push(json!({ "method": name, "field": field, "fit": fit, "theory": 2.0 }));
        }
    }
    (table, json!(facts))
}

fn growth(done: &[&Measured]) -> (Table, serde_json::Value) {
    let mut table = Table::new(
        "How the wall time grows with the number of points n, at the smallest tolerance: seconds ∝ n^exponent",
        &[
            "method",
            "exponent",
            "seconds for 1e5 points by this law",
            "grids",
        ],
    );
    let mut facts = Vec::new();
    for (name, runs) in finest_in_time(done) {
        let pairs: Vec<Pair> = runs
            .iter()
            .map(|run| (run.number("/points"), run.seconds()))
            .collect();
        let Some(fit) = Fit::of(&pairs) else { continue };
        table.rows.push(vec![
            name.clone(),
            fit.to_string(),
            format!("≈ {}", seconds(fit.at(1e5))),
            fit.pairs.to_string(),
        ]);
        facts.push(json!({ "method": name, "fit": fit }));
    }
    (table, json!(facts))
}

fn draw_growth(section: &mut Section, groups: &BTreeMap<String, Vec<&Measured>>) {
    let columns: Vec<(&String, Vec<f64>, Vec<f64>)> = groups
        .iter()
        .map(|(name, runs)| {
            let (x, y) = runs
                .iter()
                .map(|run| (run.number("/points"), run.seconds()))
                .unzip();
            (name, x, y)
        })
        .collect();
    let series: Vec<Series<'_>> = columns
        .iter()
        .map(|(name, x, y)| Series {
            label: name,
            x,
            y,
            style: LineStyle::Markers,
        })
        .collect();
    section.draw(
        "growth",
        "Seconds against the number of points, at every tolerance.",
        &LinePlot {
            title: "Wall time against size",
            x_label: "points",
            y_label: "wall time [s]",
            x_log: true,
            y_log: true,
            series: &series,
            note: None,
        },
    );
}
