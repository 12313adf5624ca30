//! Preconditioner `stale`: the factor of an earlier matrix, renewed when it serves too badly.

use super::{Preconditioner, PreconditionerWork};
use crate::cholesky::{CholeskyFactor, Kind, Ordering};
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError};

/// A factor may cost this multiple of `refactor_above` before a solve gives it up.
const PATIENCE: usize = 4;

pub(super) fn build(options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(Stale {
        refactor_above: options.count("refactor_above")?,
        factor: None,
        kind: Kind::Llt,
        age: Age::Absent,
        factorisations: 0,
    }))
}

/// State of the factor.
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

struct Stale {
    refactor_above: usize,
    factor: Option<CholeskyFactor<f64>>,
    kind: Kind,
    age: Age,
    factorisations: u64,
}

impl Preconditioner for Stale {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.factor = None;
        self.age = Age::Absent;
        self.kind = Kind::of(problem.symmetry);
        let factor = CholeskyFactor::analyse(problem, self.kind, Ordering::Automatic)?;
        self.factor = Some(factor);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        match self.age {
            Age::Absent | Age::Worn => self.renew(matrix),
            Age::Current | Age::Old => {
                self.age = Age::Old;
                Ok(())
            }
        }
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        correction.copy_from_slice(residual);
        if let Some(factor) = &mut self.factor {
            factor.solve_in_place(correction);
        }
    }

    fn patience(&self) -> Option<usize> {
        (self.age != Age::Current).then(|| PATIENCE * self.refactor_above)
    }

    fn renew(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.age = Age::Absent;
        if let Some(factor) = &mut self.factor {
            factor.factorise(matrix)?;
            self.factorisations += 1;
            self.age = Age::Current;
        }
        Ok(())
    }

    fn begin_anew(&mut self) {
        self.age = Age::Absent;
    }

    fn observe(&mut self, iterations: usize) {
        if self.age == Age::Old && iterations > self.refactor_above {
            self.age = Age::Worn;
        }
    }

    fn is_symmetric(&self) -> bool {
        self.kind == Kind::Llt
    }

    fn work(&self) -> PreconditionerWork {
        let size = self.factor.as_ref().map(CholeskyFactor::prediction);
        PreconditionerWork {
            factorisations: self.factorisations,
            nonzeros: size.map_or(0, |size| size.nonzeros),
            bytes: size.map_or(0, |size| size.bytes),
        }
    }
}
