//! Backend `faer-lu`: sparse L U factorisation with row pivoting, for matrices without symmetry.
//!
//! It is a last resort. Wide rows fill it so much that 30 000 unknowns of a two-hop stencil take
//! about 20 s, against 0.4 s for a symmetric factor: keep systems symmetric. Hence the limit.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{FaerError, SparseColMatRef};
use faer::{Conj, MatMut, Par};

use crate::cholesky::{pattern_of, too_large};
use crate::direct::{Direct, Factor};
use crate::matrix::Rows;
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, OptionSpec, OptionValue, Options};
use crate::{CsrView, LinearSolver, SolveError, SpecError};

const NAME: &str = "faer-lu";

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "sparse LU with pivoting (direct), for small systems of any kind",
    symmetries: &[
        Symmetry::PositiveDefinite,
        Symmetry::QuasiDefinite,
        Symmetry::Indefinite,
        Symmetry::General,
    ],
    distributed: false,
    lattices_only: false,
    options: &[OptionSpec {
        key: "max_unknowns",
        value: OptionValue::Count,
        default: "10000",
        meaning: "larger systems are refused, because they take minutes",
    }],
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let most = options.count("max_unknowns")?;
    let symbolic = move |problem: &Problem<'_>| -> Result<Box<dyn Factor>, SolveError> {
        if problem.unknowns() > most {
            return Err(refusal(problem, most));
        }
        Ok(Box::new(LuFactor::analyse(problem)?))
    };
    Ok(Box::new(Direct::new(&BACKEND, Box::new(symbolic))))
}

fn refusal(problem: &Problem<'_>, most: usize) -> SolveError {
    let instead = match problem.symmetry {
        Symmetry::PositiveDefinite => "use `faer-llt`",
        Symmetry::QuasiDefinite => "use `faer-ldlt`",
        Symmetry::Indefinite => "use `minres`, or write it as a quasi-definite system",
        Symmetry::General => "use `gmres`, or keep the system symmetric",
    };
    SolveError::Refused {
        solver: NAME,
        symmetry: problem.symmetry,
        advice: format!(
            "{} unknowns are more than max_unknowns={most}, and a factor with row pivoting takes \
             minutes; {instead}, or raise max_unknowns",
            problem.unknowns()
        ),
    }
}

/// Factors of Aᵀ: the arrays of a matrix by rows are those of its transpose by columns, so no entry
/// moves, and substitutions solve with the transpose.
struct LuFactor {
    symbolic: SymbolicLu<u32>,
    numeric: NumericLu<u32, f64>,
    factor_memory: MemBuffer,
    solve_memory: MemBuffer,
    /// Whether `numeric` holds a factor.
    factored: bool,
}

impl LuFactor {
    fn analyse(problem: &Problem<'_>) -> Result<Self, SolveError> {
        let unknowns = problem.unknowns();
        let symbolic = factorize_symbolic_lu(pattern_of(&problem.pattern), Default::default())
            .map_err(|error| too_large(unknowns, error))?;
        let allocate = |request: StackReq| {
            MemBuffer::try_new(request).map_err(|_| too_large(unknowns, FaerError::OutOfMemory))
        };
        let factor = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_transpose_in_place_scratch::<f64>(1, Par::Seq);
        Ok(Self {
            factor_memory: allocate(factor)?,
            solve_memory: allocate(solve)?,
            symbolic,
            numeric: NumericLu::new(),
            factored: false,
        })
    }

    fn error(&self, matrix: &CsrView<'_>, error: LuError) -> SolveError {
        match error {
            LuError::SymbolicSingular { index } => {
                let row = self.symbolic.col_perm().arrays().0[index] as usize;
                let diagonal = Rows::new(matrix).get(row, row);
                SolveError::ZeroPivot { row, diagonal }
            }
            LuError::Generic(error) => too_large(matrix.rows(), error),
        }
    }
}

impl Factor for LuFactor {
    fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let view = SparseColMatRef::new(pattern_of(&matrix), Rows::new(&matrix).values());
        let memory = MemStack::new(&mut self.factor_memory);
        let outcome = self.symbolic.factorize_numeric_lu(
            &mut self.numeric,
            view,
            Par::Seq,
            memory,
            Default::default(),
        );
        let outcome = outcome.map(|_| ());
        self.factored = outcome.is_ok();
        outcome.map_err(|error| self.error(&matrix, error))
    }

    fn solve_in_place(&mut self, x: &mut [f64]) {
        if !self.factored {
            return;
        }
        let size = x.len();
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_transpose_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, size, 1),
            Par::Seq,
            MemStack::new(&mut self.solve_memory),
        );
    }

    /// faer does not tell the size of these factors.
    fn size(&self) -> (u64, u64) {
        (0, 0)
    }
}

#[cfg(test)]
mod tests;
