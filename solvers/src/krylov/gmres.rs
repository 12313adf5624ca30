//! Backends `gmres` and `fgmres`: restarted generalised minimal residuals, preconditioned from the
//! right, so that the residual it minimises is the true one (Saad & Schultz 1986; the flexible
//! variant, whose preconditioner may change from step to step, Saad 1993, SIAM J. Sci. Comput. 14,
//! 461).
//!
//! Modified Gram-Schmidt, done twice where the first pass cancels much.

use super::driver::Krylov;
use super::hessenberg::Hessenberg;
use super::options::options_with_restart;
use super::vectors::{add_scaled, scale, set_scaled};
use super::{Cause, End, Method, Pass, Run};
use crate::preconditioner::{Demand, Preconditioner, count, words};
use crate::problem::Symmetry;
use crate::registry::{Backend, OptionSpec, Options};
use crate::{LinearSolver, SpecError, dot, interrupted, multiply, norm2};

const DEMAND: Demand = Demand::Any;
const WORDS: [&str; count(DEMAND)] = words(DEMAND);
const OPTIONS: [OptionSpec; 8] = options_with_restart(&WORDS);
const SYMMETRIES: &[Symmetry] = &[
    Symmetry::PositiveDefinite,
    Symmetry::QuasiDefinite,
    Symmetry::Indefinite,
    Symmetry::General,
];
/// Part of a vector that must survive the projection, or else it is projected again.
const CANCELLED: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Part of a vector below which nothing but rounding survived.
const CLOSED: f64 = 1e-14;

/// The entry of the plain variant in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: "gmres",
    summary: "generalised minimal residuals (iterative, restarted), for any matrix",
    symmetries: SYMMETRIES,
    distributed: false,
    lattices_only: false,
    options: &OPTIONS,
    build: build_plain,
};

/// The entry of the flexible variant in the table.
pub(crate) const FLEXIBLE_BACKEND: Backend = Backend {
    name: "fgmres",
    summary: "gmres that lets the preconditioner vary; twice the memory",
    symmetries: SYMMETRIES,
    distributed: false,
    lattices_only: false,
    options: &OPTIONS,
    build: build_flexible,
};

fn build_plain(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    build(&BACKEND, false, options)
}

fn build_flexible(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    build(&FLEXIBLE_BACKEND, true, options)
}

fn build(
    backend: &'static Backend,
    flexible: bool,
    options: &Options<'_>,
) -> Result<Box<dyn LinearSolver>, SpecError> {
    let method = Box::new(Gmres {
        flexible,
        restart: options.count("restart")?,
        basis: Vec::new(),
        corrections: Vec::new(),
        small: Hessenberg::default(),
    });
    Ok(Box::new(Krylov::new(backend, DEMAND, method, options)?))
}

struct Gmres {
    flexible: bool,
    restart: usize,
    /// Orthonormal basis V, one vector more than iterations.
    basis: Vec<Vec<f64>>,
    /// Z = M⁻¹ V if flexible, else two work vectors.
    corrections: Vec<Vec<f64>>,
    small: Hessenberg,
}

impl Gmres {
    /// Extends the basis by A M⁻¹ v.
    fn extend(&mut self, pass: &mut Pass<'_>, step: usize) -> Result<(), Cause> {
        let slot = if self.flexible { step } else { 0 };
        let (old, new) = self.basis.split_at_mut(step + 1);
        let (correction, next) = (&mut self.corrections[slot], &mut new[0]);
        pass.preconditioner.apply(&old[step], correction);
        multiply(pass.matrix, correction, next);
        let column = self.small.column(step);
        let before = norm2(next);
        let after = orthogonalise(old, next, column, before);
        if !after.is_finite() {
            return Err(Cause::Overflow);
        }
        let closed = after <= CLOSED * before;
        column[step + 1] = if closed { 0.0 } else { after };
        if !closed {
            scale(next, 1.0 / after);
        }
        if self.small.push(step) {
            Ok(())
        } else {
            Err(Cause::Singular)
        }
    }

    /// Adds the combination of the first `used` directions to x.
    fn update(&mut self, preconditioner: &mut dyn Preconditioner, used: usize, x: &mut [f64]) {
        let coefficients = self.small.solve(used);
        if self.flexible {
            for (coefficient, correction) in coefficients.iter().zip(&self.corrections) {
                add_scaled(x, *coefficient, correction);
            }
            return;
        }
        let (work, rest) = self.corrections.split_at_mut(1);
        let (sum, correction) = (&mut work[0], &mut rest[0]);
        sum.fill(0.0);
        for (coefficient, vector) in coefficients.iter().zip(&self.basis) {
            add_scaled(sum, *coefficient, vector);
        }
        preconditioner.apply(sum, correction);
        add_scaled(x, 1.0, correction);
    }
}

/// Makes `next` orthogonal to `old`, adds the parts removed to `column` (set to zero first) and
/// returns the norm that is left.
fn orthogonalise(old: &[Vec<f64>], next: &mut [f64], column: &mut [f64], before: f64) -> f64 {
    column.fill(0.0);
    let mut project = || {
        for (entry, vector) in column.iter_mut().zip(old) {
            let part = dot(next, vector);
            add_scaled(next, -part, vector);
            *entry += part;
        }
        norm2(next)
    };
    let after = project();
    if after > CANCELLED * before {
        return after;
    }
    project()
}

impl Method for Gmres {
    fn is_flexible(&self) -> bool {
        self.flexible
    }

    fn allocate(&mut self, unknowns: usize) {
        let steps = self.restart.min(unknowns).max(1);
        // Each vector on its own, so that memory which is never used is never touched.
        let vectors = |number: usize| (0..number).map(|_| vec![0.0; unknowns]).collect();
        self.basis = vectors(steps + 1);
        self.corrections = vectors(if self.flexible { steps } else { 2 });
        self.small.allocate(steps);
    }

    fn run(&mut self, mut pass: Pass<'_>, x: &mut [f64]) -> Run {
        let size = norm2(pass.residual);
        set_scaled(&mut self.basis[0], 1.0 / size, pass.residual);
        self.small.begin(size);
        let most = pass.limit.min(self.basis.len() - 1);
        let (mut iterations, mut end) = (0, End::Full);
        while iterations < most && !interrupted() {
            if let Err(cause) = self.extend(&mut pass, iterations) {
                end = End::Broken(cause);
                break;
            }
            iterations += 1;
            if self.small.residual(iterations) <= pass.target {
                end = End::Reached;
                break;
            }
        }
        self.update(pass.preconditioner, iterations, x);
        Run { iterations, end }
    }
}
