//! Anderson's method for passes whose coefficients lag behind the displacement.

use perifrac_solvers::dot;

use crate::schemes::mixer::smallest;

/// Passes that are remembered.
const DEPTH: usize = 4;

/// Displacements from which passes started, m, and how far they went; the newest last.
#[derive(Default)]
pub struct Acceleration {
    past: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Acceleration {
    /// Forgets all passes.
    pub fn forget(&mut self) {
        self.past.clear();
    }

    /// Where to go on after a pass led from `start` to `end`; `None` before there are two of them.
    pub fn next(&mut self, start: Vec<f64>, end: &[f64]) -> Option<Vec<f64>> {
        let went = end.iter().zip(&start).map(|(e, s)| e - s).collect();
        self.past.push((start, went));
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
        if self.past.len() < 2 {
            return None;
        }
        let residuals: Vec<Vec<f64>> = self.past.iter().map(|(_, went)| went.clone()).collect();
        let shares = smallest(&residuals, dot);
        let mut next = vec![0.0; end.len()];
        for (share, (start, went)) in shares.iter().zip(&self.past) {
            let terms = start.iter().zip(went);
            next.iter_mut()
                .zip(terms)
                .for_each(|(next, (start, went))| *next += share * (start + went));
        }
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear map in two unknowns is solved once its two directions have been seen.
    #[test]
    fn a_linear_map_is_solved_after_as_many_passes_as_unknowns_and_one() {
        let map = |u: &[f64]| vec![0.9 * u[0] + 1.0, -0.4 * u[1] + 0.2 * u[0]];
        let exact = [10.0, 2.0 / 1.4];
        let mut acceleration = Acceleration::default();
        let mut u = vec![0.0, 0.0];
        for _ in 0..3 {
            let end = map(&u);
            let next = acceleration.next(u, &end);
            u = next.unwrap_or(end);
        }
        assert!((u[0] - exact[0]).abs() < 1e-8 && (u[1] - exact[1]).abs() < 1e-8);
    }
}
