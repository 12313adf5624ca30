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
    /// Runs planned.
    planned: usize,
    /// Runs that ended, stable and unstable.
    ended: [usize; 2],
    /// Smallest and largest step found stable.
    stable: Option<(f64, f64)>,
    /// Smallest and largest step found unstable.
    unstable: Option<(f64, f64)>,
    /// Steps a cell apart of which one is stable and one is not; `None` if no border was found.
    found: Option<(f64, f64)>,
    /// How far the worst run is on the wrong side of theory, in cells; `None` if all are on the right side and no
    /// border was found.
    cells_apart: Option<f64>,
}

/// Most cells between neighbours, with room for rounding.
const NEAR: f64 = 1.01;

/// A planned step: over the explicit limit, and whether it is stable if its run ended.
type Cell = (f64, Option<bool>);

impl Border {
    /// From all steps planned at a strength.
    fn new(mut row: Vec<Cell>, strength: f64, theory: (f64, f64)) -> Self {
        row.sort_by(|a, b| a.0.total_cmp(&b.0));
        let span = |wanted: bool| {
            let own = row.iter().filter(|cell| cell.1 == Some(wanted));
            let ratios: Vec<f64> = own.map(|cell| cell.0).collect();
            Some((*ratios.first()?, *ratios.last()?))
        };
        let count = |wanted| row.iter().filter(|cell| cell.1 == Some(wanted)).count();
        let differ = |pair: &&[Cell]| {
            let near = pair[1].0 < NEAR * CELL * pair[0].0;
            near && matches!((pair[0].1, pair[1].1), (Some(a), Some(b)) if a != b)
        };
        let found = row
            .windows(2)
            .find(differ)
            .map(|pair| (pair[0].0, pair[1].0));
        let expected = |ratio: f64| (theory.0..=theory.1).contains(&ratio);
        let wrong = row
            .iter()
            .filter(|(ratio, stable)| stable.is_some_and(|stable| stable != expected(*ratio)))
            .map(|(ratio, _)| cells_between(*ratio, theory, strength))
            .reduce(f64::max);
        Border {
            strength,
            theory,
            planned: row.len(),
            ended: [count(true), count(false)],
            stable: span(true),
            unstable: span(false),
            found,
            cells_apart: wrong.or(found.map(|_| 0.0)),
        }
    }

    /// As a row of the table.
    pub(super) fn cells(&self, label: &str) -> Vec<String> {
        // What was not run may be of either kind.
        let none = if self.is_complete() { "none" } else { "–" };
        let span = |span: Option<(f64, f64)>| {
            span.map_or(none.to_owned(), |(from, to)| format!("{from:.3} … {to:.3}"))
        };
        let theory = match self.theory {
            (_, to) if to <= 0.0 => "no step is stable".to_owned(),
            (from, to) if to.is_finite() => format!("stable from {from:.3} to {to:.3}"),
            (from, _) if from > 0.0 => format!("stable from {from:.3}"),
            _ => "every step is stable".to_owned(),
        };
        let [stable, unstable] = self.ended;
        vec![
            label.to_owned(),
            format!("{:.3}", self.strength),
            theory,
            format!("{} of {}", stable + unstable, self.planned),
            span(self.stable),
            span(self.unstable),
            self.found.map_or("not found".to_owned(), |(one, other)| {
                format!("between {one:.3} and {other:.3}")
            }),
            self.cells_apart
                .map_or("–".to_owned(), |apart| format!("{apart:.0}")),
        ]
    }

    fn is_complete(&self) -> bool {
        self.ended.iter().sum::<usize>() == self.planned
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
    let mut rows: BTreeMap<u64, Vec<Cell>> = BTreeMap::new();
    for run in runs {
        let class = Class::of(run);
        let stable = class.is_told().then_some(class.is_stable());
        rows.entry(run.variant.value(axis).to_bits())
            .or_default()
            .push((run.variant.value("step_ratio"), stable));
    }
    let border = |(bits, row): (u64, Vec<Cell>)| {
        let strength = f64::from_bits(bits);
        Border::new(row, strength, setting.stable(split, strength))
    };
    rows.into_iter().map(border).collect()
}

/// What the runs of a method say of the border of stability, in one sentence.
pub(super) fn headline(label: &str, axis: &str, borders: &[Border]) -> String {
    let of = borders.len();
    let planned: usize = borders.iter().map(|border| border.planned).sum();
    let ended = |which: usize| -> usize { borders.iter().map(|border| border.ended[which]).sum() };
    let (stable, unstable) = (ended(0), ended(1));
    let ends = match stable + unstable {
        0 => format!("none of {planned} runs ended"),
        all => format!("{all} of {planned} runs ended, {stable} stable and {unstable} unstable"),
    };
    let (found, others): (Vec<&Border>, Vec<&Border>) =
        borders.iter().partition(|border| border.found.is_some());
    let whole = others.iter().filter(|border| border.is_complete());
    let (steady, shaky): (Vec<&Border>, Vec<&Border>) =
        whole.copied().partition(|border| border.unstable.is_none());
    let mut parts = Vec::new();
    if !found.is_empty() {
        parts.push(format!(
            "border of stability found at {} of {of} values of the {axis}, {}",
            found.len(),
            distance(&found)
        ));
    }
    for (rows, what) in [(steady, "stable"), (shaky, "unstable")] {
        if !rows.is_empty() {
            let against = rows.iter().any(|border| border.cells_apart.is_some());
            let against = if against { ", against theory" } else { "" };
            parts.push(format!(
                "{what} at every step run at {} of {of} values of the {axis}{against}",
                rows.len()
            ));
        }
    }
    if parts.is_empty() {
        parts.push("no border of stability found".to_owned());
    }
    if !borders.iter().all(Border::is_complete) || of == 0 {
        parts.push(ends);
    }
    format!("{label}: {}.", parts.join("; "))
}

/// How far the borders found are from those of theory.
fn distance(found: &[&Border]) -> String {
    let apart = found.iter().filter_map(|border| border.cells_apart);
    match apart.fold(0.0, f64::max) {
        worst if worst < 0.5 => "in the very grid cell of theory's".to_owned(),
        worst if worst < 1.5 => "within one grid cell of theory's".to_owned(),
        worst => format!("within {worst:.0} grid cells of theory's"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STABLE: Option<bool> = Some(true);
    const UNSTABLE: Option<bool> = Some(false);

    /// Steps a cell apart, with theory's border at 1 between the second and the third.
    fn border(ended: [Option<bool>; 4]) -> Border {
        let cell = |(k, stable): (i32, Option<bool>)| (0.75 * CELL.powi(k - 1), stable);
        let row = (0..).zip(ended).map(cell).collect();
        Border::new(row, 3.0, (0.0, 1.0))
    }

    fn line(ended: [Option<bool>; 4]) -> String {
        headline("explicit", "strength", &[border(ended)])
    }

    #[test]
    fn a_border_is_found_between_neighbours_that_differ_and_nowhere_else() {
        let whole = border([STABLE, STABLE, UNSTABLE, UNSTABLE]);
        let (below, above) = whole.found.unwrap();
        assert!(below < 1.0 && above > 1.0 && (above / below - CELL).abs() < 1e-9);
        assert_eq!(whole.cells_apart, Some(0.0));
        for ended in [
            [None; 4],
            [STABLE, None, None, None],
            [STABLE, STABLE, None, None],
            [None, None, UNSTABLE, UNSTABLE],
            // The border is somewhere in a gap of two cells, or three.
            [STABLE, None, UNSTABLE, UNSTABLE],
            [STABLE, None, None, UNSTABLE],
        ] {
            let border = border(ended);
            assert_eq!(
                (border.found, border.cells_apart),
                (None, None),
                "{ended:?}"
            );
            let cells = border.cells("explicit");
            assert_eq!(cells[6..], ["not found", "–"], "{ended:?}");
        }
    }

    /// Maps leave out steps far from where theory has borders.
    #[test]
    fn steps_that_the_map_leaves_out_hide_a_border() {
        let far = Border::new(vec![(0.4, STABLE), (200.0, UNSTABLE)], 3.0, (0.0, 1.0));
        assert_eq!((far.found, far.cells_apart), (None, None));
    }

    #[test]
    fn runs_on_the_wrong_side_of_theory_are_told_whether_or_not_a_border_was_found() {
        let late = border([STABLE, STABLE, STABLE, UNSTABLE]);
        assert_eq!(late.cells_apart, Some(1.0));
        assert_eq!(border([STABLE; 4]).cells_apart, Some(2.0));
        assert!(line([STABLE; 4]).ends_with("values of the strength, against theory."));
    }

    #[test]
    fn headlines_claim_what_ended_and_no_more() {
        assert_eq!(
            headline("explicit", "strength", &[]),
            "explicit: no border of stability found; none of 0 runs ended."
        );
        assert_eq!(
            line([STABLE, None, None, None]),
            "explicit: no border of stability found; 1 of 4 runs ended, 1 stable and 0 unstable."
        );
        assert_eq!(
            line([STABLE, STABLE, UNSTABLE, UNSTABLE]),
            "explicit: border of stability found at 1 of 1 values of the strength, in the very grid cell of \
             theory's."
        );
        assert_eq!(
            line([STABLE, STABLE, UNSTABLE, None]),
            "explicit: border of stability found at 1 of 1 values of the strength, in the very grid cell of \
             theory's; 3 of 4 runs ended, 2 stable and 1 unstable."
        );
    }

    /// Where theory has no border, runs that are all stable find none and agree with it.
    #[test]
    fn a_method_that_is_always_stable_has_no_border_to_be_apart_from() {
        let row = vec![(0.5, STABLE), (1.0, STABLE)];
        let always = Border::new(row, 3.0, (0.0, f64::INFINITY));
        assert_eq!((always.found, always.cells_apart), (None, None));
        assert_eq!(
            headline("monolithic", "strength", &[always]),
            "monolithic: stable at every step run at 1 of 1 values of the strength."
        );
    }
}
