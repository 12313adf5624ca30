//! What rounding leaves of the balance of forces.

use perifrac_solvers::magnitude;

use super::SolidModel;

impl<const D: usize> SolidModel<D> {
    /// ε Σ (|K||u| + |r||w|), N: forces out of balance, Σ of absolutes, that are rounding errors.
    ///
    /// Displacements are known to a relative ε/2, which K turns into ε/2 |K||u|, and every product adds
    /// an error of ε/2 of a term. Iterative refinement comes down to this and no further (Higham 2002,
    /// Accuracy and Stability of Numerical Algorithms, Secs. 3.1 and 12.2); signs are random, so that
    /// the errors of a row do not add up. The closer Poisson's ratio is to 0.5, the larger is K beside
    /// the loads.
    pub fn rounding(&self, displacement: &[f64], walls: &[f64]) -> f64 {
        let mut size = [magnitude(self.matrix(), displacement)];
        self.subdomain().sum(&mut size);
        for (wall, place) in self.walls.iter().zip(walls) {
            let response = wall.response.iter();
            size[0] += response.map(|(_, r)| (r * place).abs()).sum::<f64>();
        }
        f64::EPSILON * size[0]
    }
}
