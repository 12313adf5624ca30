//! The border of stability at every strength: by theory, and as found.

use std::collections::BTreeMap;

use super::CELL;
use super::class::Class;
use super::setting::Setting;
use super::theory::Split;
use crate::study::Measured;

/// The border at one strength.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Border {
    strength: f64,
    /// Infinite (null) if every step is stable.
    theory: f64,
    stable_to: Option<f64>,
    unstable_from: Option<f64>,
    /// How far the worst run is on the wrong side of theory, in cells.
    pub cells_apart: f64,
}

impl Border {
    /// As a row of the table.
    pub fn cells(&self, label: &str) -> Vec<String> {
        let number = |value: Option<f64>| value.map_or("none".to_owned(), |v| format!("{v:.2}"));
        let theory = match self.theory {
            to if to.is_infinite() => "every step is stable".to_owned(),
            to if to <= 0.0 => "no step is stable".to_owned(),
            to => format!("stable to {to:.3}"),
        };
        vec![
            label.to_owned(),
            format!("{:.3}", self.strength),
            theory,
            number(self.stable_to),
            number(self.unstable_from),
            format!("{:.1}", self.cells_apart),
        ]
    }
}

/// One border per strength.
pub(super) fn borders(
    runs: &[&Measured],
    axis: &str,
    setting: &Setting,
    split: Split,
) -> Vec<Border> {
    let mut rows: BTreeMap<u64, Vec<(f64, f64, bool)>> = BTreeMap::new();
    let ended = |run: &&&Measured| Class::of(run) != Class::Unfinished;
    for run in runs.iter().filter(ended) {
        let (ratio, strength) = (run.variant.value("step_ratio"), run.variant.value(axis));
        let stable = Class::of(run).is_stable();
        rows.entry(strength.to_bits())
            .or_default()
            .push((ratio, strength, stable));
    }
    rows.into_values()
        .map(|mut row| {
            row.sort_by(|a, b| a.0.total_cmp(&b.0));
            let strength = row[0].1;
            let theory = setting.stable(split, strength);
            // Runs that theory puts on the other side; how far from the border, in cells.
            let wrong = row
                .iter()
                .filter(|(ratio, _, stable)| (*ratio <= theory) != *stable);
            let apart = wrong.map(|(ratio, ..)| match theory > 0.0 && theory.is_finite() {
                true => ((ratio / theory).ln().abs() / CELL.ln()).ceil(),
                // The border runs along this row: it is a strength of one away.
                false => (strength.ln().abs() / CELL.ln()).ceil(),
            });
            Border {
                strength,
                theory,
                cells_apart: apart.fold(0.0, f64::max),
                stable_to: row
                    .iter()
                    .filter(|cell| cell.2)
                    .map(|cell| cell.0)
                    .reduce(f64::max),
                unstable_from: row.iter().find(|cell| !cell.2).map(|cell| cell.0),
            }
        })
        .collect()
}
