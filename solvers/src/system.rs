//! What every backend does alike: order of the stages, checks of the input, residuals.

use crate::interrupt;
use crate::matrix::{self, Fingerprint};
use crate::problem::{Problem, Symmetry};
use crate::repeated::RepeatedRows;
use crate::share::Share;
use crate::{CsrView, SolveError, SolveReport};

/// Relative residual above which no solution is handed out, unless rounding errors make it up.
pub(crate) const ACCEPTED_RESIDUAL: f64 = 1e-8;
/// Largest residual accepted where it is all rounding error of b − A x: large contrasts of the
/// coefficients do that to exact solutions, but a free body, whose solution is noise, exceeds it.
pub(crate) const AT_THE_FLOOR: f64 = 1e-3;

/// Book-keeping of the system a backend is working on.
#[derive(Debug)]
pub(crate) struct System {
    solver: &'static str,
    pattern: Option<Fingerprint>,
    share: Share,
    /// Whether the backend treats matrices that several processes share.
    distributed: bool,
    ready: bool,
    diagonal: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    /// Whether the points are a lattice, on which rows repeat.
    lattice: bool,
    distinct_rows: Option<RepeatedRows>,
    /// Last residual measured, b − A x.
    pub(crate) residual: Vec<f64>,
}

/// Norms of the residual relative to the right-hand side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Residuals {
    pub(crate) plain: f64,
    pub(crate) scaled: f64,
}

impl Residuals {
    const ZERO: Self = Self {
        plain: 0.0,
        scaled: 0.0,
    };

    pub(crate) fn report(self, iterations: usize) -> SolveReport {
        SolveReport {
            iterations,
            true_residual: self.plain,
            scaled_residual: self.scaled,
        }
    }
}

impl System {
    pub(crate) fn new(solver: &'static str) -> Self {
        Self {
            solver,
            pattern: None,
            share: Share::default(),
            distributed: false,
            ready: false,
            diagonal: Vec::new(),
            inverse_diagonal: Vec::new(),
            lattice: false,
            distinct_rows: None,
            residual: Vec::new(),
        }
    }

    /// The same for a backend that treats matrices shared by several processes.
    pub(crate) fn distributed(self) -> Self {
        Self {
            distributed: true,
            ..self
        }
    }

    /// Takes a pattern after checking it and its symmetry.
    pub(crate) fn analyse(
        &mut self,
        problem: &Problem<'_>,
        supported: &[Symmetry],
    ) -> Result<(), SolveError> {
        self.pattern = None;
        self.ready = false;
        problem.validate()?;
        let shared = problem.partition.is_none() || self.distributed;
        admit(self.solver, problem.symmetry, supported, shared)?;
        self.pattern = Some(Fingerprint::of(problem.pattern));
        self.share = Share::of(problem);
        self.lattice = problem.lattice.is_ok();
        self.residual = vec![0.0; problem.unknowns()];
        Ok(())
    }

    /// Checks new values and takes their diagonal. The caller then calls [`Self::set_ready`].
    pub(crate) fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.ready = false;
        let former = self.distinct_rows.take();
        let Some(expected) = self.pattern else {
            return self.missing("analyse");
        };
        let checked = interrupt::check().and_then(|()| same_pattern(matrix, expected));
        let same = former.filter(|_| checked.is_ok());
        self.distinct_rows = same.and_then(|mut rows| rows.refill(matrix).then_some(rows));
        // Of rows that are the same the first tells for all.
        let matters = |row| {
            let first = self
                .distinct_rows
                .as_ref()
                .is_none_or(|own| own.is_first(row));
            first && self.share.owns(row)
        };
        let checked = checked.and_then(|()| matrix::check_rows(matrix, matters));
        self.share.agree(checked)?;
        self.diagonal = match &self.distinct_rows {
            Some(rows) => rows.diagonal(),
            None => matrix::diagonal(matrix),
        };
        let invert = |value: &f64| if value.abs() > 0.0 { 1.0 / value } else { 1.0 };
        self.inverse_diagonal = self.diagonal.iter().map(invert).collect();
        Ok(())
    }

    /// Keeps the distinct rows of a matrix on a lattice for residuals: for backends that are asked to solve with the
    /// refreshed matrix only.
    pub(crate) fn keep_distinct_rows(&mut self, matrix: CsrView<'_>) {
        if self.lattice && self.distinct_rows.is_none() {
            self.distinct_rows = RepeatedRows::of(matrix);
        }
    }

    /// Declares that the factor or preconditioner of the refreshed values stands.
    pub(crate) fn set_ready(&mut self) {
        self.ready = true;
    }

    /// Declares that the factor was lost; the next solve needs a refresh.
    pub(crate) fn set_unready(&mut self) {
        self.ready = false;
    }

    /// Declares that the analysis failed after all; nothing works before the next one.
    pub(crate) fn forget(&mut self) {
        self.pattern = None;
        self.ready = false;
    }

    /// The diagonal must be positive for a positive definite matrix.
    pub(crate) fn check_diagonal(&self) -> Result<(), SolveError> {
        let negative = |row: &usize| self.share.owns(*row) && self.diagonal[*row] <= 0.0;
        let fault = (0..self.diagonal.len()).find(negative);
        self.share.agree(fault.map_or(Ok(()), |row| {
            Err(SolveError::NotPositiveDefinite {
                row,
                diagonal: self.diagonal[row],
            })
        }))
    }

    /// Checks everything given to a solve.
    pub(crate) fn check_solve(
        &self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &[f64],
    ) -> Result<(), SolveError> {
        let Some(pattern) = self.pattern else {
            return self.missing("analyse");
        };
        if !self.ready {
            return self.missing("refresh");
        }
        if matrix.rows() != pattern.rows || matrix.nnz() != pattern.nonzeros {
            let (expected, found) = (pattern.nonzeros, matrix.nnz());
            return Err(SolveError::PatternChanged { expected, found });
        }
        for (what, found) in [
            ("the right-hand side", rhs.len()),
            ("the solution", x.len()),
        ] {
            if found != pattern.rows {
                return Err(SolveError::Length {
                    what,
                    found,
                    expected: pattern.rows,
                });
            }
        }
        let checked = matrix::check_vector("the right-hand side", rhs);
        self.share.agree(interrupt::check().and(checked))
    }

    /// The error of the first process that has one, on every process.
    pub(crate) fn agree(&self, outcome: Result<(), SolveError>) -> Result<(), SolveError> {
        self.share.agree(outcome)
    }

    /// Refuses NaN and infinity in a vector.
    pub(crate) fn check_vector(
        &self,
        what: &'static str,
        vector: &[f64],
    ) -> Result<(), SolveError> {
        self.share.agree(matrix::check_vector(what, vector))
    }

    /// Norm of the last residual measured.
    pub(crate) fn residual_norm(&self) -> f64 {
        self.share
            .norm(self.residual.len(), |row| self.residual[row])
    }

    /// Size of the rounding errors no solution can go below, see [`matrix::rounding_floor`].
    pub(crate) fn rounding_floor(&self, matrix: CsrView<'_>, x: &[f64], rhs: &[f64]) -> f64 {
        let sizes = matrix::rounding_sizes(&matrix, x, rhs);
        let size = self.share.norm(rhs.len(), sizes);
        f64::EPSILON * size / self.share.norm(rhs.len(), |row| rhs[row])
    }

    /// Computes the residual of `x` afresh and keeps it.
    pub(crate) fn measure(&mut self, matrix: CsrView<'_>, x: &[f64], rhs: &[f64]) -> Residuals {
        let norm = |weight: &[f64], vector: &[f64]| {
            let rows = vector.len();
            if weight.is_empty() {
                return self.share.norm(rows, |row| vector[row]);
            }
            self.share.norm(rows, |row| weight[row] * vector[row])
        };
        let size = norm(&[], rhs);
        if size <= 0.0 {
            self.residual.fill(0.0);
            return Residuals::ZERO;
        }
        match &self.distinct_rows {
            Some(rows) => rows.residual(x, rhs, &mut self.residual),
            None => matrix::residual(matrix, x, rhs, &mut self.residual),
        }
        let weight = &self.inverse_diagonal;
        Residuals {
            plain: norm(&[], &self.residual) / size,
            scaled: norm(weight, &self.residual) / norm(weight, rhs),
        }
    }

    fn missing<T>(&self, stage: &'static str) -> Result<T, SolveError> {
        Err(SolveError::NotAnalysed {
            solver: self.solver,
            missing: stage,
        })
    }
}

fn same_pattern(matrix: CsrView<'_>, expected: Fingerprint) -> Result<(), SolveError> {
    if matrix.nnz() == expected.nonzeros && Fingerprint::of(matrix) == expected {
        return Ok(());
    }
    let (expected, found) = (expected.nonzeros, matrix.nnz());
    Err(SolveError::PatternChanged { expected, found })
}

/// Where a refused system can go.
fn elsewhere(symmetry: Symmetry) -> &'static str {
    match symmetry {
        Symmetry::QuasiDefinite => "; `faer-ldlt` and `auto` solve this one",
        Symmetry::Indefinite => "; `minres`, `gmres` and `faer-lu` solve this one",
        Symmetry::General => "; `gmres`, `bicgstab` and `faer-lu` solve this one",
        Symmetry::PositiveDefinite => "",
    }
}

/// Whether a solver of the `supported` kinds takes a system; `shared` tells whether it can share it as it
/// must.
pub(crate) fn admit(
    solver: &'static str,
    symmetry: Symmetry,
    supported: &[Symmetry],
    shared: bool,
) -> Result<(), SolveError> {
    let advice = if !supported.contains(&symmetry) {
        let elsewhere = elsewhere(symmetry);
        format!("it solves {} systems only{elsewhere}", list(supported))
    } else if !shared {
        "several processes share it, and this solver works in one; choose `petsc` or `auto`, or start one \
         process"
            .to_owned()
    } else {
        return Ok(());
    };
    Err(SolveError::Refused {
        solver,
        symmetry,
        advice,
    })
}

fn list(symmetries: &[Symmetry]) -> String {
    let names: Vec<String> = symmetries.iter().map(Symmetry::to_string).collect();
    names.join(" and ")
}

#[cfg(test)]
mod tests;
