//! Backend `faer-cg`: the conjugate gradients of faer (Hestenes & Stiefel 1952).
//!
//! With the `stale` preconditioner the Cholesky factor of an earlier matrix serves the later
//! ones, until a solve takes too many iterations and the factor is renewed.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::matrix_free::IdentityPrecond;
use faer::matrix_free::conjugate_gradient::{
    CgError, CgParams, conjugate_gradient, conjugate_gradient_scratch,
};
use faer::{MatMut, MatRef, Par};

use super::driver::Krylov;
use super::faer_adapter::{Operator, Shared};
use super::options::options;
use super::{Cause, End, Method, Pass, Run};
use crate::preconditioner::{Demand, count, words};
use crate::problem::Symmetry;
use crate::registry::{Backend, OptionSpec, Options};
use crate::{LinearSolver, SpecError};

const DEMAND: Demand = Demand::DefiniteMatrix;
const WORDS: [&str; count(DEMAND)] = words(DEMAND);
const OPTIONS: [OptionSpec; 7] = options(&WORDS);

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: "faer-cg",
    summary: "conjugate gradients (iterative), warm start, choice of preconditioners",
    symmetries: &[Symmetry::PositiveDefinite],
    distributed: false,
    lattices_only: false,
    options: &OPTIONS,
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let method = Box::new(ConjugateGradient { memory: None });
    Ok(Box::new(Krylov::new(&BACKEND, DEMAND, method, options)?))
}

struct ConjugateGradient {
    memory: Option<MemBuffer>,
}

impl Method for ConjugateGradient {
    fn allocate(&mut self, unknowns: usize) {
        // Operator and preconditioner bring their own memory, so the identity asks for all.
        let identity = IdentityPrecond { dim: unknowns };
        let request = conjugate_gradient_scratch::<f64>(identity, identity, 1, Par::Seq);
        self.memory = Some(MemBuffer::new(request));
    }

    fn run(&mut self, pass: Pass<'_>, x: &mut [f64]) -> Run {
        let size = x.len();
        let mut iterations = 0;
        let Some(memory) = &mut self.memory else {
            let end = End::Limit;
            return Run { iterations, end };
        };
        let parameters = CgParams {
            abs_tolerance: pass.target,
            rel_tolerance: 0.0,
            max_iters: pass.limit,
            ..CgParams::default()
        };
        let outcome = conjugate_gradient(
            MatMut::from_column_major_slice_mut(x, size, 1),
            Shared::new(pass.preconditioner, size),
            Operator(pass.matrix),
            MatRef::from_column_major_slice(pass.rhs, size, 1),
            parameters,
            |_| iterations += 1,
            Par::Seq,
            MemStack::new(memory),
        );
        let end = match outcome {
            Ok(_) => End::Reached,
            Err(CgError::NoConvergence { .. }) => End::Limit,
            Err(_) => End::Broken(Cause::NotDefinite),
        };
        Run { iterations, end }
    }
}
