//! Orders in space, and how the seconds grow with the number of points.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::{Pair, groups};
use crate::output::{LinePlot, LineStyle, Series};
use crate::study::findings::seconds;
use crate::study::{Fit, Measured, Section, Table};

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

/// Exponents of the wall time over the number of points.
pub(super) fn growth(done: &[&Measured]) -> (Table, serde_json::Value) {
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
            .map(|run| (run.points(), run.seconds()))
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

/// Draws the wall time over the number of points.
pub(super) fn draw_growth(section: &mut Section, groups: &BTreeMap<String, Vec<&Measured>>) {
    let columns: Vec<(&String, Vec<f64>, Vec<f64>)> = groups
        .iter()
        .map(|(name, runs)| {
            let (x, y) = runs.iter().map(|run| (run.points(), run.seconds())).unzip();
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
