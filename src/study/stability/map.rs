//! The picture of a map.

use super::class::Class;
use super::setting::Setting;
use super::theory::Split;
use crate::output::LinePlot;
use crate::study::chart::{Law, Marks, series};
use crate::study::{Measured, Section};

/// Points of the border of theory.
const BORDER: u32 = 400;

/// Draws the classes of the runs of a scheme that say something of stability, and the border of theory beside them.
pub(super) fn draw(
    section: &mut Section,
    label: &str,
    axis: &str,
    runs: &[&Measured],
    setting: &Setting,
    split: Split,
) {
    let place = |run: &&Measured| (run.variant.value("step_ratio"), run.variant.value(axis));
    let told: Vec<&Measured> = runs
        .iter()
        .copied()
        .filter(|run| Class::of(run).is_told())
        .collect();
    if told.is_empty() {
        return;
    }
    // Classes that do not occur keep their look, so that pictures can be compared.
    let classes = Class::TOLD.map(|class| {
        let own = told.iter().filter(|run| Class::of(run) == class);
        Marks::new(class.name(), own.map(place))
    });
    let border = border(&told.iter().map(place).collect::<Vec<_>>(), setting, split);
    let laws: Vec<Law> = match border.is_empty() {
        true => Vec::new(),
        false => vec![Law::new("theory", border)],
    };
    let file = format!("stability-{}", label.replace(", ", "-").replace(' ', "-"));
    section.draw(
        &file,
        &format!(
            "How runs of the {label} scheme end: {} of {} runs, a mark each.",
            told.len(),
            runs.len()
        ),
        &LinePlot {
            title: label,
            x_label: "step over explicit limit",
            y_label: if axis == "strength" {
                "coupling strength α²/(s M)"
            } else {
                "contrast"
            },
            x_log: true,
            y_log: true,
            series: &series(&classes, &laws),
            note: None,
        },
    );
}

/// The border of theory over the strengths of the runs; nothing where it lies beyond their steps.
fn border(places: &[(f64, f64)], setting: &Setting, split: Split) -> Vec<(f64, f64)> {
    let span = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    };
    let (x_low, x_high) = span(&mut places.iter().map(|place| place.0));
    let (y_low, y_high) = span(&mut places.iter().map(|place| place.1));
    (0..=BORDER)
        .map(|k| y_low * (y_high / y_low).powf(f64::from(k) / f64::from(BORDER)))
        .map(|y| {
            let (from, to) = setting.stable(split, y);
            (if to.is_finite() { to } else { from }, y)
        })
        .filter(|(x, _)| (0.5 * x_low..=2.0 * x_high).contains(x))
        .collect()
}
