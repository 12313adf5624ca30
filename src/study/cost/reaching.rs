//! What it costs to reach an error: the front, the cheapest method, where implicit begins to win.

use std::collections::BTreeMap;

use serde_json::json;

use super::{Pair, pairs};
use crate::output::{LinePlot, LineStyle, Series};
use crate::study::findings::{seconds, short};
use crate::study::{Basis, CostToAccuracy, Measured, Section, Table, pareto, reach};

/// Draws the runs of every method and the front of all.
pub(super) fn draw(section: &mut Section, groups: &BTreeMap<String, Vec<&Measured>>) {
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
pub(super) struct CostToReach {
    error: f64,
    cheapest: Option<String>,
    seconds: Option<f64>,
    methods: BTreeMap<String, Option<CostToAccuracy>>,
}

/// Errors from loose to tight with what they cost every method, as a table and as numbers.
pub(super) fn reaching(
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
            let methods: BTreeMap<String, Option<CostToAccuracy>> = groups
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
            let measured = known.filter(|(_, cost)| cost.grounds == Basis::Measured);
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
                    Basis::Measured => "",
                    Basis::Extrapolated => "≈ ",
                    Basis::Theory => "≈≈ ",
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
fn by_theory(runs: &[&Measured], error: f64) -> Option<CostToAccuracy> {
    let [run] = runs else { return None };
    let (dimension, own) = (run.figure(|run| run.dimension as f64), run.error());
    let other_clouds = run.variant.value("spacing").is_finite();
    let near =
        other_clouds && run.variant.scheme == "explicit" && own > error && own < 100.0 * error;
    near.then(|| CostToAccuracy {
        cost: run.seconds() * (own / error).powf(0.5 * (dimension + 2.0)),
        grounds: Basis::Theory,
    })
}

/// The cheapest method for an error, beside the explicit one.
pub(super) fn headline(cost: &CostToReach) -> Option<String> {
    let (cheapest, best) = (cost.cheapest.as_ref()?, cost.seconds?);
    let explicit = cost.methods.get("explicit").copied().flatten();
    let against = explicit
        .filter(|_| cheapest != "explicit")
        .map_or(String::new(), |reach| {
            let about = match reach.grounds {
                Basis::Measured => "",
                Basis::Extrapolated => "about ",
                Basis::Theory => "by theory about ",
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
pub(super) fn crossover(
    groups: &BTreeMap<String, Vec<&Measured>>,
) -> (Option<String>, serde_json::Value) {
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
        Some(_) if high < 1.1 * low => format!(
            "Implicit is {:.1} times as fast at the one error that both reach, {}.",
            last.1,
            short(last.0)
        ),
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
