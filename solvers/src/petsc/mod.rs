//! Backend `petsc`: the methods of PETSc, chosen by its own flags, alone or on several processes.
//!
//! PETSc is opened when a system is first analysed; without it all other backends work. Every
//! solver has its own table of options, so the flags of one system mean nothing to another. A
//! distributed problem (see [`crate::Partition`]) is solved by all processes of the team together:
//! each holds the rows of its own points, and solutions are complete everywhere.
//!
//! Each pass solves for a correction, A d = b − A x, from a residual that is measured afresh in
//! Rust. A start value, iterative refinement of a direct solution and a new start after a
//! recursion that drifted are the same thing in this form.

mod confined;
mod engine;
mod layout;
mod options;
mod outcome;
mod status;
mod team;

use perifrac_petsc_sys::Parked;
pub use perifrac_petsc_sys::{abort, finish};

use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, OptionSpec, OptionValue, Options};
use crate::system::{ACCEPTED_RESIDUAL, AT_THE_FLOOR, Residuals, System};
use crate::{CsrView, LinearSolver, Partition, SolveError, SolveReport, SolverCounters, SpecError};
pub(crate) use confined::others;
use engine::Engine;
use layout::Layout;
use options::Flags;
pub use status::{PetscStatus, petsc_status};
pub use team::petsc_team;

const NAME: &str = "petsc";
/// Passes allowed: the first solve and further ones where its residual drifted from the true one.
const MAX_PASSES: usize = 4;
/// Each pass aims lower than asked, so that the true residual rarely misses by rounding.
const AIM: f64 = 0.5;
/// Weakest reduction of the residual asked of a pass.
const WEAKEST_AIM: f64 = 0.1;
/// Multiple of the rounding errors in b − A x below which no pass can improve.
const FLOOR_FACTOR: f64 = 10.0;

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "PETSc, if installed: Krylov methods, multigrid, MUMPS, hypre; runs under MPI",
    symmetries: &[
        Symmetry::PositiveDefinite,
        Symmetry::QuasiDefinite,
        Symmetry::Indefinite,
        Symmetry::General,
    ],
    distributed: true,
    lattices_only: false,
    options: &[OptionSpec {
        key: "flags",
        value: OptionValue::Flags,
        default: "",
        meaning: "flags of PETSc, as in petsc:-ksp_type cg -pc_type hypre; what is not given is \
                  chosen by kind and size of the system",
    }],
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let flags = Flags::parse(options.choice("flags"));
    let tolerance = flags.tolerance()?;
    Ok(Box::new(Petsc {
        flags,
        tolerance,
        system: System::new(NAME).distributed(),
        work: None,
        counters: SolverCounters::default(),
    }))
}

/// What stands once a pattern is analysed.
struct Work {
    layout: Layout,
    partition: Option<Partition>,
    symmetry: Symmetry,
    /// The objects of PETSc.
    engine: Parked<Engine>,
    /// Whether the method is a factorisation.
    direct: bool,
    /// Residual and correction of the rows of this process.
    residual: Vec<f64>,
    correction: Vec<f64>,
    candidate: Vec<f64>,
}

struct Petsc {
    flags: Flags,
    tolerance: f64,
    system: System,
    work: Option<Work>,
    counters: SolverCounters,
}

impl Petsc {
    fn work(&mut self) -> Result<&mut Work, SolveError> {
        self.work.as_mut().ok_or(SolveError::NotAnalysed {
            solver: NAME,
            missing: "analyse",
        })
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

    /// Solves for one correction, which `work.candidate` then includes. Returns its iterations.
    fn pass(&mut self, x: &[f64], found: Residuals) -> Result<usize, SolveError> {
        let size = self.system.residual_norm();
        let aim = (AIM * self.tolerance / found.plain).min(WEAKEST_AIM);
        let Some(work) = &mut self.work else {
            return Ok(0);
        };
        work.layout.take(&self.system.residual, &mut work.residual);
        work.residual.iter_mut().for_each(|value| *value /= size);
        let (engine, rhs, x_own) = (&mut work.engine, &work.residual, &mut work.correction);
        let solved = engine::on_thread(&self.flags, |session| {
            engine.get(session).solve(&self.flags, aim, rhs, x_own)
        })?;
        self.counters.iterations += solved.iterations as u64;
        if solved.rebuilt {
            self.counters.factorisations += 1;
        }
        outcome::of_flags(&solved.missed)?;
        if let Some(failure) = solved.failure {
            outcome::of_solve(failure, self.counters.iterations as usize)?;
        }
        work.candidate.copy_from_slice(x);
        work.layout.add(size, &work.correction, &mut work.candidate);
        if let Some(partition) = &work.partition {
            partition.complete(&mut work.candidate, work.layout.per_point());
        }
        Ok(solved.iterations)
    }

    /// Passes until the true residual is small enough. Returns it with the iterations done.
    fn iterate(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<(Residuals, usize), SolveError> {
        let mut found = self.start(matrix, rhs, x);
        let mut done = 0;
        for pass in 0..MAX_PASSES {
            if found.plain <= self.tolerance || (pass > 0 && self.at_floor(matrix, rhs, x, found)) {
                break;
            }
            done += self.pass(x, found)?;
            let Some(work) = &self.work else {
                break;
            };
            let reached = self.system.measure(matrix, &work.candidate, rhs);
            let halved = reached.plain <= 0.5 * found.plain;
            if reached.plain < found.plain {
                x.copy_from_slice(&work.candidate);
                found = reached;
            } else {
                // The next pass, if any, needs the residual of what was kept.
                self.system.measure(matrix, x, rhs);
            }
            if !halved {
                break;
            }
        }
        self.accept(matrix, rhs, x, found, done)
            .map(|()| (found, done))
    }

    fn at_floor(&self, matrix: CsrView<'_>, rhs: &[f64], x: &[f64], found: Residuals) -> bool {
        found.plain <= FLOOR_FACTOR * self.system.rounding_floor(matrix, x, rhs)
    }

    /// Accepts what reached the tolerance or the rounding errors of the residual itself, and
    /// direct solutions by the same rule as the other direct backends.
    fn accept(
        &self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &[f64],
        found: Residuals,
        iterations: usize,
    ) -> Result<(), SolveError> {
        let direct = self.work.as_ref().is_some_and(|work| work.direct);
        if found.plain <= self.tolerance
            || (direct && found.plain <= ACCEPTED_RESIDUAL)
            || (found.plain <= AT_THE_FLOOR && self.at_floor(matrix, rhs, x, found))
        {
            return Ok(());
        }
        if direct {
            return Err(SolveError::Inaccurate {
                residual: found.plain,
                bar: ACCEPTED_RESIDUAL,
                refinements: iterations,
                advice: "the matrix is nearly singular or its symmetry is not as declared; \
                         prescribe enough values and limit the contrast of the stiffness",
            });
        }
        Err(SolveError::NotConverged {
            iterations,
            residual: found.plain,
            tolerance: self.tolerance,
            advice: "try another preconditioner (-pc_type gamg, hypre, lu), raise -ksp_max_it, or \
                     ask for less with -ksp_rtol"
                .into(),
        })
    }
}

impl LinearSolver for Petsc {
    fn name(&self) -> &'static str {
        NAME
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.work = None;
        self.system.analyse(problem, BACKEND.symmetries)?;
        let laid_out = Layout::of(problem);
        let known = laid_out.as_ref().map(|_| ()).map_err(Clone::clone);
        self.system.agree(known)?;
        let (layout, pattern) = laid_out?;
        let flags = &self.flags;
        let (engine, direct) = engine::on_thread(flags, |session| {
            let engine = Engine::new(session, flags, problem, &layout, &pattern)?;
            let direct = engine.is_direct();
            Ok((Parked::new(session, engine), direct))
        })?;
        self.counters.analyses += 1;
        self.work = Some(Work {
            partition: problem.partition.cloned(),
            symmetry: problem.symmetry,
            engine,
            direct,
            residual: vec![0.0; layout.rows()],
            correction: vec![0.0; layout.rows()],
            candidate: vec![0.0; problem.unknowns()],
            layout,
        });
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.system.refresh(matrix)?;
        if self.work()?.symmetry == Symmetry::PositiveDefinite {
            self.system.check_diagonal()?;
        }
        let flags = self.flags.clone();
        let work = self.work()?;
        let (values, engine) = (work.layout.values(&matrix), &mut work.engine);
        let set_up = engine::on_thread(&flags, |session| {
            engine.get(session).refresh(&flags, values)
        })?;
        outcome::of_set_up(&set_up)?;
        if let Some(size) = set_up.factor {
            self.counters.factor_nonzeros = size.nonzeros;
            self.counters.factor_bytes = size.bytes;
        }
        self.counters.refreshes += 1;
        self.counters.factorisations += 1;
        self.system.set_ready();
        Ok(())
    }

    fn begin_anew(&mut self) {
        let flags = self.flags.clone();
        if let Ok(work) = self.work() {
            let engine = &mut work.engine;
            // Without a session there is no work, so nothing is lost with the error.
            let _ = engine::on_thread(&flags, |session| {
                engine.get(session).begin_anew();
                Ok(())
            });
        }
    }

    fn solve_to(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport, SolveError> {
        self.system.check_solve(matrix, rhs, x)?;
        if self.work()?.direct {
            x.fill(0.0);
        }
        self.system.check_vector("the initial guess", x)?;
        if rhs.iter().all(|value| value.abs() == 0.0) {
            x.fill(0.0);
        }
        let own = self.tolerance;
        self.tolerance = own.max(tolerance);
        let solved = self.iterate(matrix, rhs, x);
        self.tolerance = own;
        let (found, iterations) = solved?;
        self.counters.solves += 1;
        Ok(found.report(iterations))
    }

    fn is_direct(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.direct)
    }

    fn counters(&self) -> &SolverCounters {
        &self.counters
    }
}

#[cfg(test)]
mod failure_tests;
#[cfg(test)]
mod tests;
