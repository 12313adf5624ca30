//! Orders in space, and how the seconds grow with the number of points.

use std::collections::BTreeSet;

use serde_json::json;

use super::{Groups, Pair};
use crate::output::LinePlot;
use crate::study::chart::{Marks, legend, series};
use crate::study::findings::count;
use crate::study::{Fit, Measured, Section, Table};

/// Clouds that an order is fitted over, the finest.
pub(super) const CLOUDS: usize = 3;

/// Runs of every method as it comes at its smallest tolerance, or its smallest step where steps are fixed: one per grid.
fn finest_in_time<'a>(done: &[&'a Measured]) -> Groups<'a> {
    let mut chosen = Groups::new();
    for run in done {
        chosen.entry(run.variant.method()).or_default().push(run);
    }
    for runs in chosen.values_mut() {
        // The first of its settings is what the program takes by itself.
        let setting = runs.first().and_then(|run| run.variant.setting);
        runs.retain(|run| run.variant.setting == setting);
        for bound in ["tolerance", "step"] {
            let own = runs.iter().map(|run| run.variant.value(bound));
            let least = own.fold(f64::NAN, f64::min);
            runs.retain(|run| least.is_nan() || run.variant.value(bound) <= least);
        }
    }
    chosen
}

/// Orders in space of every method and field.
pub(super) fn orders(done: &[&Measured]) -> (Table, serde_json::Value) {
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
        runs.truncate(CLOUDS);
        let fields: BTreeSet<String> = runs
            .iter()
            .flat_map(|run| run.errors().into_keys())
            .collect();
        for field in fields {
            let pairs: Vec<Pair> = runs
                .iter()
                .filter_map(|run| Some((run.variant.value("spacing"), *run.errors().get(&field)?)))
                .collect();
            let Some(fit) = Fit::confident(&pairs) else {
                continue;
            };
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

/// Exponents of the wall time over the number of points, of methods with three clouds at least.
pub(super) fn growth(done: &[&Measured]) -> (Table, serde_json::Value) {
    let mut table = Table::new(
        "How the wall time grows with the number of points n between the clouds run, at the smallest tolerance: \
         seconds ∝ n^exponent",
        &[
            "method",
            "exponent",
            "grids",
            "fewest points",
            "most points",
        ],
    );
    let mut facts = Vec::new();
    for (name, runs) in finest_in_time(done) {
        let pairs: Vec<Pair> = runs
            .iter()
            .map(|run| (run.points(), run.seconds()))
            .collect();
        let Some(fit) = Fit::confident(&pairs) else {
            continue;
        };
        let points = || pairs.iter().map(|pair| pair.0);
        table.rows.push(vec![
            name.clone(),
            fit.to_string(),
            fit.pairs.to_string(),
            count(points().fold(f64::NAN, f64::min)),
            count(points().fold(f64::NAN, f64::max)),
        ]);
        facts.push(json!({ "method": name, "fit": fit }));
    }
    (table, json!(facts))
}

/// Draws the wall time over the number of points.
pub(super) fn draw_growth(section: &mut Section, groups: &Groups<'_>) {
    let mark = |(name, runs): (&String, &Vec<&Measured>)| {
        let pairs = runs.iter().map(|run| (run.points(), run.seconds()));
        Marks::new(name, pairs).ranged(runs, |run, wall| (run.points(), wall))
    };
    let own = groups.iter().filter(|(_, runs)| !runs.is_empty());
    let marks: Vec<Marks> = own.map(mark).collect();
    section.draw(
        "growth",
        &format!(
            "Seconds against the number of points, at every tolerance. {}",
            legend(groups.values().flatten().copied())
        ),
        &LinePlot {
            title: "Wall time against size",
            x_label: "points",
            y_label: "wall time [s]",
            x_log: true,
            y_log: true,
            series: &series(&marks, &[]),
            note: None,
        },
    );
}
