//! What every backend does alike: order of the stages, checks of the input, residuals.

use crate::matrix::{self, Fingerprint};
use crate::problem::{Problem, Symmetry};
use crate::share::Share;
use crate::{CsrView, SolveError, SolveReport};

/// Relative residual above which no solution is handed out, whatever limits the arithmetic.
pub(crate) const ACCEPTED_RESIDUAL: f64 = 1e-8;

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
        if !supported.contains(&problem.symmetry) {
            return Err(SolveError::Refused {
                solver: self.solver,
                symmetry: problem.symmetry,
                advice: format!(
                    "it solves {} systems only{}",
                    list(supported),
                    elsewhere(problem.symmetry)
                ),
            });
        }
        if problem.partition.is_some() && !self.distributed {
            return Err(SolveError::Refused {
                solver: self.solver,
                symmetry: problem.symmetry,
                advice: "several processes share it, and this solver works in one; choose `petsc` \
                         or `auto`, or start one process"
                    .into(),
            });
        }
        self.pattern = Some(Fingerprint::of(problem.pattern));
        self.share = Share::of(problem);
        self.residual = vec![0.0; problem.unknowns()];
        Ok(())
    }

    /// Checks new values and takes their diagonal. The caller then calls [`Self::set_ready`].
    pub(crate) fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.ready = false;
        let Some(expected) = self.pattern else {
            return self.missing("analyse");
        };
        let values = || matrix::check_rows(matrix, |row| self.share.owns(row));
        let checked = same_pattern(matrix, expected).and_then(|()| values());
        self.share.agree(checked)?;
        self.diagonal = matrix::diagonal(matrix);
        let invert = |value: &f64| if value.abs() > 0.0 { 1.0 / value } else { 1.0 };
        self.inverse_diagonal = self.diagonal.iter().map(invert).collect();
        Ok(())
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
        self.check_vector("the right-hand side", rhs)
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
        matrix::residual(matrix, x, rhs, &mut self.residual);
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

fn list(symmetries: &[Symmetry]) -> String {
    let names: Vec<String> = symmetries.iter().map(Symmetry::to_string).collect();
    names.join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::*;
    use crate::{CsrMatrix, LinearSolver, SolverSpec};

    const ALL: [&str; 5] = [
        "auto",
        "faer-llt",
        "faer-ldlt",
        "faer-cg",
        "faer-cg:preconditioner=stale",
    ];

    fn fresh(spec: &str) -> Box<dyn LinearSolver> {
        spec.parse::<SolverSpec>().unwrap().build().unwrap()
    }

    #[test]
    fn stages_out_of_order_are_refused() {
        let a = grid_laplacian(4, 3, 0.0);
        let (rhs, mut x) = ([1.0; 12], [0.0; 12]);
        for spec in ALL {
            let mut solver = fresh(spec);
            let early = solver.refresh(a.view()).unwrap_err();
            assert!(matches!(
                early,
                SolveError::NotAnalysed {
                    missing: "analyse",
                    ..
                }
            ));
            let early = solver.solve(a.view(), &rhs, &mut x).unwrap_err();
            assert!(matches!(
                early,
                SolveError::NotAnalysed {
                    missing: "analyse",
                    ..
                }
            ));
            solver.analyse(&positive_definite(&a, None, 1)).unwrap();
            let early = solver.solve(a.view(), &rhs, &mut x).unwrap_err();
            assert!(matches!(
                early,
                SolveError::NotAnalysed {
                    missing: "refresh",
                    ..
                }
            ));
        }
    }

    #[test]
    fn problems_that_contradict_themselves_are_refused() {
        let a = grid_laplacian(4, 3, 0.0);
        let flat = CsrMatrix::new((1, 2), vec![0, 1], vec![0], vec![1.0]);
        let cloud = jittered_grid(3, 3, 0.0);
        for spec in ALL {
            let error = fresh(spec)
                .analyse(&positive_definite(&flat, None, 1))
                .unwrap_err();
            assert_eq!(
                error,
                SolveError::NotSquare {
                    rows: 1,
                    columns: 2
                }
            );
            let odd = fresh(spec)
                .analyse(&positive_definite(&a, None, 5))
                .unwrap_err();
            assert!(matches!(odd, SolveError::InvalidProblem { .. }));
            let short = fresh(spec)
                .analyse(&positive_definite(&a, Some(&cloud), 1))
                .unwrap_err();
            assert_eq!(
                short,
                SolveError::Length {
                    what: "coordinates",
                    found: 18,
                    expected: 24
                }
            );
        }
        let blind = fresh("faer-llt:ordering=nd").analyse(&positive_definite(&a, None, 1));
        assert!(matches!(
            blind.unwrap_err(),
            SolveError::InvalidProblem { .. }
        ));
    }

    #[test]
    fn symmetries_a_backend_cannot_treat_are_refused() {
        let a = grid_laplacian(4, 3, 0.0);
        let problem = Problem {
            symmetry: Symmetry::General,
            ..positive_definite(&a, None, 1)
        };
        // `auto` has a backend for every symmetry.
        for spec in ALL.into_iter().filter(|spec| *spec != "auto") {
            let refused = fresh(spec).analyse(&problem).unwrap_err();
            assert!(matches!(
                refused,
                SolveError::Refused {
                    symmetry: Symmetry::General,
                    ..
                }
            ));
        }
    }

    #[test]
    fn bad_matrices_are_refused_with_their_row() {
        let good = grid_laplacian(4, 3, 0.0);
        for spec in ALL {
            let mut solver = prepared(spec, &good, None, 1);
            let mut bad = good.clone();
            let position = bad.nnz_index(7, 7).unwrap().0;
            bad.data_mut()[position] = f64::INFINITY;
            let error = solver.refresh(bad.view()).unwrap_err();
            assert!(matches!(
                error,
                SolveError::NotFinite {
                    what: "the matrix",
                    row: 7,
                    ..
                }
            ));
            let row = bad.indptr().outer_inds_sz(7);
            bad.data_mut()[row].fill(0.0);
            assert_eq!(
                solver.refresh(bad.view()).unwrap_err(),
                SolveError::Singular { row: 7 }
            );
            let error = solver
                .refresh(grid_laplacian(3, 4, 0.0).view())
                .unwrap_err();
            assert!(matches!(error, SolveError::PatternChanged { .. }));
            solver.refresh(good.view()).unwrap();
        }
    }

    #[test]
    fn bad_right_hand_sides_are_refused() {
        let a = grid_laplacian(4, 3, 0.0);
        for spec in ALL {
            let mut solver = prepared(spec, &a, None, 1);
            let mut rhs = [1.0; 12];
            rhs[5] = f64::NAN;
            let error = solver.solve(a.view(), &rhs, &mut [0.0; 12]).unwrap_err();
            assert!(matches!(error, SolveError::NotFinite { row: 5, .. }));
            let error = solver
                .solve(a.view(), &rhs[..3], &mut [0.0; 12])
                .unwrap_err();
            assert!(matches!(
                error,
                SolveError::Length {
                    found: 3,
                    expected: 12,
                    ..
                }
            ));
        }
    }

    #[test]
    fn the_scaled_residual_shows_errors_in_a_soft_zone() {
        let mut a = grid_laplacian(20, 1, 0.0);
        let soft = |i: usize| if i < 10 { 1e-6_f64 } else { 1.0 };
        for (row, mut vector) in a.outer_iterator_mut().enumerate() {
            let scale = |column: usize| soft(row).min(soft(column));
            vector
                .iter_mut()
                .for_each(|(column, value)| *value *= scale(column));
        }
        let mut system = System::new("test");
        system
            .analyse(
                &positive_definite(&a, None, 1),
                &[Symmetry::PositiveDefinite],
            )
            .unwrap();
        system.refresh(a.view()).unwrap();
        let (mut x, mut rhs) = (vec![1.0; 20], vec![0.0; 20]);
        crate::multiply(a.view(), &x, &mut rhs);
        x[3] += 0.1;
        let residuals = system.measure(a.view(), &x, &rhs);
        assert!(
            residuals.plain < 1e-6 && residuals.scaled > 1e-2,
            "{residuals:?}"
        );
    }

    #[test]
    fn tiny_and_huge_right_hand_sides_keep_their_norm() {
        let a = grid_laplacian(4, 3, 0.0);
        let cases = [
            ("faer-llt", 200),
            ("faer-cg", 100),
            ("faer-cg:preconditioner=stale", 100),
        ];
        for (spec, exponent) in cases {
            for size in [10_f64.powi(exponent), 10_f64.powi(-exponent)] {
                let (mut solver, mut x) = (prepared(spec, &a, None, 1), [0.0; 12]);
                let report = solver.solve(a.view(), &[size; 12], &mut x).unwrap();
                assert!(
                    report.true_residual < 1e-12 && x[0] > 0.1 * size,
                    "{spec} {report:?}"
                );
            }
        }
    }
}
