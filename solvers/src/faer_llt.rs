//! Backend `faer-llt`: sparse Cholesky factorisation with iterative refinement.

use crate::cholesky::{CholeskyFactor, Ordering};
use crate::matrix::rounding_floor;
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, OptionSpec, OptionValue, Options};
use crate::system::{ACCEPTED_RESIDUAL, Residuals, System};
use crate::{CsrView, LinearSolver, SolveError, SolveReport, SolverCounters, SpecError};

const NAME: &str = "faer-llt";
/// Residual above which the solution is refined.
/// Largest residual accepted where it is all rounding error of b − A x: large contrasts of the
/// coefficients do that to exact solutions, but a free body, whose solution is noise, exceeds it.
const AT_THE_FLOOR: f64 = 1e-3;
const REFINE_ABOVE: f64 = 1e-12;
/// Most steps of refinement.
const MAX_REFINEMENTS: usize = 2;

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "sparse Cholesky (direct), nested dissection from the coordinates",
    symmetries: &[Symmetry::PositiveDefinite],
    options: &[OptionSpec {
        key: "ordering",
        value: OptionValue::OneOf(&["auto", "nd", "amd"]),
        default: "auto",
        meaning: "nested dissection (needs coordinates) or minimum degree; auto: nd if it can",
    }],
    build,
};

fn build(options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let ordering = match options.choice("ordering") {
        "nd" => Ordering::NestedDissection,
        "amd" => Ordering::MinimumDegree,
        _ => Ordering::Automatic,
    };
    Ok(Box::new(FaerLlt {
        ordering,
        system: System::new(NAME),
        factor: None,
        counters: SolverCounters::default(),
        candidate: Vec::new(),
    }))
}

struct FaerLlt {
    ordering: Ordering,
    system: System,
    factor: Option<CholeskyFactor>,
    counters: SolverCounters,
    candidate: Vec<f64>,
}

impl FaerLlt {
    /// Adds corrections A⁻¹ r while they at least halve a residual that is too large.
    fn refine(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        mut found: Residuals,
    ) -> (Residuals, usize) {
        let Some(factor) = &mut self.factor else {
            return (found, 0);
        };
        let mut steps = 0;
        // At the rounding floor of b − A x a further step only replaces one rounding error by another.
        let improvable = |found: &Residuals, x: &[f64]| {
            found.plain > REFINE_ABOVE && found.plain > rounding_floor(matrix, x, rhs)
        };
        while steps < MAX_REFINEMENTS && improvable(&found, x) {
            steps += 1;
            self.candidate.clone_from(&self.system.residual);
            factor.solve_in_place(&mut self.candidate);
            for (candidate, x) in self.candidate.iter_mut().zip(x.iter()) {
                *candidate += x;
            }
            let refined = self.system.measure(matrix, &self.candidate, rhs);
            let halved = refined.plain <= 0.5 * found.plain;
            if refined.plain < found.plain {
                x.copy_from_slice(&self.candidate);
                found = refined;
            }
            if !halved {
                break;
            }
        }
        (found, steps)
    }
}

impl LinearSolver for FaerLlt {
    fn name(&self) -> &'static str {
        NAME
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.factor = None;
        self.system.analyse(problem, BACKEND.symmetries)?;
        let factor = CholeskyFactor::analyse(problem, self.ordering)?;
        self.counters.analyses += 1;
        self.counters.factor_nonzeros = factor.prediction().nonzeros;
        self.counters.factor_bytes = factor.prediction().bytes;
        self.factor = Some(factor);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.system.refresh(matrix)?;
        let Some(factor) = &mut self.factor else {
            return Err(SolveError::NotAnalysed {
                solver: NAME,
                missing: "analyse",
            });
        };
        factor.factorise(matrix)?;
        self.counters.refreshes += 1;
        self.counters.factorisations += 1;
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
        x.copy_from_slice(rhs);
        if let Some(factor) = &mut self.factor {
            factor.solve_in_place(x);
        }
        let first = self.system.measure(matrix, x, rhs);
        let (found, refinements) = self.refine(matrix, rhs, x, first);
        self.counters.refinements += refinements as u64;
        let backward_stable =
            || found.plain <= AT_THE_FLOOR && found.plain <= 10.0 * rounding_floor(matrix, x, rhs);
        if found.plain.is_nan() || (found.plain > ACCEPTED_RESIDUAL && !backward_stable()) {
            return Err(SolveError::Inaccurate {
                residual: found.plain,
                bar: ACCEPTED_RESIDUAL,
                refinements,
                advice: "the matrix is nearly singular, not symmetric or not the one refreshed; \
                         prescribe enough values and limit the contrast of the stiffness",
            });
        }
        self.counters.solves += 1;
        Ok(found.report(refinements))
    }

    fn counters(&self) -> &SolverCounters {
        &self.counters
    }
}

#[cfg(test)]
mod tests;
