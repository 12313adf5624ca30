//! The picture of a map.

use super::class::Class;
use super::setting::Setting;
use super::theory::Split;
use crate::output::{LinePlot, LineStyle, Series};
use crate::study::{Measured, Section};

/// Draws the classes of the runs of a scheme and the border of theory.
pub(super) fn draw(
    section: &mut Section,
    label: &str,
    axis: &str,
    runs: &[&Measured],
    setting: &Setting,
    split: Split,
) {
    let columns: Vec<(&str, Vec<f64>, Vec<f64>)> = Class::ALL
        .iter()
        .map(|class| {
            let own = runs.iter().filter(|run| Class::of(run) == *class);
            let places = own.map(|run| (run.variant.value("step_ratio"), run.variant.value(axis)));
            let (x, y) = places.unzip();
            (class.name(), x, y)
        })
        .collect();
    let all = || {
        runs.iter()
            .map(|run| (run.variant.value("step_ratio"), run.variant.value(axis)))
    };
    let span = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    };
    let (x_low, x_high) = span(&mut all().map(|place| place.0));
    let (y_low, y_high) = span(&mut all().map(|place| place.1));
    // Nothing is drawn where the border lies beyond the runs.
    let (x, y): (Vec<f64>, Vec<f64>) = (0..=400)
        .map(|k| y_low * (y_high / y_low).powf(f64::from(k) / 400.0))
        .map(|y| {
            let (from, to) = setting.stable(split, y);
            (if to.is_finite() { to } else { from }, y)
        })
        .filter(|(x, _)| (0.5 * x_low..=2.0 * x_high).contains(x))
        .unzip();
    let mut series: Vec<Series<'_>> = columns
        .iter()
        // Classes that do not occur keep their look, so that pictures can be compared.
        .map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Markers,
        })
        .collect();
    if !x.is_empty() {
        series.push(Series {
            label: "theory",
            x: &x,
            y: &y,
            style: LineStyle::Dashed,
        });
    }
    let file = format!("stability-{}", label.replace(", ", "-").replace(' ', "-"));
    section.draw(
        &file,
        &format!("How runs of the {label} scheme end."),
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
            series: &series,
            note: None,
        },
    );
}
