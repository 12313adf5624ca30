//! Backend `auto`: chooses by size, stencil width and dimension, then hands over.
//!
//! The limits come from timings of wide-stencil matrices: a Cholesky factor with nested
//! dissection wins up to some ten thousand unknowns in 2-D, later if rows are short and sooner
//! in 3-D, where separators are surfaces.

use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, Options};
use crate::{
    CsrView, LinearSolver, SolveError, SolveReport, SolverCounters, SolverSpec, SpecError,
};

const NAME: &str = "auto";
/// Rows up to this many entries are those of one-hop stencils.
const NARROW_ROW: f64 = 25.0;
/// Above the direct limit, a stale factor pays up to this multiple of it.
const STALE_RANGE: usize = 4;

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "chooses a backend from the size, the stencil and the dimension",
    symmetries: &[Symmetry::PositiveDefinite, Symmetry::QuasiDefinite],
    options: &[],
    build,
};

/// The backend chosen for a problem, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// What to build.
    pub spec: SolverSpec,
    /// Why, in one sentence.
    pub reason: String,
}

/// Chooses a backend for a problem.
///
/// # Errors
/// [`SolveError::Refused`] for indefinite and general systems.
pub fn choose(problem: &Problem<'_>) -> Result<Choice, SolveError> {
    let (unknowns, width) = (problem.unknowns(), problem.entries_per_row());
    let dimension = problem
        .coordinates
        .map_or(2, |coordinates| coordinates.dimension);
    match problem.symmetry {
        Symmetry::PositiveDefinite => choose_by_size(unknowns, width, dimension),
        Symmetry::QuasiDefinite => choose_quasi_definite(unknowns, width),
        symmetry @ (Symmetry::Indefinite | Symmetry::General) => Err(SolveError::Refused {
            solver: NAME,
            symmetry,
            advice: "write it as a quasi-definite system, split it into positive definite ones \
                     (staggered), or choose `gmres` or `faer-lu` by name"
                .into(),
        }),
    }
}

/// Chooses a backend for a quasi-definite system of which only the size is known.
///
/// # Errors
/// None in practice: the specification chosen is valid.
pub fn choose_quasi_definite(unknowns: usize, width: f64) -> Result<Choice, SolveError> {
    let spec = "faer-ldlt"
        .parse()
        .map_err(|error: SpecError| invalid(&error))?;
    let reason = format!(
        "{unknowns} unknowns with {width:.0} entries a row, quasi-definite: LDLT needs no pivoting"
    );
    Ok(Choice { spec, reason })
}

/// Chooses a backend for a positive definite system of which only the size is known.
///
/// # Errors
/// None in practice: the specifications chosen from are valid.
pub fn choose_by_size(unknowns: usize, width: f64, dimension: usize) -> Result<Choice, SolveError> {
    let limit = direct_limit(width, dimension);
    let (text, comparison) = if unknowns <= limit {
        ("faer-llt", format!("at most {limit}: a factor is cheapest"))
    } else if unknowns <= STALE_RANGE * limit {
        (
            "faer-cg:preconditioner=stale",
            format!("above {limit}: a kept factor is cheapest"),
        )
    } else {
        (
            "faer-cg:preconditioner=jacobi",
            format!("far above {limit}: a factor is too large"),
        )
    };
    let spec = text.parse().map_err(|error: SpecError| invalid(&error))?;
    let reason = format!("{unknowns} unknowns with {width:.0} entries a row, {comparison}");
    Ok(Choice { spec, reason })
}

fn direct_limit(width: f64, dimension: usize) -> usize {
    match (width <= NARROW_ROW, dimension == 3) {
        (true, false) => 150_000,
        (false, false) => 50_000,
        (true, true) => 40_000,
        (false, true) => 15_000,
    }
}

fn invalid(error: &SpecError) -> SolveError {
    SolveError::InvalidProblem {
        reason: error.to_string(),
    }
}

fn build(_options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    Ok(Box::new(Auto {
        chosen: None,
        idle: SolverCounters::default(),
    }))
}

struct Auto {
    chosen: Option<Box<dyn LinearSolver>>,
    idle: SolverCounters,
}

impl Auto {
    fn chosen(&mut self) -> Result<&mut Box<dyn LinearSolver>, SolveError> {
        let missing = SolveError::NotAnalysed {
            solver: NAME,
            missing: "analyse",
        };
        self.chosen.as_mut().ok_or(missing)
    }
}

impl LinearSolver for Auto {
    fn name(&self) -> &'static str {
        self.chosen.as_ref().map_or(NAME, |solver| solver.name())
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.chosen = None;
        problem.validate()?;
        let mut solver = choose(problem)?
            .spec
            .build()
            .map_err(|error| invalid(&error))?;
        solver.analyse(problem)?;
        self.chosen = Some(solver);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.chosen()?.refresh(matrix)
    }

    fn solve(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<SolveReport, SolveError> {
        self.chosen()?.solve(matrix, rhs, x)
    }

    fn counters(&self) -> &SolverCounters {
        self.chosen
            .as_ref()
            .map_or(&self.idle, |solver| solver.counters())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{grid_laplacian, jittered_grid, noisy_vector, positive_definite};
    use crate::{Coordinates, CsrMatrix};

    /// A pattern of so many entries a row; only its sizes matter here.
    fn pattern(rows: usize, width: usize) -> CsrMatrix {
        let columns = (0..rows).flat_map(|row| {
            let first = row.min(rows - width);
            (first..first + width).map(|column| column as u32)
        });
        let starts = (0..=rows).map(|row| (row * width) as u32).collect();
        CsrMatrix::new(
            (rows, rows),
            starts,
            columns.collect(),
            vec![1.0; rows * width],
        )
    }

    fn chosen(rows: usize, width: usize, dimension: usize) -> String {
        let (pattern, values) = (pattern(rows, width), vec![0.0; rows * dimension]);
        let coordinates = Some(Coordinates {
            dimension,
            values: &values,
        });
        let problem = Problem {
            coordinates,
            ..positive_definite(&pattern, None, 1)
        };
        choose(&problem).unwrap().spec.to_string()
    }

    #[test]
    fn the_choice_follows_size_width_and_dimension() {
        assert_eq!(chosen(40_000, 63, 2), "faer-llt");
        assert_eq!(chosen(60_000, 63, 2), "faer-cg:preconditioner=stale");
        assert_eq!(chosen(120_000, 21, 2), "faer-llt");
        assert_eq!(chosen(40_000, 63, 3), "faer-cg:preconditioner=stale");
        assert_eq!(chosen(300_000, 27, 2), "faer-cg:preconditioner=jacobi");
    }

    #[test]
    fn the_chosen_backend_does_the_work_and_the_counting() {
        let (a, cloud) = (grid_laplacian(12, 9, 0.0), jittered_grid(12, 9, 0.0));
        let mut solver = SolverSpec::default().build().unwrap();
        assert_eq!(solver.name(), "auto");
        assert_eq!(solver.counters(), &SolverCounters::default());
        solver
            .analyse(&positive_definite(&a, Some(&cloud), 1))
            .unwrap();
        solver.refresh(a.view()).unwrap();
        let mut x = vec![0.0; a.rows()];
        let report = solver
            .solve(a.view(), &noisy_vector(a.rows()), &mut x)
            .unwrap();
        assert!(report.true_residual < 1e-13);
        assert_eq!((solver.name(), solver.counters().solves), ("faer-llt", 1));
    }

    #[test]
    fn a_quasi_definite_system_gets_a_factor_with_diagonal_pivots() {
        let a = grid_laplacian(4, 4, 0.0);
        let problem = Problem {
            symmetry: Symmetry::QuasiDefinite,
            ..positive_definite(&a, None, 1)
        };
        let choice = choose(&problem).unwrap();
        assert_eq!(choice.spec.to_string(), "faer-ldlt");
        assert_eq!(
            choice.reason,
            "16 unknowns with 4 entries a row, quasi-definite: LDLT needs no pivoting"
        );
    }

    #[test]
    fn other_symmetries_are_refused_with_advice() {
        let a = grid_laplacian(4, 4, 0.0);
        for symmetry in [Symmetry::Indefinite, Symmetry::General] {
            let problem = Problem {
                symmetry,
                ..positive_definite(&a, None, 1)
            };
            let error = SolverSpec::default()
                .build()
                .unwrap()
                .analyse(&problem)
                .unwrap_err();
            assert!(matches!(error, SolveError::Refused { symmetry: s, .. } if s == symmetry));
        }
    }
}
