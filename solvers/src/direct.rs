//! What the direct backends share: a kept factor and iterative refinement.

use crate::cholesky::{CholeskyFactor, Kind, Ordering};
use crate::matrix::rounding_floor;
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, OptionSpec, OptionValue, Options};
use crate::system::{ACCEPTED_RESIDUAL, AT_THE_FLOOR, Residuals, System};
use crate::{CsrView, LinearSolver, SolveError, SolveReport, SolverCounters};

/// Residual above which the solution is refined.
const REFINE_ABOVE: f64 = 1e-12;
/// Most steps of refinement.
const MAX_REFINEMENTS: usize = 2;

/// The option for the ordering.
pub(crate) const ORDERING: OptionSpec = OptionSpec {
    key: "ordering",
    value: OptionValue::OneOf(&["auto", "nd", "sweep", "amd"]),
    default: "auto",
    meaning: "nested dissection or sweep along the longest axis (both need coordinates), or \
              minimum degree; auto: nd, sweep if cheaper, amd without coordinates",
};

/// A factor of one pattern with all the memory it needs.
pub(crate) trait Factor: Send {
    /// Numeric factorisation. After an error the old factor is lost.
    fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError>;

    /// Overwrites a right-hand side by the solution.
    fn solve_in_place(&mut self, x: &mut [f64]);

    /// Stored entries and bytes; zero if not known.
    fn size(&self) -> (u64, u64);

    /// Why the matrix cannot be solved with the factor, if that can be told.
    fn explain(&self, _matrix: CsrView<'_>) -> Option<SolveError> {
        None
    }
}

impl Factor for CholeskyFactor<f64> {
    fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        Self::factorise(self, matrix)
    }

    fn solve_in_place(&mut self, x: &mut [f64]) {
        Self::solve_in_place(self, x);
    }

    fn size(&self) -> (u64, u64) {
        (self.prediction().nonzeros, self.prediction().bytes)
    }
}

/// Symbolic factorisation of a backend.
type Analyse = Box<dyn Fn(&Problem<'_>) -> Result<Box<dyn Factor>, SolveError> + Send>;

/// A direct solver: factor, substitution, refinement with the true residual.
pub(crate) struct Direct {
    name: &'static str,
    symmetries: &'static [Symmetry],
    symbolic: Analyse,
    system: System,
    factor: Option<Box<dyn Factor>>,
    counters: SolverCounters,
    candidate: Vec<f64>,
}

impl Direct {
    /// A Cholesky solver of this name, for these systems, with the options of [`ORDERING`].
    pub(crate) fn cholesky(backend: &'static Backend, kind: Kind, options: &Options<'_>) -> Self {
        let ordering = match options.choice(ORDERING.key) {
            "nd" => Ordering::NestedDissection,
            "sweep" => Ordering::Sweep,
            "amd" => Ordering::MinimumDegree,
            _ => Ordering::Automatic,
        };
        let symbolic = move |problem: &Problem<'_>| -> Result<Box<dyn Factor>, SolveError> {
            Ok(Box::new(CholeskyFactor::<f64>::analyse(
                problem, kind, ordering,
            )?))
        };
        Self::new(backend, Box::new(symbolic))
    }

    /// A solver of this name, for these systems, with this symbolic factorisation.
    pub(crate) fn new(backend: &'static Backend, symbolic: Analyse) -> Self {
        Self {
            name: backend.name,
            symmetries: backend.symmetries,
            symbolic,
            system: System::new(backend.name),
            factor: None,
            counters: SolverCounters::default(),
            candidate: Vec::new(),
        }
    }

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

impl LinearSolver for Direct {
    fn name(&self) -> &'static str {
        self.name
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.factor = None;
        self.system.analyse(problem, self.symmetries)?;
        let factor = (self.symbolic)(problem)?;
        self.counters.analyses += 1;
        (self.counters.factor_nonzeros, self.counters.factor_bytes) = factor.size();
        self.factor = Some(factor);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.system.refresh(matrix)?;
        let Some(factor) = &mut self.factor else {
            return Err(SolveError::NotAnalysed {
                solver: self.name,
                missing: "analyse",
            });
        };
        factor.factorise(matrix)?;
        self.system.keep_distinct_rows(matrix);
        self.counters.refreshes += 1;
        self.counters.factorisations += 1;
        self.system.set_ready();
        Ok(())
    }

    fn solve_to(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        _tolerance: f64,
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
            let reason = self.factor.as_ref().and_then(|own| own.explain(matrix));
            return Err(reason.unwrap_or(SolveError::Inaccurate {
                residual: found.plain,
                bar: ACCEPTED_RESIDUAL,
                refinements,
                advice: "the matrix is nearly singular, not symmetric or not the one refreshed; \
                         prescribe enough values and limit the contrast of the stiffness",
            }));
        }
        self.counters.solves += 1;
        Ok(found.report(refinements))
    }

    fn is_direct(&self) -> bool {
        true
    }

    fn counters(&self) -> &SolverCounters {
        &self.counters
    }
}
