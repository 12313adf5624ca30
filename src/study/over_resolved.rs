//! Runs so much finer than all others that they stand for an exact solution, and how far to trust them.

use std::collections::BTreeMap;

use super::findings::short;
use super::{Measured, Options, StudyCase, Variant, profile};
use crate::plan::{Plan, TimeMode};

/// Value of a variant that is one of a chain of over-resolved runs: 0 for the coarsest.
const LEVEL: &str = "level";
/// Runs of a chain: each has half the spacing and a quarter of the tolerance of the one before, or half
/// the step.
pub(super) const LEVELS: i32 = 3;
/// By how much errors fall where the step or the spacing is halved, in theory.
pub(super) const SECOND_ORDER: f64 = 4.0;
/// What is believed of a chain of two runs, which cannot tell: theory needs smooth fields.
const FIRST_ORDER: f64 = 2.0;
/// Least fall that is believed: what falls more slowly would make any uncertainty look small.
pub(super) const LEAST_FALL: f64 = 1.5;
/// Errors below so many times the uncertainty are not resolved.
pub(super) const RESOLVED: f64 = 3.0;

/// Distance of the second field from the first, relative to the first.
type Norm = fn(&[f64], &[f64]) -> f64;

/// A run that stands for the exact solution.
#[derive(Debug, Clone)]
pub(super) struct OverResolved<'a> {
    /// The finest of its chain that reached its end.
    pub run: &'a Measured,
    /// Estimate of its own error per field, relative as the distances are; empty if it stands alone.
    pub uncertainty: BTreeMap<String, f64>,
    /// By how much the error falls from run to run of the chain, the least of all fields; `None` if
    /// there were only two.
    pub fall: Option<f64>,
    norm: Norm,
}

impl<'a> OverResolved<'a> {
    /// Judges a chain of runs that reached their end, the finest first; errors of two runs are
    /// `assumed` to fall by a factor.
    ///
    /// Errors C, qC and q²C of the runs make the two coarser ones (q − 1)C and (q² − 1)C distant from
    /// the finest, so that both distances tell q and C (Richardson's rule).
    pub(super) fn of(chain: &[&'a Measured], norm: Norm, assumed: f64) -> Option<Self> {
        let (run, coarser) = chain.split_first()?;
        let alone = OverResolved {
            run,
            uncertainty: BTreeMap::new(),
            fall: None,
            norm,
        };
        let Some(next) = coarser.first() else {
            return Some(alone);
        };
        let far = coarser.get(1).map(|run| alone.distances(run));
        let (mut uncertainty, mut least) = (BTreeMap::new(), None);
        for (field, near) in alone.distances(next) {
            let seen = far.as_ref().and_then(|far| far.get(&field));
            let seen = seen.map(|far| far / near - 1.0).filter(|q| q.is_finite());
            let fall = seen.map_or(assumed, |q| q.clamp(LEAST_FALL, SECOND_ORDER));
            uncertainty.insert(field, near / (fall - 1.0));
            least = [least, seen].into_iter().flatten().reduce(f64::min);
        }
        Some(OverResolved {
            uncertainty,
            fall: least,
            ..alone
        })
    }

    /// The finest run of the chain among these, judged; `None` unless a coarser one verifies it.
    pub(super) fn among(runs: &'a [Measured]) -> Option<Self> {
        let mut chain: Vec<&Measured> = runs
            .iter()
            .filter(|run| is_level(&run.variant) && run.done())
            .collect();
        let level = |run: &Measured| run.variant.value(LEVEL);
        chain.sort_by(|a, b| level(b).total_cmp(&level(a)));
        Self::of(&chain, profile::over_range, FIRST_ORDER).filter(|it| !it.uncertainty.is_empty())
    }

    /// Distance of a run per field, the largest of all outputs; fields it lacks are left out.
    pub(super) fn distances(&self, run: &Measured) -> BTreeMap<String, f64> {
        let own: BTreeMap<&String, &Vec<f64>> = fields(run).collect();
        let mut distances: BTreeMap<String, f64> = BTreeMap::new();
        for (name, exact) in fields(self.run) {
            let Some(own) = own.get(name) else { continue };
            let largest = distances
                .entry(profile::field(name).to_owned())
                .or_insert(f64::NAN);
            *largest = largest.max((self.norm)(own, exact));
        }
        distances
    }

    /// The largest uncertainty of all fields.
    pub(super) fn largest_uncertainty(&self) -> f64 {
        self.uncertainty.values().copied().fold(f64::NAN, f64::max)
    }

    /// Its uncertainties in words; `None` if it stands alone.
    pub(super) fn verdict(&self) -> Option<String> {
        let uncertainties = self.uncertainty.iter();
        let uncertainties: Vec<String> = uncertainties
            .map(|(field, uncertainty)| format!("{field} {}", short(*uncertainty)))
            .collect();
        (!uncertainties.is_empty()).then(|| uncertainties.join(", "))
    }
}

fn fields(run: &Measured) -> impl Iterator<Item = (&String, &Vec<f64>)> {
    let fields = run.first().fields.iter();
    fields.map(|(name, values)| (name, values))
}

/// Whether a variant is one of a chain, which is not measured but measures others.
pub(super) fn is_level(variant: &Variant) -> bool {
    variant.values.contains_key(LEVEL)
}

/// A chain of over-resolved runs beyond the finest run of a study, which has `along` points along its
/// longest side and the tolerance `least`: as fine, twice and four times as fine, the last with an
/// eighth of the tolerance, by the scheme of highest order. Clouds that are no lattices keep their
/// spacing.
///
/// With errors of second order the finest run of the study is fifteen times as wrong as the last of
/// the chain; a run twice as fine as it would not tell its error from its own.
pub(super) fn chain(subject: &StudyCase, along: usize, least: f64) -> Vec<Variant> {
    let methods = subject.methods(&Options::default());
    let best = methods.iter().find(|method| method.order() > 1.5);
    let Some(method) = best.or(methods.first()) else {
        return Vec::new();
    };
    let level = |level: i32| {
        let wish = Options {
            points: vec![along << level],
            ..Options::default()
        };
        let grid = subject.grids(&wish, (0, usize::MAX)).into_iter().next()?;
        let mut variant = method
            .variant(Some("auto"))
            .set(grid.overrides)
            .with("spacing", grid.spacing);
        if subject.plan.time.mode == TimeMode::Transient {
            let tolerance = 2.0 * least * SECOND_ORDER.powi(-level);
            variant = variant
                .set([format!("time.tolerance={tolerance:?}")])
                .with("tolerance", tolerance);
        }
        Some(as_level(variant, level))
    };
    (0..LEVELS).filter_map(level).collect()
}

/// A variant as the run of a chain at `level`, 0 for the coarsest.
pub(super) fn as_level(variant: Variant, level: i32) -> Variant {
    Variant {
        scheme: "over-resolved".to_owned(),
        // Before all others, which are worth nothing without it.
        weight: f64::from(level - LEVELS),
        once: true,
        ..variant
    }
    .with(LEVEL, f64::from(level))
}

/// Places along each line, lines per direction across in the plane and in space.
const PLACES: usize = 24;
const LINES: [usize; 2] = [8, 4];

/// Overrides that record the fields along lines through the whole domain, at the same places on every
/// cloud; `None` where the domain has no known planes.
pub(super) fn lines(plan: &Plan) -> Option<Vec<String>> {
    let (low, high) = plan.geometry.bounds()?;
    let size: Vec<f64> = low.iter().zip(&high).map(|(a, b)| b - a).collect();
    let along = (0..size.len()).max_by(|a, b| size[*a].total_cmp(&size[*b]))?;
    let lines = LINES[size.len() - 2];
    let at = |axis: usize, share: f64| low[axis] + size[axis] * share;
    let middle = |k: usize, of: usize| (k as f64 + 0.5) / of as f64;
    let end = |line: usize, place: usize| {
        let mut rest = line;
        let mut point = Vec::new();
        for axis in 0..size.len() {
            if axis == along {
                point.push(at(axis, middle(place, PLACES)));
            } else {
                point.push(at(axis, middle(rest % lines, lines)));
                rest /= lines;
            }
        }
        point
    };
    let line = |line: usize| {
        format!(
            "output.profiles.{}{line}={{from={:?}, to={:?}, points={PLACES}}}",
            profile::SAMPLE,
            end(line, 0),
            end(line, PLACES - 1)
        )
    };
    Some((0..lines.pow(size.len() as u32 - 1)).map(line).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Row, Status};

    fn run(level: f64, value: f64) -> Measured {
        let mut row = Row::unmeasured(String::new(), 0, Status::Done, String::new());
        row.fields = vec![
            ("pressure at 1".to_owned(), vec![0.0, 1.0 + value]),
            ("pressure at 2".to_owned(), vec![0.0, 1.0]),
        ];
        Measured::new(Variant::default().with(LEVEL, level), vec![row])
    }

    /// Errors of 1e-3, 2e-3 and 4e-3 fall by a half; the finest is then good to what it is wrong by.
    #[test]
    fn the_uncertainty_is_the_error_of_the_finest_run() {
        let runs = [run(0.0, 4e-3), run(1.0, 2e-3), run(2.0, 1e-3)];
        let found = OverResolved::among(&runs).unwrap();
        let error = 1e-3 / 2_f64.sqrt();
        assert!(
            (found.largest_uncertainty() / error - 1.0).abs() < 2e-3,
            "{found:?}"
        );
        assert!((found.fall.unwrap() - 2.0).abs() < 1e-9);
    }

    #[test]
    fn two_runs_are_judged_by_the_order_assumed_and_one_not_at_all() {
        let runs = [run(0.0, 4e-3), run(1.0, 1e-3)];
        let found = OverResolved::among(&runs).unwrap();
        assert!((found.largest_uncertainty() / (3e-3 / 2_f64.sqrt()) - 1.0).abs() < 2e-3);
        assert_eq!(found.fall, None);
        let chain = [&runs[1], &runs[0]];
        let found = OverResolved::of(&chain, profile::over_range, SECOND_ORDER).unwrap();
        assert!((found.largest_uncertainty() / (1e-3 / 2_f64.sqrt()) - 1.0).abs() < 2e-3);
        assert!(OverResolved::among(&runs[..1]).is_none());
    }

    /// What does not fall is not extrapolated to a small uncertainty.
    #[test]
    fn a_chain_that_does_not_converge_is_doubted() {
        let runs = [run(0.0, 1e-3), run(1.0, -1e-3), run(2.0, 1e-3)];
        let found = OverResolved::among(&runs).unwrap();
        assert!(found.largest_uncertainty() > 2e-3, "{found:?}");
    }
}
