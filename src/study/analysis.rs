//! Medians, fits, Pareto fronts, and what an error costs.

use serde::Serialize;

/// Median of the finite values; `None` without any.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        odd if odd % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

/// A power law y = factor · x^slope, fitted to logarithms by least squares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Fit {
    /// Exponent.
    pub slope: f64,
    /// Half width of the 95 % confidence interval of the exponent; `None` from two points.
    pub half_width: Option<f64>,
    /// Value at x = 1.
    pub factor: f64,
    /// Pairs used.
    pub pairs: usize,
}

impl Fit {
    /// Fits the pairs of positive numbers; `None` from fewer than two different x.
    pub(crate) fn of(pairs: &[(f64, f64)]) -> Option<Fit> {
        let logs: Vec<(f64, f64)> = pairs
            .iter()
            .filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())
            .map(|(x, y)| (x.ln(), y.ln()))
            .collect();
        let count = logs.len() as f64;
        let mean_x = logs.iter().map(|(x, _)| x).sum::<f64>() / count;
        let mean_y = logs.iter().map(|(_, y)| y).sum::<f64>() / count;
        let spread: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        if logs.len() < 2 || spread < 1e-12 {
            return None;
        }
        let joint: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
        let slope = joint / spread;
        let rest: f64 = logs
            .iter()
            .map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2))
            .sum();
        let half_width = (logs.len() > 2).then(|| {
            let freedom = logs.len() - 2;
            student(freedom) * (rest / freedom as f64 / spread).sqrt()
        });
        Some(Fit {
            slope,
            half_width,
            factor: (mean_y - slope * mean_x).exp(),
            pairs: logs.len(),
        })
    }

    /// As [`Fit::of`], with the confidence that takes three pairs: two lie on a power law whatever they are.
    pub(crate) fn confident(pairs: &[(f64, f64)]) -> Option<Fit> {
        Fit::of(pairs).filter(|fit| fit.half_width.is_some())
    }
}

impl std::fmt::Display for Fit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.half_width {
            Some(half) if half < 0.01 => write!(f, "{:.3} ± {half:.3}", self.slope),
            Some(half) => write!(f, "{:.2} ± {half:.2}", self.slope),
            None => write!(f, "{:.2} (two points)", self.slope),
        }
    }
}

/// 97.5 % quantile of Student's distribution.
fn student(freedom: usize) -> f64 {
    const FEW: [f64; 10] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    ];
    let many = 1.96 + 2.6 / freedom as f64;
    FEW.get(freedom.wrapping_sub(1)).copied().unwrap_or(many)
}

/// Indices of the pairs (cost, error) that no other pair beats in both, by rising cost.
pub(crate) fn pareto(pairs: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..pairs.len())
        .filter(|&i| pairs[i].0.is_finite() && pairs[i].1.is_finite())
        .collect();
    order.sort_by(|&a, &b| {
        let by_cost = pairs[a].0.total_cmp(&pairs[b].0);
        by_cost.then(pairs[a].1.total_cmp(&pairs[b].1))
    });
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = pairs[i].1 < best;
        best = best.min(pairs[i].1);
        better
    });
    order
}

/// Cost at which the front of the pairs (cost, error) reaches `error`, interpolated in logarithms between two of
/// them; that of the cheapest if it is better. `None` if no pair reaches it.
pub(crate) fn reach(pairs: &[(f64, f64)], error: f64) -> Option<f64> {
    let front: Vec<(f64, f64)> = pareto(pairs).into_iter().map(|i| pairs[i]).collect();
    let first = front.first()?;
    if first.1 <= error {
        return Some(first.0);
    }
    for pair in front.windows(2) {
        let ((c0, e0), (c1, e1)) = (pair[0], pair[1]);
        if e1 <= error {
            // A run without any error is no place to interpolate to.
            let part = match e1 > 0.0 {
                true => (e0 / error).ln() / (e0 / e1).ln(),
                false => 1.0,
            };
            return Some(c0 * (c1 / c0).powf(part));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn the_median_ignores_what_is_not_finite() {
        assert_eq!(median(&[3.0, f64::NAN, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0]), Some(2.5));
        assert_eq!(median(&[f64::NAN]), None);
    }

    #[test]
    fn a_power_law_is_found_with_no_doubt() {
        let pairs: Vec<(f64, f64)> = [1.0, 2.0, 4.0, 8.0]
            .map(|x: f64| (x, 3.0 * x.powi(2)))
            .into();
        let fit = Fit::of(&pairs).unwrap();
        assert!((fit.slope - 2.0).abs() < 1e-12 && (fit.factor - 3.0).abs() < 1e-12);
        assert!(fit.half_width.unwrap() < 1e-6);
    }

    /// By hand: ln x = 0, 1, 2 and ln y = 0, 1.3, 2 give a slope of 1, residuals −0.1, 0.2, −0.1,
    /// a variance of 0.06 and a standard error of √(0.06/2); Student's 97.5 % for one is 12.706.
    #[test]
    fn the_confidence_is_students() {
        let e = std::f64::consts::E;
        let fit = Fit::of(&[(1.0, 1.0), (e, 1.3_f64.exp()), (e * e, e * e)]).unwrap();
        assert!((fit.slope - 1.0).abs() < 1e-12);
        assert!((fit.half_width.unwrap() - 12.706 * 0.03_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_fit_needs_two_different_places() {
        assert_eq!(Fit::of(&[(1.0, 1.0)]), None);
        assert_eq!(Fit::of(&[(1.0, 1.0), (1.0, 2.0), (-1.0, 2.0)]), None);
        let fit = Fit::of(&[(1.0, 1.0), (10.0, 0.1)]).unwrap();
        assert!((fit.slope + 1.0).abs() < 1e-12 && fit.half_width.is_none());
        assert_eq!(Fit::confident(&[(1.0, 1.0), (10.0, 0.1)]), None);
        assert!(Fit::confident(&[(1.0, 1.0), (10.0, 0.1), (100.0, 0.01)]).is_some());
    }

    #[test]
    fn the_front_leaves_out_what_is_beaten() {
        let pairs = [
            (1.0, 0.1),
            (2.0, 0.2),
            (3.0, 0.01),
            (3.0, 0.02),
            (f64::NAN, 0.0),
        ];
        assert_eq!(pareto(&pairs), [0, 2]);
    }

    #[test]
    fn an_error_between_two_runs_costs_between_them() {
        let pairs = [(1.0, 1e-1), (100.0, 1e-3)];
        assert!((reach(&pairs, 1e-2).unwrap() - 10.0).abs() < 1e-9);
        assert_eq!(reach(&pairs, 0.5), Some(1.0), "the cheapest is better");
        assert_eq!(reach(&pairs, 1e-3), Some(100.0));
        assert_eq!(reach(&pairs, 0.99e-3), None, "beyond the best");
        assert_eq!(reach(&[], 1e-2), None);
    }
}
