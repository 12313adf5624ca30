//! Unknowns beyond a factored matrix: plates.

use nalgebra::{DMatrix, DVector};

use super::StepError;

/// A few unknowns beyond the factored matrix A: [A B; Bᵀ C] with A⁻¹ at hand.
#[derive(Debug, Clone, Default)]
pub(super) struct BorderedSystem {
    columns: Vec<Vec<f64>>,
    /// A⁻¹ B.
    solved: Vec<Vec<f64>>,
    /// (C − Bᵀ A⁻¹ B)⁻¹.
    inverse: DMatrix<f64>,
}

impl BorderedSystem {
    /// System bordered by the given columns and the stiffness of the plates; `solve` applies A⁻¹.
    ///
    /// # Errors
    /// Those of `solve`; [`StepError::UnsupportedPlate`] if the bordered matrix is singular.
    pub(super) fn new(
        columns: Vec<Vec<f64>>,
        plate_stiffness: DMatrix<f64>,
        mut solve: impl FnMut(&[f64]) -> Result<Vec<f64>, StepError>,
    ) -> Result<Self, StepError> {
        let solved: Result<Vec<Vec<f64>>, StepError> =
            columns.iter().map(|column| solve(column)).collect();
        let solved = solved?;
        let schur = DMatrix::from_fn(columns.len(), columns.len(), |k, l| {
            plate_stiffness[(k, l)] - perifrac_solvers::dot(&columns[k], &solved[l])
        });
        let inverse = match columns.is_empty() {
            true => schur,
            false => schur.try_inverse().ok_or(StepError::UnsupportedPlate)?,
        };
        Ok(BorderedSystem {
            columns,
            solved,
            inverse,
        })
    }

    /// Turns `x` = A⁻¹ f into the solution of the bordered system with right-hand side (f, g); gives
    /// the border's unknowns.
    pub(super) fn close(&self, x: &mut [f64], rest: &[f64]) -> Vec<f64> {
        if self.columns.is_empty() {
            return Vec::new();
        }
        let rhs = self
            .columns
            .iter()
            .zip(rest)
            .map(|(b, g)| g - perifrac_solvers::dot(b, x));
        let own = &self.inverse * DVector::from_iterator(self.columns.len(), rhs);
        for (solved, w) in self.solved.iter().zip(own.iter()) {
            x.iter_mut().zip(solved).for_each(|(x, z)| *x -= w * z);
        }
        own.iter().copied().collect()
    }
}
