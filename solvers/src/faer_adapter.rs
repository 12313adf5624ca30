//! Operator and preconditioners in the form that the Krylov methods of faer take.

use std::fmt;

use faer::dyn_stack::{MemStack, StackReq};
use faer::matrix_free::{LinOp, Precond};
use faer::{MatMut, MatRef, Par, prelude::ReborrowMut};

use crate::cholesky::CholeskyFactor;
use crate::{CsrView, multiply};

/// A CSR matrix as a linear operator with a row-parallel product.
pub(crate) struct Operator<'a>(pub(crate) CsrView<'a>);

/// A preconditioner M⁻¹ of conjugate gradients.
pub(crate) enum Preconditioner<'a> {
    /// No change.
    Identity { size: usize },
    /// Inverse of the diagonal.
    Jacobi(&'a [f64]),
    /// Cholesky factor of the matrix or of an earlier one.
    Factor {
        factor: &'a CholeskyFactor,
        size: usize,
    },
}

impl fmt::Debug for Operator<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Operator({} rows)", self.0.rows())
    }
}

impl LinOp<f64> for Operator<'_> {
    fn apply_scratch(&self, _columns: usize, _par: Par) -> StackReq {
        StackReq::EMPTY
    }

    fn nrows(&self) -> usize {
        self.0.rows()
    }

    fn ncols(&self) -> usize {
        self.0.cols()
    }

    fn apply(&self, out: MatMut<'_, f64>, x: MatRef<'_, f64>, _par: Par, _memory: &mut MemStack) {
        for (mut out, x) in out.col_iter_mut().zip(x.col_iter()) {
            let contiguous = (out.rb_mut().try_as_col_major_mut(), x.try_as_col_major());
            if let (Some(out), Some(x)) = contiguous {
                multiply(self.0.view(), x.as_slice(), out.as_slice_mut());
            } else {
                let x: Vec<f64> = x.iter().copied().collect();
                let mut product = vec![0.0; self.nrows()];
                multiply(self.0.view(), &x, &mut product);
                out.iter_mut()
                    .zip(product)
                    .for_each(|(out, value)| *out = value);
            }
        }
    }

    fn conj_apply(
        &self,
        out: MatMut<'_, f64>,
        x: MatRef<'_, f64>,
        par: Par,
        memory: &mut MemStack,
    ) {
        self.apply(out, x, par, memory);
    }
}

impl fmt::Debug for Preconditioner<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Identity { .. } => "Identity",
            Self::Jacobi(_) => "Jacobi",
            Self::Factor { .. } => "Factor",
        })
    }
}

impl LinOp<f64> for Preconditioner<'_> {
    fn apply_scratch(&self, columns: usize, _par: Par) -> StackReq {
        match self {
            Self::Identity { .. } | Self::Jacobi(_) => StackReq::EMPTY,
            Self::Factor { factor, .. } => factor.apply_scratch(columns),
        }
    }

    fn nrows(&self) -> usize {
        match self {
            Self::Identity { size } | Self::Factor { size, .. } => *size,
            Self::Jacobi(inverse) => inverse.len(),
        }
    }

    fn ncols(&self) -> usize {
        self.nrows()
    }

    fn apply(
        &self,
        mut out: MatMut<'_, f64>,
        r: MatRef<'_, f64>,
        _par: Par,
        memory: &mut MemStack,
    ) {
        match self {
            Self::Identity { .. } => out.copy_from(r),
            Self::Jacobi(inverse) => {
                for column in 0..out.ncols() {
                    for (row, inverse) in inverse.iter().enumerate() {
                        out[(row, column)] = inverse * r[(row, column)];
                    }
                }
            }
            Self::Factor { factor, .. } => {
                out.copy_from(r);
                factor.apply(out, memory);
            }
        }
    }

    fn conj_apply(
        &self,
        out: MatMut<'_, f64>,
        r: MatRef<'_, f64>,
        par: Par,
        memory: &mut MemStack,
    ) {
        self.apply(out, r, par, memory);
    }
}

impl Precond<f64> for Preconditioner<'_> {}
