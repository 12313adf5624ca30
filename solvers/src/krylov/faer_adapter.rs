//! Operator and preconditioner in the form that the Krylov methods of faer take.

use std::fmt;
use std::sync::{Mutex, PoisonError};

use faer::dyn_stack::{MemStack, StackReq};
use faer::matrix_free::{LinOp, Precond};
use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef, Par};

use crate::preconditioner::Preconditioner;
use crate::{CsrView, interrupted, multiply};

/// A CSR matrix as a linear operator with a row-parallel product.
pub(super) struct Operator<'a>(pub(super) CsrView<'a>);

/// A preconditioner. faer shares it, so it is locked for every application.
pub(super) struct Shared<'a> {
    preconditioner: Mutex<&'a mut dyn Preconditioner>,
    unknowns: usize,
}

impl<'a> Shared<'a> {
    pub(super) fn new(preconditioner: &'a mut dyn Preconditioner, unknowns: usize) -> Self {
        Self {
            preconditioner: Mutex::new(preconditioner),
            unknowns,
        }
    }
}

/// Applies an operation on slices column by column. faer hands out contiguous columns.
fn by_columns(
    out: MatMut<'_, f64>,
    x: MatRef<'_, f64>,
    mut operation: impl FnMut(&[f64], &mut [f64]),
) {
    for (mut out, x) in out.col_iter_mut().zip(x.col_iter()) {
        let contiguous = (out.rb_mut().try_as_col_major_mut(), x.try_as_col_major());
        if let (Some(out), Some(x)) = contiguous {
            operation(x.as_slice(), out.as_slice_mut());
        } else {
            let x: Vec<f64> = x.iter().copied().collect();
            let mut result = vec![0.0; out.nrows()];
            operation(&x, &mut result);
            out.iter_mut()
                .zip(result)
                .for_each(|(out, value)| *out = value);
        }
    }
}

impl fmt::Debug for Operator<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Operator({} rows)", self.0.rows())
    }
}

impl fmt::Debug for Shared<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Shared({} rows)", self.unknowns)
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
        by_columns(out, x, |x, out| match interrupted() {
            // A curvature of zero is the only way to make the iteration of faer stop.
            true => out.fill(0.0),
            false => multiply(self.0.view(), x, out),
        });
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

impl LinOp<f64> for Shared<'_> {
    fn apply_scratch(&self, _columns: usize, _par: Par) -> StackReq {
        StackReq::EMPTY
    }

    fn nrows(&self) -> usize {
        self.unknowns
    }

    fn ncols(&self) -> usize {
        self.unknowns
    }

    fn apply(&self, out: MatMut<'_, f64>, r: MatRef<'_, f64>, _par: Par, _memory: &mut MemStack) {
        let locked = self.preconditioner.lock();
        let mut preconditioner = locked.unwrap_or_else(PoisonError::into_inner);
        by_columns(out, r, |r, out| preconditioner.apply(r, out));
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

impl Precond<f64> for Shared<'_> {}
