//! The numbers of a drawing of curves, which it carries as JSON in its metadata: pages let readers look at them.

use serde_json::{Value, json};

use super::curves::{Shown, drawable};
use super::legend::Look;
use super::units::split_label;
use super::{LinePlot, LineStyle, Series};

/// Most numbers of one series; of more the lowest and highest of every stretch stay.
const MOST: usize = 2000;

/// All series of a plot in the units of its axes.
pub(super) fn numbers(plot: &LinePlot<'_>, looks: &[Look], (x, y): (&Shown, &Shown)) -> String {
    let series = plot.series.iter().zip(looks);
    let series = series.map(|(own, look)| one(plot, own, look, (x.divisor, y.divisor)));
    let axis = |shown: &Shown, log: bool| {
        let (name, unit) = split_label(&shown.label);
        json!({"name": name, "unit": unit, "log": log})
    };
    json!({
        "title": plot.title,
        "x": axis(x, plot.x_log),
        "y": axis(y, plot.y_log),
        "series": series.collect::<Vec<_>>(),
    })
    .to_string()
}

fn one(plot: &LinePlot<'_>, series: &Series<'_>, look: &Look, divisors: (f64, f64)) -> Value {
    let [red, green, blue] = look.colour();
    let pairs: Vec<(f64, f64)> = series
        .x
        .iter()
        .copied()
        .zip(series.y.iter().copied())
        .collect();
    let kept = thinned(&pairs, |(x, y)| drawable(plot, x, y));
    let column = |of: fn(&(f64, f64)) -> f64, divisor: f64| {
        let values = kept.iter().map(|pair| short(of(pair) / divisor));
        values.collect::<Vec<_>>()
    };
    json!({
        "label": series.label,
        "style": match series.style {
            LineStyle::Line => "line",
            LineStyle::Dashed => "dashed",
            LineStyle::Markers => "markers",
            LineStyle::Thin => "thin",
        },
        "group": look.index,
        "mark": look.form(),
        "colour": format!("#{red:02x}{green:02x}{blue:02x}"),
        "of": pairs.len(),
        "x": column(|pair| pair.0, divisors.0),
        "y": column(|pair| pair.1, divisors.1),
    })
}

/// Of a long series the lowest and the highest of every stretch and all gaps, in their order.
fn thinned(pairs: &[(f64, f64)], shows: impl Fn((f64, f64)) -> bool) -> Vec<(f64, f64)> {
    if pairs.len() <= MOST {
        return pairs.to_vec();
    }
    let mut kept = Vec::new();
    for stretch in pairs.chunks(pairs.len().div_ceil(MOST / 2)) {
        let shown = || stretch.iter().enumerate().filter(|(_, pair)| shows(**pair));
        let low = shown().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let high = shown().max_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let gap = stretch.iter().enumerate().find(|(_, pair)| !shows(**pair));
        let mut places: Vec<usize> = [low, high, gap]
            .into_iter()
            .flatten()
            .map(|own| own.0)
            .collect();
        places.sort_unstable();
        places.dedup();
        kept.extend(places.into_iter().map(|place| stretch[place]));
    }
    // The ends of a curve are read off more often than anything between.
    let ends = [pairs.first(), pairs.last()].map(|end| end.copied());
    kept.splice(0..0, ends[0].filter(|end| kept.first() != Some(end)));
    kept.extend(ends[1].filter(|end| kept.last() != Some(end)));
    kept
}

/// Seven digits; nothing for what is no number.
fn short(value: f64) -> Option<f64> {
    let text = format!("{value:.6e}");
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn a_long_series_keeps_its_ends_extremes_and_gaps() {
        let mut pairs: Vec<(f64, f64)> = (0..50_000).map(|k| (f64::from(k), 0.0)).collect();
        (pairs[17].1, pairs[30_001].1, pairs[40_000].1) = (-3.0, 5.0, f64::NAN);
        let kept = thinned(&pairs, |(_, y)| y.is_finite());
        assert!(kept.len() <= 3 * MOST / 2 + 2, "{}", kept.len());
        assert!(kept.contains(&(17.0, -3.0)) && kept.contains(&(30_001.0, 5.0)));
        assert!(kept.iter().any(|(x, y)| *x == 40_000.0 && y.is_nan()));
        assert_eq!((kept[0].0, kept[kept.len() - 1].0), (0.0, 49_999.0));
        assert!(kept.is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn numbers_have_seven_digits_and_gaps_none() {
        assert_eq!(short(1.0 / 3.0), Some(0.333_333_3));
        assert_eq!(short(f64::NAN), None);
        assert_eq!(short(f64::INFINITY), None);
    }
}
