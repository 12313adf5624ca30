//! Backend `minres`: the minimal residual method for symmetric matrices of either sign, with a
//! positive definite preconditioner (Paige & Saunders 1975, SIAM J. Numer. Anal. 12, 617).
//!
//! It minimises the residual in the norm of M⁻¹. The plain residual, which the driver asks for, is
//! carried along by its own recurrence, r_k = s_k² r_{k−1} − c_k φ̄_k u_{k+1}, with u the Lanczos
//! vectors: one more update and norm an iteration, but no restarts because the norms differ.

use super::driver::Krylov;
use super::options::options;
use super::vectors::{add_scaled, combine, scale, set_scaled};
use super::{Cause, End, Method, Pass, Run};
use crate::preconditioner::{Demand, count, words};
use crate::problem::Symmetry;
use crate::registry::{Backend, OptionSpec, Options};
use crate::{LinearSolver, SpecError, dot, interrupted, multiply, norm2};

const DEMAND: Demand = Demand::Definite;
const WORDS: [&str; count(DEMAND)] = words(DEMAND);
const OPTIONS: [OptionSpec; 7] = options(&WORDS);
/// Size, relative to that of the matrix, of what counts as zero.
const NEGLIGIBLE: f64 = 1e-15;
/// ‖A r‖ relative to ‖A‖ ‖r‖ at which r is a residual of least squares: beyond it the iterates of a
/// singular matrix run away.
const LEAST: f64 = 1e-13;

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: "minres",
    summary: "minimal residuals (iterative), for symmetric matrices with eigenvalues of any sign",
    symmetries: &[
        Symmetry::PositiveDefinite,
        Symmetry::QuasiDefinite,
        Symmetry::Indefinite,
    ],
    distributed: false,
    lattices_only: false,
    options: &OPTIONS,
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let method = Box::new(Minres::default());
    Ok(Box::new(Krylov::new(&BACKEND, DEMAND, method, options)?))
}

#[derive(Default)]
struct Minres {
    lanczos: Lanczos,
    /// The last two directions and the one to come.
    directions: [Vec<f64>; 3],
    residual: Vec<f64>,
}

/// The Lanczos process in the inner product of M⁻¹.
#[derive(Default)]
struct Lanczos {
    /// β u of the last step and of the one before.
    now: Vec<f64>,
    before: Vec<f64>,
    /// M⁻¹ u.
    v: Vec<f64>,
    product: Vec<f64>,
    beta: f64,
    beta_before: f64,
}

impl Lanczos {
    /// Starts from a residual; β is its norm in M⁻¹.
    fn begin(&mut self, pass: &mut Pass<'_>, size: f64) -> Result<(), Cause> {
        set_scaled(&mut self.now, 1.0 / size, pass.residual);
        self.before.fill(0.0);
        (self.beta, self.beta_before) = (0.0, 0.0);
        self.normalise(pass)
    }

    /// Sets v to M⁻¹ u and β to the norm of what `now` holds.
    fn normalise(&mut self, pass: &mut Pass<'_>) -> Result<(), Cause> {
        pass.preconditioner.apply(&self.now, &mut self.v);
        let square = dot(&self.now, &self.v);
        if !square.is_finite() {
            return Err(Cause::Overflow);
        }
        if square < 0.0 {
            return Err(Cause::PreconditionerNotDefinite);
        }
        self.beta_before = self.beta;
        self.beta = square.sqrt();
        if self.beta > 0.0 {
            scale(&mut self.v, 1.0 / self.beta);
        }
        Ok(())
    }

    /// The next step; `direction` takes the v it starts from. Returns α.
    fn step(&mut self, pass: &mut Pass<'_>, direction: &mut [f64]) -> Result<f64, Cause> {
        direction.copy_from_slice(&self.v);
        multiply(pass.matrix, &self.v, &mut self.product);
        if self.beta_before > 0.0 {
            let factor = -self.beta / self.beta_before;
            add_scaled(&mut self.product, factor, &self.before);
        }
        let alpha = dot(&self.v, &self.product);
        add_scaled(&mut self.product, -alpha / self.beta, &self.now);
        std::mem::swap(&mut self.before, &mut self.now);
        std::mem::swap(&mut self.now, &mut self.product);
        self.normalise(pass)?;
        Ok(alpha)
    }
}

/// The Givens rotations that make the tridiagonal matrix of the process triangular.
struct Rotations {
    cosine: f64,
    sine: f64,
    /// Entry above the diagonal that waits for the next rotation.
    delta_bar: f64,
    /// Second entry above the diagonal.
    epsilon: f64,
    /// Norm of the residual in M⁻¹.
    phi_bar: f64,
    /// Square of the Frobenius norm of the tridiagonal matrix.
    square: f64,
}

/// One column of the triangular matrix and the step along its direction.
struct Column {
    epsilon: f64,
    delta: f64,
    gamma: f64,
    step: f64,
}

impl Rotations {
    fn new(beta: f64) -> Self {
        Self {
            cosine: -1.0,
            sine: 0.0,
            delta_bar: 0.0,
            epsilon: 0.0,
            phi_bar: beta,
            square: 0.0,
        }
    }

    fn turn(&mut self, alpha: f64, beta: f64) -> Result<Column, Cause> {
        let (epsilon, first) = (self.epsilon, self.square <= 0.0);
        let delta = self.cosine * self.delta_bar + self.sine * alpha;
        let gamma_bar = self.sine * self.delta_bar - self.cosine * alpha;
        self.epsilon = self.sine * beta;
        self.delta_bar = -self.cosine * beta;
        self.square += alpha * alpha + 2.0 * beta * beta;
        let size = self.square.sqrt();
        let negligible = NEGLIGIBLE * size;
        // ‖A r‖ / ‖r‖ of the residual before this step.
        if gamma_bar.hypot(self.delta_bar) <= LEAST * size {
            return Err(if first {
                Cause::Singular
            } else {
                Cause::LeastSquares
            });
        }
        let gamma = gamma_bar.hypot(beta);
        if gamma <= negligible {
            return Err(Cause::Singular);
        }
        self.cosine = gamma_bar / gamma;
        self.sine = beta / gamma;
        let step = self.cosine * self.phi_bar;
        self.phi_bar *= self.sine;
        Ok(Column {
            epsilon,
            delta,
            gamma,
            step,
        })
    }
}

impl Minres {
    /// Iterates on A d = r from d = 0 and adds `size` d to x.
    fn iterate(
        &mut self,
        pass: &mut Pass<'_>,
        size: f64,
        x: &mut [f64],
        iterations: &mut usize,
    ) -> Result<End, Cause> {
        let target = pass.target / size;
        self.lanczos.begin(pass, size)?;
        self.directions.iter_mut().for_each(|w| w.fill(0.0));
        let mut rotations = Rotations::new(self.lanczos.beta);
        while *iterations < pass.limit && !interrupted() {
            let [older, old, new] = &mut self.directions;
            let alpha = self.lanczos.step(pass, new)?;
            let beta = self.lanczos.beta;
            let column = rotations.turn(alpha, beta)?;
            *iterations += 1;
            add_scaled(new, -column.epsilon, older);
            combine(new, 1.0 / column.gamma, -column.delta / column.gamma, old);
            add_scaled(x, size * column.step, new);
            self.directions.rotate_left(1);
            self.follow_residual(&rotations, beta);
            if norm2(&self.residual) <= target {
                return Ok(End::Reached);
            }
            // The space is closed, so this is the solution or the nearest that rounding allows.
            if beta <= NEGLIGIBLE * rotations.square.sqrt() {
                return Ok(End::Reached);
            }
        }
        Ok(End::Limit)
    }

    fn follow_residual(&mut self, rotations: &Rotations, beta: f64) {
        let Rotations {
            cosine,
            sine,
            phi_bar,
            ..
        } = rotations;
        let factor = if beta > 0.0 {
            -cosine * phi_bar / beta
        } else {
            0.0
        };
        combine(&mut self.residual, sine * sine, factor, &self.lanczos.now);
    }
}

impl Method for Minres {
    fn allocate(&mut self, unknowns: usize) {
        let Lanczos {
            now,
            before,
            v,
            product,
            ..
        } = &mut self.lanczos;
        let [first, second, third] = &mut self.directions;
        let residual = &mut self.residual;
        for vector in [now, before, v, product, first, second, third, residual] {
            *vector = vec![0.0; unknowns];
        }
    }

    fn run(&mut self, mut pass: Pass<'_>, x: &mut [f64]) -> Run {
        let size = norm2(pass.residual);
        set_scaled(&mut self.residual, 1.0 / size, pass.residual);
        let mut iterations = 0;
        let outcome = self.iterate(&mut pass, size, x, &mut iterations);
        let end = outcome.unwrap_or_else(End::Broken);
        Run { iterations, end }
    }
}
