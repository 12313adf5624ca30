//! Acceleration of the passes between flow and mechanics.

use nalgebra::{DMatrix, DVector};
use perifrac_solvers::dot;

use super::memory::Predictor;
use crate::plan::Acceleration;

/// Passes that Anderson's method remembers.
const DEPTH: usize = 5;

/// Chooses the next guess from those before: the content mixes like the pressure, because the solid
/// is linear in it.
pub(super) struct Accelerator {
    kind: Acceleration,
    /// Guesses and what they led to, the newest last.
    past: Vec<(Predictor, Predictor)>,
    /// Aitken's factor.
    factor: f64,
}

impl Accelerator {
    /// Nothing remembered yet.
    pub(super) fn new(kind: Acceleration) -> Self {
        Accelerator {
            kind,
            past: Vec::new(),
            factor: 1.0,
        }
    }

    /// The next guess after `guess` led to `found`; `weight` (shape `(n,)`) is the norm's.
    pub(super) fn next(&mut self, guess: Predictor, found: Predictor, weight: &[f64]) -> Predictor {
        if self.kind == Acceleration::None {
            return found;
        }
        let depth = if self.kind == Acceleration::Aitken {
            2
        } else {
            DEPTH
        };
        self.past.push((guess, found));
        if self.past.len() > depth {
            self.past.remove(0);
        }
        match self.kind {
            Acceleration::Aitken => self.aitken(weight),
            _ => self.anderson(weight),
        }
    }

    /// Change that pass `k` made to the pressure.
    fn residual(&self, k: usize) -> Vec<f64> {
        let (guess, found) = &self.past[k];
        found
            .pressure
            .iter()
            .zip(&guess.pressure)
            .map(|(f, g)| f - g)
            .collect()
    }

    fn aitken(&mut self, weight: &[f64]) -> Predictor {
        let last = self.past.len() - 1;
        if last > 0 {
            let (before, now) = (self.residual(last - 1), self.residual(last));
            let change: Vec<f64> = now.iter().zip(&before).map(|(n, b)| n - b).collect();
            let size = inner(weight, &change, &change);
            if size > 0.0 {
                self.factor =
                    (-self.factor * inner(weight, &before, &change) / size).clamp(0.05, 20.0);
            }
        }
        let (guess, found) = &self.past[last];
        mix(&[(1.0 - self.factor, guess), (self.factor, found)])
    }

    /// Combination of the passes with the smallest change, taken at where they led to.
    fn anderson(&self, weight: &[f64]) -> Predictor {
        let count = self.past.len();
        let residuals: Vec<Vec<f64>> = (0..count).map(|k| self.residual(k)).collect();
        let shares = smallest(&residuals, |a, b| inner(weight, a, b));
        let terms: Vec<(f64, &Predictor)> = shares
            .into_iter()
            .zip(&self.past)
            .map(|(share, (_, found))| (share, found))
            .collect();
        mix(&terms)
    }
}

/// Shares, with sum one, of the combination of `residuals` that is smallest in the norm of `inner`.
pub(super) fn smallest(residuals: &[Vec<f64>], inner: impl Fn(&[f64], &[f64]) -> f64) -> Vec<f64> {
    let Some((newest, older)) = residuals.split_last() else {
        return Vec::new();
    };
    // Differences to the newest keep the sum of the shares at one.
    let difference = |r: &Vec<f64>| newest.iter().zip(r).map(|(n, r)| n - r).collect();
    let differences: Vec<Vec<f64>> = older.iter().map(difference).collect();
    let size = differences.len();
    let gram = DMatrix::from_fn(size, size, |k, l| inner(&differences[k], &differences[l]));
    let rhs = DVector::from_fn(size, |k, _| inner(&differences[k], newest));
    let scale = if size > 0 { gram.diagonal().max() } else { 0.0 };
    let solved = match scale > 0.0 {
        true => (gram / scale)
            .svd(true, true)
            .solve(&(rhs / scale), 1e-12)
            .ok(),
        false => None,
    };
    let mut shares = solved.map_or_else(|| vec![0.0; size], |s| s.iter().copied().collect());
    shares.push(1.0 - shares.iter().sum::<f64>());
    shares
}

fn inner(weight: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let weighted: Vec<f64> = a.iter().zip(weight).map(|(a, w)| a * w).collect();
    dot(&weighted, b)
}

fn mix(terms: &[(f64, &Predictor)]) -> Predictor {
    let points = terms.first().map_or(0, |(_, guess)| guess.pressure.len());
    let mut sum = Predictor::none(points);
    for (share, guess) in terms {
        sum.pressure
            .iter_mut()
            .zip(&guess.pressure)
            .for_each(|(s, g)| *s += share * g);
        sum.content
            .iter_mut()
            .zip(&guess.content)
            .for_each(|(s, g)| *s += share * g);
    }
    sum
}
