//! Sparse Cholesky factor L Lᵀ = P A Pᵀ: symbolic once, numeric into kept buffers.
//!
//! All work runs on one thread, so the bits of a factor do not depend on the number of threads.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side};

use crate::matrix::Rows;
use crate::ordering::{Permutation, nested_dissection};
use crate::problem::Problem;
use crate::{CsrView, FactorPrediction, SolveError};

/// Which fill-reducing ordering a factor uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ordering {
    /// Nested dissection if the problem has coordinates, else minimum degree.
    Automatic,
    /// Geometric nested dissection.
    NestedDissection,
    /// Approximate minimum degree.
    MinimumDegree,
}

/// Size of the Cholesky factor of a problem, from its pattern alone. The ordering is the one
/// that the direct backends use by default.
///
/// # Errors
/// Those of [`Problem::validate`]; [`SolveError::TooLarge`] above 2³¹ entries.
pub fn predict(problem: &Problem<'_>) -> Result<FactorPrediction, SolveError> {
    problem.validate()?;
    Ok(prediction(&symbolic(problem, Ordering::Automatic)?))
}

/// A Cholesky factor with all the memory it needs.
pub(crate) struct CholeskyFactor {
    symbolic: SymbolicCholesky<u32>,
    prediction: FactorPrediction,
    /// One column, so that its alignment and with it every bit is always the same.
    values: Mat<f64>,
    factor_memory: MemBuffer,
    solve_memory: MemBuffer,
}

impl CholeskyFactor {
    /// Ordering and symbolic factorisation; allocates all memory but the values.
    pub(crate) fn analyse(problem: &Problem<'_>, ordering: Ordering) -> Result<Self, SolveError> {
        let symbolic = symbolic(problem, ordering)?;
        let allocate = |request: StackReq| {
            MemBuffer::try_new(request).map_err(|_| SolveError::TooLarge {
                unknowns: problem.unknowns(),
                reason: "out of memory".into(),
            })
        };
        let factor_request =
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let solve_request = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        Ok(Self {
            prediction: prediction(&symbolic),
            values: Mat::new(),
            factor_memory: allocate(factor_request)?,
            solve_memory: allocate(solve_request)?,
            symbolic,
        })
    }

    /// Size of the factor.
    pub(crate) fn prediction(&self) -> FactorPrediction {
        self.prediction
    }

    /// Numeric factorisation. After an error the old factor is lost.
    pub(crate) fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let length = self.symbolic.len_val();
        if self.values.nrows() != length || self.values.ncols() == 0 {
            self.values = Mat::zeros(length, 1);
        }
        let rows = Rows::new(&matrix);
        let view = SparseColMatRef::new(pattern_of(&matrix), rows.values());
        let outcome = self.symbolic.factorize_numeric_llt(
            self.values.col_as_slice_mut(0),
            view,
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.factor_memory),
            Default::default(),
        );
        match outcome {
            Ok(_) => Ok(()),
            Err(LltError::NonPositivePivot { index }) => {
                let row = self.original_row(index);
                Err(SolveError::NotPositiveDefinite {
                    row,
                    diagonal: rows.get(row, row),
                })
            }
        }
    }

    /// Row of the failing pivot; faer counts it from one in the simplicial variant only.
    fn original_row(&self, index: usize) -> usize {
        let pivot = match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => index.saturating_sub(1),
            SymbolicCholeskyRaw::Supernodal(_) => index,
        };
        self.symbolic
            .perm()
            .map_or(pivot, |perm| perm.arrays().0[pivot] as usize)
    }

    /// Overwrites a right-hand side by the solution.
    pub(crate) fn solve_in_place(&mut self, x: &mut [f64]) {
        let unknowns = x.len();
        let factor = LltRef::new(&self.symbolic, self.values.col_as_slice(0));
        factor.solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, unknowns, 1),
            Par::Seq,
            MemStack::new(&mut self.solve_memory),
        );
    }

    /// Memory that [`Self::apply`] asks for.
    pub(crate) fn apply_scratch(&self, columns: usize) -> StackReq {
        self.symbolic
            .solve_in_place_scratch::<f64>(columns, Par::Seq)
    }

    /// As [`Self::solve_in_place`], with the memory of the caller.
    pub(crate) fn apply(&self, x: MatMut<'_, f64>, memory: &mut MemStack) {
        let factor = LltRef::new(&self.symbolic, self.values.col_as_slice(0));
        factor.solve_in_place_with_conj(Conj::No, x, Par::Seq, memory);
    }
}

/// The arrays of a symmetric matrix by rows are those of the same matrix by columns.
fn pattern_of<'a>(matrix: &'a CsrView<'_>) -> SymbolicSparseColMatRef<'a, u32> {
    let rows = Rows::new(matrix);
    let size = matrix.rows();
    SymbolicSparseColMatRef::new_checked(size, size, rows.starts(), None, rows.columns())
}

fn symbolic(
    problem: &Problem<'_>,
    ordering: Ordering,
) -> Result<SymbolicCholesky<u32>, SolveError> {
    let permutation = match ordering {
        Ordering::MinimumDegree => None,
        Ordering::Automatic | Ordering::NestedDissection => nested_dissection(problem),
    };
    if permutation.is_none() && ordering == Ordering::NestedDissection {
        let reason = "nested dissection needs the coordinates of the points; give them or \
                      choose ordering=amd";
        return Err(SolveError::InvalidProblem {
            reason: reason.into(),
        });
    }
    let order = permutation
        .as_ref()
        .map_or(SymmetricOrdering::Amd, |permutation| {
            let Permutation { forward, inverse } = permutation;
            SymmetricOrdering::Custom(PermRef::new_checked(forward, inverse, forward.len()))
        });
    let parameters = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::AUTO,
        ..Default::default()
    };
    factorize_symbolic_cholesky(pattern_of(&problem.pattern), Side::Lower, order, parameters)
        .map_err(|error| too_large(problem.unknowns(), error))
}

fn too_large(unknowns: usize, error: FaerError) -> SolveError {
    let reason = match error {
        FaerError::IndexOverflow => "more than 2^31 entries".into(),
        FaerError::OutOfMemory => "out of memory".into(),
        other => format!("{other:?}"),
    };
    SolveError::TooLarge { unknowns, reason }
}

fn prediction(symbolic: &SymbolicCholesky<u32>) -> FactorPrediction {
    let mut nonzeros = 0_u64;
    let mut flops = 0.0;
    let mut column = |count: u64| {
        nonzeros += count;
        flops += (count as f64).powi(2);
    };
    let indices = match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(simplicial) => {
            let starts = simplicial.col_ptr();
            starts
                .windows(2)
                .for_each(|pair| column(u64::from(pair[1] - pair[0])));
            simplicial.row_idx().len()
        }
        SymbolicCholeskyRaw::Supernodal(supernodal) => {
            let bounds = supernodal
                .supernode_begin()
                .iter()
                .zip(supernodal.supernode_end());
            for (node, (begin, end)) in bounds.enumerate() {
                let below = supernodal.supernode(node).pattern().len() as u64;
                (1..=u64::from(end - begin)).for_each(|within| column(below + within));
            }
            supernodal.row_idx().len()
        }
    };
    let bytes = 8 * symbolic.len_val() as u64 + 4 * indices as u64;
    FactorPrediction {
        nonzeros,
        flops,
        bytes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{grid_laplacian, jittered_grid, positive_definite, wide_stencil};

    fn fill(problem: &Problem<'_>, ordering: Ordering) -> u64 {
        prediction(&symbolic(problem, ordering).unwrap()).nonzeros
    }

    #[test]
    fn nested_dissection_fills_at_most_a_tenth_more_than_minimum_degree() {
        for jitter in [0.0, 0.2] {
            let cloud = jittered_grid(100, 100, jitter);
            let a = wide_stencil(&cloud, 1, 2.5, 1);
            let problem = positive_definite(&a, Some(&cloud), 1);
            let dissected = fill(&problem, Ordering::NestedDissection) as f64;
            let minimum_degree = fill(&problem, Ordering::MinimumDegree) as f64;
            assert!(
                dissected <= 1.1 * minimum_degree,
                "{dissected} against {minimum_degree}"
            );
        }
    }

    #[test]
    fn unknowns_of_a_point_fill_like_blocks_of_the_point_factor() {
        let cloud = jittered_grid(30, 30, 0.2);
        let (one, three) = (
            wide_stencil(&cloud, 1, 2.5, 1),
            wide_stencil(&cloud, 3, 2.5, 1),
        );
        let points = fill(
            &positive_definite(&one, Some(&cloud), 1),
            Ordering::NestedDissection,
        );
        let blocks = fill(
            &positive_definite(&three, Some(&cloud), 3),
            Ordering::NestedDissection,
        );
        let ratio = blocks as f64 / points as f64;
        assert!((8.0..10.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_tridiagonal_matrix_without_reordering_gain_has_no_fill() {
        let a = grid_laplacian(300, 1, 0.0);
        let size = predict(&positive_definite(&a, None, 1)).unwrap();
        assert_eq!(size.nonzeros, 2 * 300 - 1);
        assert!((size.flops - (299.0 * 4.0 + 1.0)).abs() < 0.5);
        assert_eq!(size.bytes, 12 * 599);
    }
}
