//! Backend `bicgstab`: stabilised biconjugate gradients (van der Vorst 1992, SIAM J. Sci. Stat.
//! Comput. 13, 631), preconditioned from the right.
//!
//! Not that of faer: where r̂ᵀ A p vanishes it divides by zero and goes on with NaN until the limit
//! on the iterations, and it returns no sign of it. Here a vanishing scalar ends the run by name,
//! and the driver starts again from the best residual of the run: on the way to a breakdown, which on
//! matrices with eigenvalues of both signs is no rare thing, residuals grow. Every new start takes
//! another shadow.

use super::driver::Krylov;
use super::options::options;
use super::vectors::{add_scaled, combine, set_scaled};
use super::{Cause, End, Method, Pass, Run};
use crate::preconditioner::{Demand, count, words};
use crate::problem::Symmetry;
use crate::registry::{Backend, OptionSpec, Options};
use crate::{LinearSolver, SpecError, dot, interrupted, multiply, norm2};

const DEMAND: Demand = Demand::Any;
const WORDS: [&str; count(DEMAND)] = words(DEMAND);
const OPTIONS: [OptionSpec; 7] = options(&WORDS);
/// Cosine of an angle below which two vectors count as orthogonal.
const ORTHOGONAL: f64 = 1e-14;

/// Share of the least residual so far below which an x is kept.
const KEPT: f64 = 0.9;

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: "bicgstab",
    summary: "stabilised biconjugate gradients (iterative), for any matrix, short memory",
    symmetries: &[
        Symmetry::PositiveDefinite,
        Symmetry::QuasiDefinite,
        Symmetry::Indefinite,
        Symmetry::General,
    ],
    distributed: false,
    lattices_only: false,
    options: &OPTIONS,
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let method = Box::new(BiCgStab::default());
    Ok(Box::new(Krylov::new(&BACKEND, DEMAND, method, options)?))
}

#[derive(Default)]
struct BiCgStab {
    /// Residual over its first norm.
    r: Vec<f64>,
    /// Direction against which the residuals are made orthogonal.
    shadow: Vec<f64>,
    p: Vec<f64>,
    v: Vec<f64>,
    t: Vec<f64>,
    /// M⁻¹ times a vector.
    z: Vec<f64>,
    /// The x with the least residual of the run.
    best: Vec<f64>,
    /// That residual over the first.
    least: f64,
    /// Runs that broke down one after the other: where the next shadow comes from.
    broken: u64,
}

/// ⟨a, b⟩, unless the two are orthogonal or not finite.
fn product(a: &[f64], b: &[f64]) -> Result<f64, Cause> {
    let (product, size) = (dot(a, b), norm2(a) * norm2(b));
    if !product.is_finite() || !size.is_finite() {
        return Err(Cause::Overflow);
    }
    if product.abs() <= ORTHOGONAL * size {
        return Err(Cause::Orthogonal);
    }
    Ok(product)
}

impl BiCgStab {
    /// The residual itself; after a run that broke down with signs that differ each time.
    fn cast_shadow(&mut self) {
        self.shadow.copy_from_slice(&self.r);
        if self.broken == 0 {
            return;
        }
        let mut seed = self.broken;
        for value in &mut self.shadow {
            // Knuth's linear congruential generator: the same numbers on every machine.
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            if seed >> 62 == 0 {
                *value = -*value;
            }
        }
    }

    /// Keeps an x whose residual is clearly less than any before.
    fn keep(&mut self, residual: f64, x: &[f64]) {
        if residual <= KEPT * self.least {
            self.least = residual;
            self.best.copy_from_slice(x);
        }
    }

    /// Iterates on A d = r from d = 0 and adds `size` d to x.
    fn iterate(
        &mut self,
        pass: &mut Pass<'_>,
        size: f64,
        x: &mut [f64],
        iterations: &mut usize,
    ) -> Result<End, Cause> {
        let target = pass.target / size;
        let (mut rho, mut alpha, mut omega) = (1.0, 1.0, 1.0);
        self.p.fill(0.0);
        self.v.fill(0.0);
        while *iterations < pass.limit && !interrupted() {
            let next = product(&self.shadow, &self.r)?;
            let beta = next / rho * (alpha / omega);
            rho = next;
            add_scaled(&mut self.p, -omega, &self.v);
            combine(&mut self.p, beta, 1.0, &self.r);
            pass.preconditioner.apply(&self.p, &mut self.z);
            multiply(pass.matrix, &self.z, &mut self.v);
            alpha = rho / product(&self.shadow, &self.v)?;
            *iterations += 1;
            add_scaled(x, size * alpha, &self.z);
            add_scaled(&mut self.r, -alpha, &self.v);
            if norm2(&self.r) <= target {
                return Ok(End::Reached);
            }
            pass.preconditioner.apply(&self.r, &mut self.z);
            multiply(pass.matrix, &self.z, &mut self.t);
            omega = product(&self.t, &self.r)? / dot(&self.t, &self.t);
            add_scaled(x, size * omega, &self.z);
            add_scaled(&mut self.r, -omega, &self.t);
            let left = norm2(&self.r);
            if left <= target {
                return Ok(End::Reached);
            }
            self.keep(left, x);
        }
        Ok(End::Limit)
    }
}

impl Method for BiCgStab {
    fn allocate(&mut self, unknowns: usize) {
        let Self {
            r,
            shadow,
            p,
            v,
            t,
            z,
            best,
            least: _,
            broken: _,
        } = self;
        for vector in [r, shadow, p, v, t, z, best] {
            *vector = vec![0.0; unknowns];
        }
    }

    fn run(&mut self, mut pass: Pass<'_>, x: &mut [f64]) -> Run {
        let size = norm2(pass.residual);
        set_scaled(&mut self.r, 1.0 / size, pass.residual);
        self.cast_shadow();
        self.least = f64::INFINITY;
        self.keep(1.0, x);
        let mut iterations = 0;
        let outcome = self.iterate(&mut pass, size, x, &mut iterations);
        match outcome {
            Ok(_) => self.broken = 0,
            Err(_) => {
                self.broken += 1;
                x.copy_from_slice(&self.best);
            }
        }
        let end = outcome.unwrap_or_else(End::Broken);
        Run { iterations, end }
    }
}
