//! What all Krylov backends share: restarts from the true residual, until that one is small.

use super::{Cause, End, Method, Pass, Run, advice};
use crate::interrupt;
use crate::matrix::{check_vector, rounding_floor};
use crate::preconditioner::{self, Demand, Preconditioner, PreconditionerInfo};
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, Options};
use crate::system::{AT_THE_FLOOR, Residuals, System};
use crate::{CsrView, LinearSolver, SolveError, SolveReport, SolverCounters, SpecError, norm2};

/// Restarts allowed when the recursive residual has drifted from the true one.
const MAX_RESTARTS: usize = 3;
/// The recursion aims lower than asked, so that the true residual rarely misses by rounding.
const AIM: f64 = 0.5;
/// Multiple of the rounding errors in b − A x below which no iteration can improve.
const FLOOR_FACTOR: f64 = 10.0;
/// Share of the residual that a run may leave when it breaks down and still be worth another one.
const WELL: f64 = 0.5;
/// A full basis that leaves more than this part of the residual is the last one.
const STALLED: f64 = 0.999;

/// A Krylov backend: a method, a preconditioner and the verification of their result.
pub(super) struct Krylov {
    backend: &'static Backend,
    demand: Demand,
    method: Box<dyn Method>,
    entry: &'static PreconditionerInfo,
    preconditioner: Box<dyn Preconditioner>,
    tolerance: f64,
    max_iterations: usize,
    symmetry: Symmetry,
    system: System,
    best: Vec<f64>,
    counters: SolverCounters,
}

/// State of one solve.
struct Progress {
    found: Residuals,
    done: usize,
    restarts: usize,
    /// The preconditioner was renewed: it now belongs to this matrix.
    renewed: bool,
    /// Why the iteration gave up, if it did.
    fault: Option<Fault>,
}

#[derive(Clone, Copy)]
enum Fault {
    /// A full basis gained nothing.
    Full,
    /// Restarts do not help the true residual any more.
    Drifted,
    Broken(Cause),
}

impl Fault {
    fn remedy(self) -> &'static str {
        match self {
            Self::Full => "raise restart",
            _ => "check that the matrix is as described and not singular",
        }
    }
}

impl Krylov {
    /// The solver of a backend with the options of `super::options`.
    pub(super) fn new(
        backend: &'static Backend,
        demand: Demand,
        method: Box<dyn Method>,
        options: &Options<'_>,
    ) -> Result<Self, SpecError> {
        let entry = preconditioner::find(options)?;
        Ok(Self {
            backend,
            demand,
            method,
            entry,
            preconditioner: preconditioner::build(entry, options)?,
            tolerance: options.number("tolerance")?,
            max_iterations: options.count("max_iterations")?,
            symmetry: Symmetry::General,
            system: System::new(backend.name),
            best: Vec::new(),
            counters: SolverCounters::default(),
        })
    }

    /// Whether the table says that a preconditioner suits the problem and the method.
    fn suits(&self, entry: &PreconditionerInfo, symmetry: Symmetry) -> bool {
        let accepted = match self.demand {
            Demand::Any => entry.symmetries,
            Demand::Definite | Demand::DefiniteMatrix => entry.definite,
        };
        accepted.contains(&symmetry)
    }

    /// Analyses the preconditioner, unless the method or the problem forbids it.
    fn analyse_preconditioner(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        if !self.suits(self.entry, problem.symmetry) {
            return Err(self.refusal(problem.symmetry));
        }
        self.preconditioner.analyse(problem)?;
        if self.demand != Demand::Any && !self.preconditioner.is_symmetric() {
            return Err(self.refusal(problem.symmetry));
        }
        if self.preconditioner.is_variable() && !self.method.is_flexible() {
            return Err(SolveError::Refused {
                solver: self.backend.name,
                symmetry: problem.symmetry,
                advice:
                    "inner iterations change the preconditioner between its applications; choose \
                         `fgmres`, or inner=1"
                        .into(),
            });
        }
        Ok(())
    }

    fn refusal(&self, symmetry: Symmetry) -> SolveError {
        let names: Vec<&str> = preconditioner::PRECONDITIONERS
            .iter()
            .filter(|entry| self.suits(entry, symmetry))
            .map(|entry| entry.name)
            .collect();
        let need = match self.demand {
            Demand::Any => "",
            _ => ", and this method needs a positive definite one (`gmres` does not)",
        };
        SolveError::Refused {
            solver: self.backend.name,
            symmetry,
            advice: format!(
                "preconditioner={} does not suit it{need}; choose one of {}",
                self.entry.name,
                names.join(", ")
            ),
        }
    }

    /// Takes over what the preconditioner did and holds.
    fn count_work(&mut self) {
        let work = self.preconditioner.work();
        self.counters.factorisations = work.factorisations;
        self.counters.factor_nonzeros = work.nonzeros;
        self.counters.factor_bytes = work.bytes;
    }

    /// Starts from zero where the guess is worse than that.
    fn start(&mut self, matrix: CsrView<'_>, rhs: &[f64], x: &mut [f64]) -> Progress {
        let mut found = self.system.measure(matrix, x, rhs);
        if found.plain.is_nan() || found.plain > 1.0 {
            x.fill(0.0);
            found = self.system.measure(matrix, x, rhs);
        }
        self.best.copy_from_slice(x);
        Progress {
            found,
            done: 0,
            restarts: 0,
            renewed: false,
            fault: None,
        }
    }

    /// Iterates, and refuses what is not good enough.
    fn verified(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<Progress, SolveError> {
        let progress = self.iterate(matrix, rhs, x)?;
        self.accept(matrix, rhs, x, &progress)?;
        Ok(progress)
    }

    /// Iterates until the true residual is small enough or nothing helps.
    fn iterate(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<Progress, SolveError> {
        let target = AIM * self.tolerance * norm2(rhs);
        let mut progress = self.start(matrix, rhs, x);
        while progress.found.plain > self.tolerance && progress.done < self.max_iterations {
            let limit = limit(self.max_iterations, self.patience(&progress), &progress);
            let pass = Pass {
                matrix,
                preconditioner: self.preconditioner.as_mut(),
                rhs,
                residual: &self.system.residual,
                target,
                limit,
            };
            let run = self.method.run(pass, x);
            interrupt::check()?;
            let gain = self.take(matrix, rhs, x, run, &mut progress);
            if progress.found.plain <= self.tolerance {
                break;
            }
            if progress.done >= self.max_iterations {
                // In exact arithmetic so many iterations would have solved it.
                let in_vain = run.iterations >= x.len() && (gain.is_nan() || gain >= 1.0);
                progress.fault = in_vain.then_some(Fault::Drifted);
                break;
            }
            if !self.goes_on(matrix, run.end, gain, &mut progress)? {
                break;
            }
        }
        Ok(progress)
    }

    /// Iterations of this solve after which what is held is renewed.
    fn patience(&self, progress: &Progress) -> Option<usize> {
        self.preconditioner.patience().filter(|_| !progress.renewed)
    }

    /// Keeps the better of the old and the new x. Returns the part of the residual that is left.
    fn take(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        run: Run,
        progress: &mut Progress,
    ) -> f64 {
        progress.done += run.iterations;
        self.counters.iterations += run.iterations as u64;
        let reached = self.system.measure(matrix, x, rhs);
        let gain = reached.plain / progress.found.plain;
        if gain < 1.0 {
            self.best.copy_from_slice(x);
            progress.found = reached;
        } else {
            x.copy_from_slice(&self.best);
            self.system.measure(matrix, x, rhs);
        }
        gain
    }

    /// Decides what follows a run that missed the tolerance; renews what was kept too long.
    fn goes_on(
        &mut self,
        matrix: CsrView<'_>,
        end: End,
        gain: f64,
        progress: &mut Progress,
    ) -> Result<bool, SolveError> {
        if let Some(patience) = self.patience(progress) {
            let drifted = end == End::Reached && gain < 1.0;
            let patient = end == End::Full && gain <= STALLED;
            if !(drifted || patient) || progress.done >= patience {
                self.renew(matrix)?;
                progress.renewed = true;
                return Ok(true);
            }
        }
        progress.fault = match end {
            End::Broken(cause) if cause != Cause::Orthogonal || gain.is_nan() => {
                Some(Fault::Broken(cause))
            }
            End::Broken(_) if gain <= WELL => None,
            End::Full if gain <= STALLED => None,
            End::Full => Some(Fault::Full),
            _ if progress.restarts < MAX_RESTARTS => {
                progress.restarts += 1;
                None
            }
            End::Broken(cause) => Some(Fault::Broken(cause)),
            End::Reached | End::Limit => Some(Fault::Drifted),
        };
        Ok(progress.fault.is_none())
    }

    fn renew(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let renewed = self.preconditioner.renew(matrix);
        self.count_work();
        renewed.inspect_err(|_| self.system.set_unready())
    }

    /// Accepts what reached the tolerance, or the rounding errors of the residual itself as
    /// long as these are small.
    fn accept(
        &self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &[f64],
        progress: &Progress,
    ) -> Result<(), SolveError> {
        let (residual, iterations) = (progress.found.plain, progress.done);
        let at_the_floor = || residual <= FLOOR_FACTOR * rounding_floor(matrix, x, rhs);
        if residual <= self.tolerance || (residual <= AT_THE_FLOOR && at_the_floor()) {
            return Ok(());
        }
        let (method, tolerance) = (self.backend.name, self.tolerance);
        Err(match progress.fault {
            Some(Fault::Broken(cause)) => SolveError::Breakdown {
                method,
                iterations,
                cause: cause.describe(),
                advice: advice::on_breakdown(cause, self.symmetry),
            },
            Some(fault) => SolveError::Stagnated {
                method,
                iterations,
                residual,
                tolerance,
                advice: self.advice(fault.remedy()),
            },
            None => SolveError::NotConverged {
                iterations,
                residual,
                tolerance,
                advice: self.advice("raise max_iterations"),
            },
        })
    }

    /// Remedy for slow convergence; `first` is the nearest one.
    fn advice(&self, first: &str) -> String {
        advice::on_slowness(first, self.entry.name, self.demand, self.symmetry)
    }
}

/// Iterations the next run may take.
fn limit(most: usize, patience: Option<usize>, progress: &Progress) -> usize {
    let left = most - progress.done;
    patience.map_or(left, |patience| {
        left.min(patience.saturating_sub(progress.done).max(1))
    })
}

impl LinearSolver for Krylov {
    fn name(&self) -> &'static str {
        self.backend.name
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.system.analyse(problem, self.backend.symmetries)?;
        self.analyse_preconditioner(problem)
            .inspect_err(|_| self.system.forget())?;
        self.symmetry = problem.symmetry;
        self.method.allocate(problem.unknowns());
        self.best = vec![0.0; problem.unknowns()];
        self.counters.analyses += 1;
        self.count_work();
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.system.refresh(matrix)?;
        if self.symmetry == Symmetry::PositiveDefinite {
            self.system.check_diagonal()?;
        }
        let refreshed = self.preconditioner.refresh(matrix);
        self.count_work();
        refreshed?;
        self.counters.refreshes += 1;
        self.system.set_ready();
        Ok(())
    }

    fn begin_anew(&mut self) {
        self.preconditioner.begin_anew();
    }

    fn solve_to(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport, SolveError> {
        self.system.check_solve(matrix, rhs, x)?;
        check_vector("the initial guess", x)?;
        if rhs.iter().all(|value| value.abs() == 0.0) {
            x.fill(0.0);
        }
        let own = self.tolerance;
        self.tolerance = own.max(tolerance);
        let solved = self.verified(matrix, rhs, x);
        self.tolerance = own;
        let progress = solved?;
        self.counters.solves += 1;
        // Fewer iterations than usual would tell nothing of the preconditioner.
        if tolerance <= own {
            self.preconditioner.observe(progress.done);
        }
        Ok(progress.found.report(progress.done))
    }

    fn is_direct(&self) -> bool {
        false
    }

    fn counters(&self) -> &SolverCounters {
        &self.counters
    }
}
