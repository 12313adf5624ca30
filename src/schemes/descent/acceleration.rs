//! Anderson's method for passes whose coefficients lag behind the displacement.

use perifrac_solvers::{dot, norm2};

use crate::plan::DescentSettings;
use crate::schemes::accelerator::smallest;

/// Displacements from which passes started, m, and how far they went; the newest last.
pub(crate) struct AndersonAcceleration {
    settings: DescentSettings,
    /// Passes that are remembered.
    pub depth: usize,
    past: Vec<(Vec<f64>, Vec<f64>)>,
    /// How far the last pass of a crack that runs was carried on, in passes.
    extrapolation: f64,
    /// How far passes may be carried on now, in passes.
    reach: f64,
}

impl AndersonAcceleration {
    /// Remembers few passes at first.
    pub(crate) fn new(settings: DescentSettings) -> Self {
        AndersonAcceleration {
            depth: settings.anderson_depth,
            settings,
            past: Vec::new(),
            extrapolation: 0.0,
            reach: settings.extrapolation,
        }
    }

    /// Forgets all passes.
    pub(crate) fn forget(&mut self) {
        self.past.clear();
        self.extrapolation = 0.0;
        self.reach = self.settings.extrapolation;
    }

    /// Where to go on after a pass led from `start` to `end`; `None` before there are two of them.
    pub(crate) fn next(&mut self, start: Vec<f64>, end: &[f64]) -> Option<Vec<f64>> {
        let went = difference(end, &start);
        let size = norm2(&went);
        if self.past.last().is_some_and(|(_, last)| size > norm2(last)) {
            self.reach = self.settings.extrapolation;
        }
        self.past.push((start, went));
        let spare = self.past.len().saturating_sub(self.depth);
        self.past.drain(..spare);
        if self.past.len() < 2 {
            return None;
        }
        let on = match self.runs() {
            true => self.extrapolation(),
            false => self.combined(end),
        };
        let length = norm2(&on);
        let allowed = self.reach * size;
        let share = if length > allowed {
            self.reach *= self.settings.extrapolation_growth;
            allowed / length
        } else {
            1.0
        };
        Some(end.iter().zip(&on).map(|(e, on)| e + share * on).collect())
    }

    /// Whether passes go further the further they have come: no common state is near, and the
    /// combination that goes least leads back to where they were slowest.
    fn runs(&self) -> bool {
        let [.., (start, went), (next_start, next_went)] = &self.past[..] else {
            return false;
        };
        let (moved, grown) = (difference(next_start, start), difference(next_went, went));
        dot(&moved, &grown) > 0.0
    }

    /// The last pass again, as often as it has gone well.
    fn extrapolation(&mut self) -> Vec<f64> {
        self.extrapolation = (2.0 * self.extrapolation).clamp(1.0, self.settings.extrapolation);
        let last = self.past.last();
        last.map_or_else(Vec::new, |(_, went)| {
            went.iter().map(|w| self.extrapolation * w).collect()
        })
    }

    /// From `end` to where the combination of the passes that goes least leads.
    fn combined(&mut self, end: &[f64]) -> Vec<f64> {
        self.extrapolation = 0.0;
        let residuals: Vec<Vec<f64>> = self.past.iter().map(|(_, went)| went.clone()).collect();
        let shares = smallest(&residuals, dot);
        let mut on: Vec<f64> = end.iter().map(|e| -e).collect();
        for (share, (start, went)) in shares.iter().zip(&self.past) {
            let terms = start.iter().zip(went);
            on.iter_mut()
                .zip(terms)
                .for_each(|(on, (start, went))| *on += share * (start + went));
        }
        on
    }
}

fn difference(to: &[f64], from: &[f64]) -> Vec<f64> {
    to.iter().zip(from).map(|(to, from)| to - from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(map: impl Fn(&[f64]) -> Vec<f64>, start: &[f64], count: usize) -> Vec<f64> {
        let mut acceleration = AndersonAcceleration::new(DescentSettings::default());
        let mut u = start.to_vec();
        for _ in 0..count {
            let end = map(&u);
            u = acceleration.next(u, &end).unwrap_or(end);
        }
        u
    }

    /// A linear map in two unknowns is solved once its two directions have been seen.
    #[test]
    fn a_linear_map_is_solved_after_as_many_passes_as_unknowns_and_one() {
        let map = |u: &[f64]| vec![0.8 * u[0] + 1.0, -0.4 * u[1] + 0.2 * u[0]];
        let exact = [5.0, 1.0 / 1.4];
        let u = passes(map, &[0.0, 0.0], 3);
        assert!((u[0] - exact[0]).abs() < 1e-8 && (u[1] - exact[1]).abs() < 1e-8);
    }

    /// Passes of a thousandth of the way each: the limit of an extrapolation grows while they go well.
    #[test]
    fn passes_that_hardly_move_are_carried_on_as_far_as_it_takes() {
        let map = |u: &[f64]| vec![0.999 * u[0] + 0.001, 0.998 * u[1]];
        let u = passes(map, &[0.0, 1.0], 12);
        assert!((u[0] - 1.0).abs() < 1e-6 && u[1].abs() < 1e-6, "{u:?}");
    }

    /// x' = 0.1 + x² has no fixed point: plain passes need 45 to come from −2 to 2, and the combination
    /// that goes least would stay near 0 for good.
    #[test]
    fn where_there_is_no_fixed_point_passes_are_carried_on() {
        let map = |u: &[f64]| vec![u[0] + 0.1 * (0.1 + u[0] * u[0])];
        let beyond = |count: usize| passes(map, &[-2.0], count)[0] > 2.0;
        assert!((1..=25).any(beyond));
    }
}
