//! What every backend does alike.

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
