//! What a solver reports: residuals of a solve, counts of its work, size of its factor.

use serde::{Deserialize, Serialize};

/// Outcome of one solve. Both residuals are computed afresh from the matrix.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SolveReport {
    /// Krylov iterations, or refinement steps of a direct solver.
    pub iterations: usize,
    /// True relative residual ‖b − A x‖₂ / ‖b‖₂; 0 for a zero right-hand side.
    pub true_residual: f64,
    /// The same with rows divided by the diagonal, ‖D⁻¹(b − A x)‖₂ / ‖D⁻¹b‖₂. It shows errors
    /// in soft zones, which the plain norm hides.
    pub scaled_residual: f64,
}

/// Work done by a solver since it was built.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SolverCounters {
    /// Patterns analysed (ordering and symbolic factorisation).
    pub analyses: u64,
    /// Numeric factorisations.
    pub factorisations: u64,
    /// Changes of values taken in.
    pub refreshes: u64,
    /// Solves that succeeded.
    pub solves: u64,
    /// Krylov iterations over all solves.
    pub iterations: u64,
    /// Steps of iterative refinement over all solves.
    pub refinements: u64,
    /// Stored entries of the current factor, 0 without one.
    pub factor_nonzeros: u64,
    /// Bytes of the current factor with its indices, 0 without one.
    pub factor_bytes: u64,
}

impl SolverCounters {
    /// Adds the work of another solver for the same unknowns; of two factors the larger one counts.
    pub fn add(&mut self, other: &SolverCounters) {
        self.analyses += other.analyses;
        self.factorisations += other.factorisations;
        self.refreshes += other.refreshes;
        self.solves += other.solves;
        self.iterations += other.iterations;
        self.refinements += other.refinements;
        self.factor_nonzeros = self.factor_nonzeros.max(other.factor_nonzeros);
        self.factor_bytes = self.factor_bytes.max(other.factor_bytes);
    }
}

/// Size of a Cholesky factor, known before any number is computed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FactorPrediction {
    /// Entries of the lower triangular factor, with those that merged supernodes add.
    pub nonzeros: u64,
    /// Multiplications and additions of one numeric factorisation, Σ (column count)².
    pub flops: f64,
    /// Bytes of the values and indices of the factor, without the working memory.
    pub bytes: u64,
}
