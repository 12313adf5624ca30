//! What rounding leaves of the balances of forces and of fluid.

use perifrac_solvers::magnitude;

use super::{FlowModel, SolidModel};
use crate::operators::diagonal;

/// Σ|K_ij| of a row over its diagonal entry, by its order of magnitude, which is all that a scale of rounding needs.
const ROW: f64 = 4.0;

impl<const D: usize> SolidModel<D> {
    /// ε Σ (|K||u| + |r||w|), N: forces out of balance, Σ of absolutes, that are rounding errors.
    ///
    /// Displacements are known to a relative ε/2, which K turns into ε/2 |K||u|, and every product adds
    /// an error of ε/2 of a term. Iterative refinement comes down to this and no further (Higham 2002,
    /// Accuracy and Stability of Numerical Algorithms, Secs. 3.1 and 12.2); signs are random, so that
    /// the errors of a row do not add up. The closer Poisson's ratio is to 0.5, the larger is K beside
    /// the loads.
    pub fn rounding(&self, displacement: &[f64], walls: &[f64]) -> f64 {
        let mut size = [match &self.force {
            // Without entries: rows of K are at most so many diagonals.
            Some(_) => {
                let unknowns = displacement.chunks_exact(D).zip(diagonal(&self.elastic));
                let sizes = unknowns.map(|(u, own)| own * u.iter().map(|u| u.abs()).sum::<f64>());
                ROW * sizes.sum::<f64>()
            }
            None => magnitude(self.matrix(), displacement),
        }];
        self.subdomain().sum(&mut size);
        for (wall, place) in self.walls.iter().zip(walls) {
            let response = wall.response.iter();
            size[0] += response.map(|(_, r)| (r * place).abs()).sum::<f64>();
        }
        f64::EPSILON * size[0]
    }
}

impl<const D: usize> FlowModel<D> {
    /// 4 ε √(Σ (Σ_j |L_ij||p_j|)²), m^D/s: rates out of balance in a steady state that are rounding errors,
    /// as their signs are random from row to row.
    ///
    /// Pressures next to a side of better rock differ from that on the side by few digits, and what flows
    /// through it is known no better: two layers of 1 : 1e12, 40 cells across, miss the balance by 1.0e-2 to
    /// 1.3e-2 of the turnover with the built-in solvers, a little more than without the factor 4.
    pub fn rounding(&self, pressure: &[f64]) -> f64 {
        let terms = |row: usize| {
            let entries = self.pattern.row(row);
            let columns = &self.pattern.columns[entries.clone()];
            let pairs = self.conductance[entries].iter().zip(columns);
            pairs.map(|(value, &column)| (value * pressure[column as usize]).abs())
        };
        let rows = (0..self.points()).map(|row| terms(row).sum::<f64>().powi(2));
        let mut square = [rows.sum()];
        self.subdomain().sum(&mut square);
        4.0 * f64::EPSILON * square[0].sqrt()
    }
}
