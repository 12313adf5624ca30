//! Sparse Cholesky factors L Lᵀ or L D Lᵀ = P A Pᵀ: symbolic once, numeric into kept buffers.
//!
//! L D Lᵀ without pivoting exists for every ordering of a symmetric quasi-definite matrix
//! (Vanderbei 1995, SIAM J. Optim. 5, 100). Nothing is added to small pivots.
//!
//! The bits of a factor do not depend on the number of threads.

mod fronts;
mod tree;

use std::sync::Arc;

use fronts::{Failure, Fronts, Ordered};
use tree::Tree;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::prelude::IntoConst;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::simplicial::{
    SymbolicSimplicialCholesky, factorize_simplicial_numeric_ldlt,
    factorize_simplicial_numeric_ldlt_scratch, factorize_simplicial_numeric_llt,
};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::utils::{permute_self_adjoint_scratch, permute_self_adjoint_to_unsorted};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::RealField;
use faer::{Conj, Mat, MatMut, Par, Side};

use crate::matrix::Rows;
use crate::ordering::{Permutation, PointGraph, PointOrder, dissect, is_slender, sweep};
use crate::parallel::Places;
use crate::problem::{Problem, Symmetry};
use crate::{CsrView, FactorPrediction, SolveError};

/// Which ordering a factor uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ordering {
    /// With coordinates nested dissection, or a sweep where the cloud is slender and the sweep
    /// takes fewer operations; else minimum degree.
    Automatic,
    /// Geometric nested dissection.
    NestedDissection,
    /// Point after point along the longest axis.
    Sweep,
    /// Approximate minimum degree.
    MinimumDegree,
}

/// Which factor is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// L Lᵀ of a positive definite matrix.
    Llt,
    /// L D Lᵀ of a quasi-definite matrix, without pivoting.
    Ldlt,
}

impl Kind {
    /// The cheapest factor that a matrix of this kind has.
    pub(crate) fn of(symmetry: Symmetry) -> Self {
        match symmetry {
            Symmetry::PositiveDefinite => Self::Llt,
            _ => Self::Ldlt,
        }
    }
}

/// Size of the Cholesky factor of a problem, from its pattern alone. The ordering is the one
/// that the direct backends use by default.
///
/// # Errors
/// Those of [`Problem::validate`]; [`SolveError::TooLarge`] above 2³¹ entries.
pub fn predict(problem: &Problem<'_>) -> Result<FactorPrediction, SolveError> {
    problem.validate()?;
    Ok(prediction::<f64>(&symbolic(problem, Ordering::Automatic)?))
}

/// A Cholesky factor with all the memory it needs, in double or single precision.
pub(crate) struct CholeskyFactor<T: RealField> {
    kind: Kind,
    symbolic: Arc<SymbolicCholesky<u32>>,
    /// The supernodes; none where there is next to no fill.
    tree: Arc<Tree>,
    prediction: FactorPrediction,
    /// One column, so that its alignment and with it every bit is always the same.
    values: Mat<T>,
    factor_memory: MemBuffer,
    solve_memory: MemBuffer,
    /// The matrix in the order of a factor without supernodes.
    upper: Upper<T>,
}

/// The upper triangle of a matrix by columns.
struct Upper<T> {
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<T>,
}

impl<T: RealField + Copy> CholeskyFactor<T> {
    /// Ordering and symbolic factorisation; allocates all memory but the values.
    pub(crate) fn analyse(
        problem: &Problem<'_>,
        kind: Kind,
        ordering: Ordering,
    ) -> Result<Self, SolveError> {
        let symbolic = symbolic(problem, ordering)?;
        let tree = match symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => Tree::default(),
            SymbolicCholeskyRaw::Supernodal(supernodes) => Tree::new(supernodes),
        };
        Self::of(Arc::new(symbolic), Arc::new(tree), kind)
    }

    /// The same factor in double precision, without values.
    pub(crate) fn in_double_precision(&self) -> Result<CholeskyFactor<f64>, SolveError> {
        CholeskyFactor::of(self.symbolic.clone(), self.tree.clone(), self.kind)
    }

    /// Allocates all memory but the values.
    fn of(
        symbolic: Arc<SymbolicCholesky<u32>>,
        tree: Arc<Tree>,
        kind: Kind,
    ) -> Result<Self, SolveError> {
        let allocate = |request: StackReq| {
            MemBuffer::try_new(request).map_err(|_| out_of_memory(symbolic.nrows()))
        };
        let factor_request = match symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(_) => StackReq::EMPTY,
            SymbolicCholeskyRaw::Simplicial(_) => {
                let unknowns = symbolic.nrows();
                let numeric = factorize_simplicial_numeric_ldlt_scratch::<u32, T>(unknowns);
                numeric.or(permute_self_adjoint_scratch::<u32>(unknowns))
            }
        };
        let solve_request = symbolic.solve_in_place_scratch::<T>(1, Par::Seq);
        Ok(Self {
            kind,
            prediction: prediction::<T>(&symbolic),
            values: Mat::new(),
            factor_memory: allocate(factor_request)?,
            solve_memory: allocate(solve_request)?,
            upper: Upper {
                starts: Vec::new(),
                rows: Vec::new(),
                values: Vec::new(),
            },
            symbolic,
            tree,
        })
    }

    /// Size of the factor.
    pub(crate) fn prediction(&self) -> FactorPrediction {
        self.prediction
    }

    /// Numeric factorisation of these values on the pattern of `matrix`, which errors quote. After an
    /// error the old factor is lost.
    pub(crate) fn factorise_values(
        &mut self,
        matrix: CsrView<'_>,
        entries: &[T],
    ) -> Result<(), SolveError> {
        self.reserve();
        let outcome = match self.symbolic.clone().raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                self.factorise_fronts(symbolic, matrix, entries)
            }
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                self.factorise_columns(symbolic, matrix, entries)
            }
        };
        outcome.map_err(|failure| match failure {
            Failure::Pivot(row) => self.pivot_error(Rows::new(&matrix), row),
            Failure::Memory => out_of_memory(matrix.rows()),
        })
    }

    /// Front by front.
    fn factorise_fronts(
        &mut self,
        symbolic: &SymbolicSupernodalCholesky<u32>,
        matrix: CsrView<'_>,
        entries: &[T],
    ) -> Result<(), Failure> {
        let fronts = Fronts {
            tree: &self.tree,
            symbolic,
            kind: self.kind,
            matrix: Ordered {
                rows: Rows::new(&matrix),
                entries,
                permutation: self.symbolic.perm().map(PermRef::arrays),
            },
            values: Places::of(self.values.col_as_slice_mut(0)),
        };
        fronts.factorise()
    }

    /// Column by column, where there is next to no fill.
    fn factorise_columns(
        &mut self,
        symbolic: &SymbolicSimplicialCholesky<u32>,
        matrix: CsrView<'_>,
        entries: &[T],
    ) -> Result<(), Failure> {
        let memory = MemStack::new(&mut self.factor_memory);
        let given = SparseColMatRef::new(pattern_of(&matrix), entries);
        let Upper {
            starts,
            rows,
            values: own,
        } = &mut self.upper;
        starts.resize(matrix.rows() + 1, 0);
        rows.resize(entries.len(), 0);
        own.resize(entries.len(), T::zero());
        let (lower, upper) = (Side::Lower, Side::Upper);
        // Without a permutation the upper triangle is there as it is.
        let ordered = match self.symbolic.perm() {
            None => given,
            Some(order) => permute_self_adjoint_to_unsorted(
                own, starts, rows, given, order, lower, upper, memory,
            )
            .into_const(),
        };
        let values = self.values.col_as_slice_mut(0);
        match self.kind {
            Kind::Llt => {
                let plain = Default::default();
                factorize_simplicial_numeric_llt(values, ordered, plain, symbolic, memory)
                    .map(|_| ())
                    .map_err(|LltError::NonPositivePivot { index }| Failure::Pivot(index))
            }
            Kind::Ldlt => {
                let plain = Default::default();
                factorize_simplicial_numeric_ldlt(values, ordered, plain, symbolic, memory)
                    .map(|_| ())
                    .map_err(|LdltError::ZeroPivot { index }| Failure::Pivot(index))
            }
        }
    }

    /// Allocates the values with the first factorisation.
    fn reserve(&mut self) {
        let length = self.symbolic.len_val();
        if self.values.nrows() != length || self.values.ncols() == 0 {
            self.values = Mat::zeros(length, 1);
        }
    }

    fn pivot_error(&self, rows: Rows<'_>, index: usize) -> SolveError {
        let row = self.original_row(index);
        let diagonal = rows.get(row, row);
        match self.kind {
            Kind::Llt => SolveError::NotPositiveDefinite { row, diagonal },
            Kind::Ldlt => SolveError::ZeroPivot { row, diagonal },
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
    pub(crate) fn solve_in_place(&mut self, x: &mut [T]) {
        let (symbolic, values) = (&self.symbolic, self.values.col_as_slice(0));
        let x = MatMut::from_column_major_slice_mut(x, symbolic.nrows(), 1);
        let memory = MemStack::new(&mut self.solve_memory);
        let (conj, par) = (Conj::No, Par::Seq);
        match self.kind {
            Kind::Llt => {
                LltRef::new(symbolic, values).solve_in_place_with_conj(conj, x, par, memory);
            }
            Kind::Ldlt => {
                LdltRef::new(symbolic, values).solve_in_place_with_conj(conj, x, par, memory);
            }
        }
    }
}

impl CholeskyFactor<f64> {
    /// Numeric factorisation. After an error the old factor is lost.
    pub(crate) fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.factorise_values(matrix, Rows::new(&matrix).values())
    }
}

/// The arrays of a symmetric matrix by rows are those of the same matrix by columns.
pub(crate) fn pattern_of<'a>(matrix: &'a CsrView<'_>) -> SymbolicSparseColMatRef<'a, u32> {
    let rows = Rows::new(matrix);
    let size = matrix.rows();
    SymbolicSparseColMatRef::new_checked(size, size, rows.starts(), None, rows.columns())
}

fn symbolic(
    problem: &Problem<'_>,
    ordering: Ordering,
) -> Result<SymbolicCholesky<u32>, SolveError> {
    let permutation = permutation(problem, ordering)?;
    symbolic_of(pattern_of(&problem.pattern), permutation.as_ref())
}

/// The permutation of an ordering; `None` for minimum degree.
fn permutation(
    problem: &Problem<'_>,
    ordering: Ordering,
) -> Result<Option<Permutation>, SolveError> {
    if ordering == Ordering::MinimumDegree {
        return Ok(None);
    }
    let Some(coordinates) = problem.coordinates else {
        if ordering == Ordering::Automatic {
            return Ok(None);
        }
        let reason = "nested dissection and sweep need the coordinates of the points; give them \
                      or choose ordering=amd";
        return Err(SolveError::InvalidProblem {
            reason: reason.into(),
        });
    };
    let graph = PointGraph::new(problem);
    let order = match ordering {
        Ordering::Sweep => sweep(&coordinates, problem.points()),
        Ordering::Automatic if is_slender(&coordinates) => {
            let orders = [
                dissect(&coordinates, &graph),
                sweep(&coordinates, problem.points()),
            ];
            cheapest(orders, &graph)?
        }
        _ => dissect(&coordinates, &graph),
    };
    Ok(Some(order.of_unknowns(problem)))
}

/// The order of the points that takes fewer operations; the first of equals.
fn cheapest(orders: [PointOrder; 2], graph: &PointGraph<'_>) -> Result<PointOrder, SolveError> {
    let operations = |order: &PointOrder| {
        let (starts, neighbours) = graph.parts();
        let points = starts.len() - 1;
        let pattern =
            SymbolicSparseColMatRef::new_unsorted_checked(points, points, starts, None, neighbours);
        symbolic_of(pattern, Some(&order.of_points()))
            .map(|symbolic| prediction::<f64>(&symbolic).flops)
    };
    let (first, second) = (operations(&orders[0])?, operations(&orders[1])?);
    let [one, other] = orders;
    Ok(if second < first { other } else { one })
}

fn symbolic_of(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    permutation: Option<&Permutation>,
) -> Result<SymbolicCholesky<u32>, SolveError> {
    let order = permutation.map_or(SymmetricOrdering::Amd, |permutation| {
        let Permutation { forward, inverse } = permutation;
        SymmetricOrdering::Custom(PermRef::new_checked(forward, inverse, forward.len()))
    });
    let parameters = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::AUTO,
        ..Default::default()
    };
    factorize_symbolic_cholesky(pattern, Side::Lower, order, parameters)
        .map_err(|error| too_large(pattern.nrows(), error))
}

fn out_of_memory(unknowns: usize) -> SolveError {
    too_large(unknowns, FaerError::OutOfMemory)
}

pub(crate) fn too_large(unknowns: usize, error: FaerError) -> SolveError {
    let reason = match error {
        FaerError::IndexOverflow => "more than 2^31 entries".into(),
        FaerError::OutOfMemory => "out of memory".into(),
        other => format!("{other:?}"),
    };
    SolveError::TooLarge { unknowns, reason }
}

/// Size of a factor with entries of type `T`.
fn prediction<T>(symbolic: &SymbolicCholesky<u32>) -> FactorPrediction {
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
    let bytes = (size_of::<T>() * symbolic.len_val() + size_of::<u32>() * indices) as u64;
    FactorPrediction {
        nonzeros,
        flops,
        bytes,
    }
}

#[cfg(test)]
mod tests;
