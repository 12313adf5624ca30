//! Backend `faer-cg`: conjugate gradients, verified by the true residual.
//!
//! With the `stale` preconditioner the Cholesky factor of an earlier matrix serves the later
//! ones, until a solve takes too many iterations and the factor is renewed.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::matrix_free::conjugate_gradient::{
    CgError, CgParams, conjugate_gradient, conjugate_gradient_scratch,
};
use faer::{MatMut, MatRef, Par};

use crate::cholesky::{CholeskyFactor, Kind as FactorKind, Ordering};
use crate::faer_adapter::{Operator, Preconditioner};
use crate::matrix::{check_vector, rounding_floor};
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, OptionSpec, OptionValue, Options};
use crate::system::{ACCEPTED_RESIDUAL, Residuals, System};
use crate::{CsrView, LinearSolver, SolveError, SolveReport, SolverCounters, SpecError};

const NAME: &str = "faer-cg";
/// Restarts allowed when the recursive residual has drifted from the true one.
const MAX_RESTARTS: usize = 3;
/// The recursion aims lower than asked, so that the true residual rarely misses by rounding.
const AIM: f64 = 0.5;
/// Multiple of the rounding errors in b − A x below which no iteration can improve.
const FLOOR_FACTOR: f64 = 10.0;
/// A stale factor may cost this multiple of `refactor_above` before a solve gives it up.
const STALE_PATIENCE: usize = 4;

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "conjugate gradients (iterative), warm start, Jacobi or stale Cholesky factor",
    symmetries: &[Symmetry::PositiveDefinite],
    options: &[
        OptionSpec {
            key: "preconditioner",
            value: OptionValue::OneOf(&["jacobi", "stale", "none"]),
            default: "jacobi",
            meaning: "diagonal, Cholesky factor of an earlier matrix, or nothing",
        },
        OptionSpec {
            key: "tolerance",
            value: OptionValue::Positive,
            default: "1e-12",
            meaning: "true relative residual to reach",
        },
        OptionSpec {
            key: "max_iterations",
            value: OptionValue::Count,
            default: "10000",
            meaning: "iterations of one solve, over all restarts",
        },
        OptionSpec {
            key: "refactor_above",
            value: OptionValue::Count,
            default: "12",
            meaning: "stale: renew the factor after a solve with more iterations",
        },
    ],
    build,
};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Identity,
    Jacobi,
    Stale,
}

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let kind = match options.choice("preconditioner") {
        "stale" => Kind::Stale,
        "none" => Kind::Identity,
        _ => Kind::Jacobi,
    };
    Ok(Box::new(FaerCg {
        kind,
        tolerance: options.number("tolerance")?,
        max_iterations: options.count("max_iterations")?,
        refactor_above: options.count("refactor_above")?,
        system: System::new(NAME),
        factor: None,
        age: Age::Absent,
        memory: None,
        counters: SolverCounters::default(),
    }))
}

/// State of the factor used as preconditioner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Age {
    /// There are no valid values.
    Absent,
    /// It belongs to the current matrix.
    Current,
    /// It belongs to an earlier matrix.
    Old,
    /// It was too poor in the last solve.
    Worn,
}

struct FaerCg {
    kind: Kind,
    tolerance: f64,
    max_iterations: usize,
    refactor_above: usize,
    system: System,
    factor: Option<CholeskyFactor>,
    age: Age,
    memory: Option<MemBuffer>,
    counters: SolverCounters,
}

/// How one run of conjugate gradients ended.
struct Run {
    iterations: usize,
    broke_down: bool,
}

impl FaerCg {
    fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let Some(factor) = &mut self.factor else {
            return Err(SolveError::NotAnalysed {
                solver: NAME,
                missing: "analyse",
            });
        };
        self.age = Age::Absent;
        if let Err(error) = factor.factorise(matrix) {
            self.system.set_unready();
            return Err(error);
        }
        self.age = Age::Current;
        self.counters.factorisations += 1;
        Ok(())
    }

    /// One run from the current `x`.
    fn run(&mut self, matrix: CsrView<'_>, rhs: &[f64], x: &mut [f64], limit: usize) -> Run {
        let size = rhs.len();
        let operator = Operator(matrix);
        let preconditioner = match (self.kind, &self.factor) {
            (Kind::Jacobi, _) => Preconditioner::Jacobi(self.system.inverse_diagonal()),
            (Kind::Stale, Some(factor)) => Preconditioner::Factor { factor, size },
            _ => Preconditioner::Identity { size },
        };
        let memory = self.memory.get_or_insert_with(|| {
            MemBuffer::new(conjugate_gradient_scratch(
                &preconditioner,
                &operator,
                1,
                Par::Seq,
            ))
        });
        let parameters = CgParams {
            rel_tolerance: AIM * self.tolerance,
            max_iters: limit,
            ..CgParams::default()
        };
        let mut iterations = 0;
        let outcome = conjugate_gradient(
            MatMut::from_column_major_slice_mut(x, size, 1),
            &preconditioner,
            &operator,
            MatRef::from_column_major_slice(rhs, size, 1),
            parameters,
            |_| iterations += 1,
            Par::Seq,
            MemStack::new(memory),
        );
        let broke_down = matches!(
            outcome,
            Err(CgError::NonPositiveDefiniteOperator | CgError::NonPositiveDefinitePreconditioner)
        );
        Run {
            iterations,
            broke_down,
        }
    }

    /// Iterates until the true residual is small enough. Returns it with the iterations done.
    fn iterate(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<(Residuals, usize), SolveError> {
        let mut found = self.start(matrix, rhs, x);
        let mut best = x.to_vec();
        let (mut done, mut restarts) = (0, 0);
        while found.plain > self.tolerance && done < self.max_iterations {
            let run = self.run(matrix, rhs, x, self.patience(done));
            done += run.iterations;
            self.counters.iterations += run.iterations as u64;
            let reached = self.system.measure(matrix, x, rhs);
            if reached.plain < found.plain {
                best.copy_from_slice(x);
                found = reached;
            } else {
                x.copy_from_slice(&best);
            }
            if found.plain <= self.tolerance {
                break;
            }
            if self.kind == Kind::Stale && self.age != Age::Current {
                self.factorise(matrix)?;
                continue;
            }
            if run.broke_down {
                return Err(SolveError::Breakdown { iterations: done });
            }
            restarts += 1;
            if restarts > MAX_RESTARTS {
                break;
            }
        }
        self.accept(matrix, rhs, x, found, done)
            .map(|()| (found, done))
    }

    /// Starts from zero where the guess is worse than that.
    fn start(&mut self, matrix: CsrView<'_>, rhs: &[f64], x: &mut [f64]) -> Residuals {
        let guess = self.system.measure(matrix, x, rhs);
        if guess.plain <= 1.0 && x.iter().all(|value| value.is_finite()) {
            return guess;
        }
        x.fill(0.0);
        self.system.measure(matrix, x, rhs)
    }

    /// Iterations the next run may take.
    fn patience(&self, done: usize) -> usize {
        let left = self.max_iterations - done;
        if self.kind == Kind::Stale && self.age != Age::Current {
            left.min(STALE_PATIENCE * self.refactor_above.max(1))
        } else {
            left
        }
    }

    /// Accepts what reached the tolerance, or the rounding errors of the residual itself as
    /// long as these are small.
    fn accept(
        &self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &[f64],
        found: Residuals,
        iterations: usize,
    ) -> Result<(), SolveError> {
        let at_the_floor = || found.plain <= FLOOR_FACTOR * rounding_floor(matrix, x, rhs);
        if found.plain <= self.tolerance || (found.plain <= ACCEPTED_RESIDUAL && at_the_floor()) {
            return Ok(());
        }
        let advice = match self.kind {
            Kind::Stale => "check that the matrix is symmetric, or use `faer-llt`",
            _ => "raise max_iterations, use preconditioner=stale, or use `faer-llt`",
        };
        Err(SolveError::NotConverged {
            iterations,
            residual: found.plain,
            tolerance: self.tolerance,
            advice: advice.into(),
        })
    }
}

impl LinearSolver for FaerCg {
    fn name(&self) -> &'static str {
        NAME
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.factor = None;
        self.age = Age::Absent;
        self.memory = None;
        self.system.analyse(problem, BACKEND.symmetries)?;
        if self.kind == Kind::Stale {
            let factor = CholeskyFactor::analyse(problem, FactorKind::Llt, Ordering::Automatic)?;
            self.counters.factor_nonzeros = factor.prediction().nonzeros;
            self.counters.factor_bytes = factor.prediction().bytes;
            self.factor = Some(factor);
        }
        self.counters.analyses += 1;
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.system.refresh(matrix)?;
        self.system.check_diagonal()?;
        if self.kind == Kind::Stale {
            match self.age {
                Age::Absent | Age::Worn => self.factorise(matrix)?,
                Age::Current | Age::Old => self.age = Age::Old,
            }
        }
        self.counters.refreshes += 1;
        self.system.set_ready();
        Ok(())
    }

    fn solve(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<SolveReport, SolveError> {
        self.system.check_solve(matrix, rhs, x)?;
        check_vector("the initial guess", x)?;
        if rhs.iter().all(|value| value.abs() == 0.0) {
            x.fill(0.0);
        }
        let (found, iterations) = self.iterate(matrix, rhs, x)?;
        self.counters.solves += 1;
        if self.age == Age::Old && iterations > self.refactor_above {
            self.age = Age::Worn;
        }
        Ok(found.report(iterations))
    }

    fn counters(&self) -> &SolverCounters {
        &self.counters
    }
}

#[cfg(test)]
mod tests;
