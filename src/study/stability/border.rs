//! The border of stability at every strength: by theory, and as found.

use std::collections::BTreeMap;

use super::CELL;
use super::class::Class;
use super::setting::Setting;
use super::theory::Split;
use crate::study::Measured;

/// The border at one strength; steps in units of the explicit limit.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Border {
    strength: f64,
    /// Smallest and largest stable step by theory: 0 and infinite (null) if every step is stable, both
    /// 0 if none is.
    theory: (f64, f64),
    /// Smallest and largest step found stable.
    stable: Option<(f64, f64)>,
    /// Smallest and largest step found unstable.
    unstable: Option<(f64, f64)>,
    /// How far the worst run is on the wrong side of theory, in cells.
    pub cells_apart: f64,
}

impl Border {
    /// As a row of the table.
    pub(super) fn cells(&self, label: &str) -> Vec<String> {
        let span = |span: Option<(f64, f64)>| {
            span.map_or("none".to_owned(), |(from, to)| {
                format!("{from:.3} … {to:.3}")
            })
        };
        let theory = match self.theory {
            (_, to) if to <= 0.0 => "no step is stable".to_owned(),
            (from, to) if to.is_finite() => format!("stable from {from:.3} to {to:.3}"),
            (from, _) if from > 0.0 => format!("stable from {from:.3}"),
            _ => "every step is stable".to_owned(),
        };
        vec![
            label.to_owned(),
            format!("{:.3}", self.strength),
            theory,
            span(self.stable),
            span(self.unstable),
            format!("{:.0}", self.cells_apart),
        ]
    }
}

/// How many cells lie between a step and the nearer end of the stable ones that is one; along a row
/// without an end the border is at a strength of one.
fn cells_between(ratio: f64, (from, to): (f64, f64), strength: f64) -> f64 {
    let ends = [from, to].into_iter();
    let ends = ends.filter(|end| *end > 0.0 && end.is_finite());
    let nearest = ends.map(|end| (ratio / end).ln().abs()).reduce(f64::min);
    (nearest.unwrap_or(strength.ln().abs()) / CELL.ln()).ceil()
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
            let expected = |ratio: f64| (theory.0..=theory.1).contains(&ratio);
            let wrong = row
                .iter()
                .filter(|(ratio, _, stable)| expected(*ratio) != *stable);
            let apart = wrong.map(|(ratio, ..)| cells_between(*ratio, theory, strength));
            let span = |wanted: bool| {
                let own = row.iter().filter(|cell| cell.2 == wanted);
                let ratios: Vec<f64> = own.map(|cell| cell.0).collect();
                Some((*ratios.first()?, *ratios.last()?))
            };
            Border {
                strength,
                theory,
                cells_apart: apart.fold(0.0, f64::max),
                stable: span(true),
                unstable: span(false),
            }
        })
        .collect()
}
