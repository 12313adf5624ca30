//! Curves of pictures: what was measured has a mark per run, laws and theory are dashed and have none.

use super::Measured;
use crate::output::{LineStyle, Series};

/// What was measured of one method: a mark per run, a thin line, and bars over the range of repetitions.
#[derive(Debug, Clone, Default)]
pub(super) struct Marks {
    label: String,
    marks: Coordinates,
    line: Coordinates,
    bars: Coordinates,
}

/// A law or a border of theory over the range where it holds.
#[derive(Debug, Clone)]
pub(super) struct Law {
    label: String,
    line: Coordinates,
}

type Coordinates = (Vec<f64>, Vec<f64>);

/// Gap of a curve.
const GAP: (f64, f64) = (f64::NAN, f64::NAN);

impl Marks {
    /// Marks at the pairs, without a line.
    pub(super) fn new(label: &str, pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Marks {
            label: label.to_owned(),
            marks: pairs.into_iter().unzip(),
            ..Marks::default()
        }
    }

    /// Marks at the pairs, which a line joins in their order.
    pub(super) fn joined(label: &str, pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let own = Marks::new(label, pairs);
        Marks {
            line: own.marks.clone(),
            ..own
        }
    }

    /// Joins these pairs instead.
    pub(super) fn through(self, pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Marks {
            line: pairs.into_iter().unzip(),
            ..self
        }
    }

    /// Bars from the least to the most seconds of runs that were repeated; `place` puts seconds of a run on the plot.
    pub(super) fn ranged(
        self,
        runs: &[&Measured],
        place: impl Fn(&Measured, f64) -> (f64, f64),
    ) -> Self {
        let bar = |run: &&Measured| {
            let (least, most) = run.range()?;
            Some([place(run, least), place(run, most), GAP])
        };
        Marks {
            bars: runs.iter().filter_map(bar).flatten().unzip(),
            ..self
        }
    }
}

impl Law {
    /// A dashed curve through the pairs.
    pub(super) fn new(label: &str, pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Law {
            label: label.to_owned(),
            line: pairs.into_iter().unzip(),
        }
    }
}

/// What the marks of [`Marks::ranged`] are, for captions.
pub(super) fn legend<'a>(runs: impl IntoIterator<Item = &'a Measured>) -> &'static str {
    let mut runs = runs.into_iter();
    match runs.any(|run| run.range().is_some()) {
        true => "A mark per run, with a bar over the range of its repetitions.",
        false => "A mark per run.",
    }
}

/// All curves of a picture.
pub(super) fn series<'a>(marks: &'a [Marks], laws: &'a [Law]) -> Vec<Series<'a>> {
    let one = |label, (x, y): &'a Coordinates, style| Series { label, x, y, style };
    let measured = marks.iter().flat_map(|own| {
        [
            one(&own.label, &own.marks, LineStyle::Markers),
            one("", &own.line, LineStyle::Thin),
            one("", &own.bars, LineStyle::Thin),
        ]
    });
    let laws = laws
        .iter()
        .map(|law| one(&law.label, &law.line, LineStyle::Dashed));
    measured.chain(laws).collect()
}
