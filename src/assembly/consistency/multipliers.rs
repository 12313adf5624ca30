//! The multipliers of the correction: A λ = t − Gᵀ V 1.

use perifrac_solvers::{Coordinates, CsrView, Problem, SolverSpec, Symmetry, multiply};

use super::ConsistencyError;
use crate::assembly::{Pattern, Refill, scalar};
use crate::operators::{BondForm, Hourglass, MirrorContinuation};

/// Shift of the diagonal against rounding errors in the factor, relative to it.
const SHIFT: f64 = 1e-13;
/// Shift where one-sided planes leave the matrix singular; the right-hand side has no share in what
/// it cannot see, so refinement removes the shift's effect.
const SINGULAR_SHIFT: f64 = 1e-9;
/// The shift for a matrix that sees all functions, or not.
pub(super) fn shift(sees_all: bool) -> f64 {
    match sees_all {
        true => SHIFT,
        false => SINGULAR_SHIFT,
    }
}

/// Corrections of the multipliers; each gains several digits.
const REFINEMENTS: usize = 12;

/// Factor of the shifted matrix over several processes.
const DISTRIBUTED: &str = "petsc:-ksp_type preonly -pc_type cholesky";

/// λ with A λ = rhs, by a factor of the shifted matrix and refinement with the true one.
pub(super) fn multipliers<const D: usize>(
    form: &Hourglass<D>,
    natural: &MirrorContinuation<D>,
    pattern: &Pattern,
    rhs: &[f64],
    shift: f64,
) -> Result<Vec<f64>, ConsistencyError> {
    let largest = rhs.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    let mut lambda = vec![0.0; rhs.len()];
    let around = form.neighbourhood();
    let face = around
        .cloud
        .volume
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    if largest <= 1e-15 * face {
        return Ok(lambda);
    }
    let mut values = vec![0.0; pattern.nonzeros()];
    let plan = Refill::new(form, natural, pattern);
    scalar::fill(form, natural, &[], pattern, &plan, &mut values);
    let mut shifted = values.clone();
    for (_, diagonal) in pattern.diagonals() {
        shifted[diagonal] *= 1.0 + shift;
    }
    let shape = (pattern.rows(), pattern.rows());
    let view = |values| CsrView::new(shape, &pattern.offsets[..], &pattern.columns[..], values);
    let coordinates = around.cloud.flat_positions();
    let share = &around.families.share;
    let name = match share.partition() {
        None => "faer-llt",
        Some(_) => DISTRIBUTED,
    };
    let mut solver = name.parse::<SolverSpec>()?.build()?;
    solver.analyse(&Problem {
        partition: share.partition(),
        coordinates: Some(Coordinates {
            dimension: D,
            values: &coordinates,
        }),
        ..Problem::new(view(&shifted), Symmetry::PositiveDefinite, 1)
    })?;
    solver.refresh(view(&shifted))?;
    let (mut residual, mut product, mut step) =
        (rhs.to_vec(), vec![0.0; rhs.len()], vec![0.0; rhs.len()]);
    for _ in 0..REFINEMENTS {
        solver.solve(view(&shifted), &residual, &mut step)?;
        lambda.iter_mut().zip(&step).for_each(|(l, s)| *l += s);
        multiply(view(&values), &lambda, &mut product);
        share.complete(&mut product, 1);
        residual
            .iter_mut()
            .zip(rhs.iter().zip(&product))
            .for_each(|(r, (b, p))| *r = b - p);
        if residual.iter().all(|r| r.abs() < 1e-15 * largest) {
            break;
        }
    }
    Ok(lambda)
}
