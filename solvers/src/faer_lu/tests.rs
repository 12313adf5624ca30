//! Tests of the LU backend.

use crate::test_support::*;
use crate::{Problem, SolveError, Symmetry};

#[test]
fn unsymmetric_matrices_are_not_transposed() {
    for (columns, rows) in [(9, 7), (40, 40)] {
        let a = transport(columns, rows);
        let (rhs, mut x) = (noisy_vector(a.rows()), vec![f64::NAN; a.rows()]);
        let problem = Problem::new(a.view(), Symmetry::General, 1);
        let mut solver = ready("faer-lu", &problem).unwrap();
        let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
        assert!(report.true_residual < 1e-13, "{report:?}");
        assert!(relative_error(&x, &dense_solution(&a, &rhs)) < 1e-12);
    }
}

#[test]
fn an_unsymmetric_pattern_with_zeros_on_the_diagonal_is_solved() {
    let a = from_dense([
        [0.0, 2.0, 0.0, 0.0],
        [0.0, 0.0, 3.0, 1.0],
        [4.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 5.0],
    ]);
    let problem = Problem::new(a.view(), Symmetry::General, 1);
    let (rhs, mut x) = ([2.0, 3.0, 4.0, 11.0], [0.0; 4]);
    let mut solver = ready("faer-lu", &problem).unwrap();
    solver.solve(a.view(), &rhs, &mut x).unwrap();
    let exact = [1.0, 1.0, 1.0 / 3.0, 2.0];
    assert!(relative_error(&x, &exact) < 1e-14, "{x:?}");
}

#[test]
fn the_symbolic_factor_serves_many_matrices() {
    let mut a = transport(20, 15);
    let problem_matrix = a.clone();
    let problem = Problem::new(problem_matrix.view(), Symmetry::General, 1);
    let mut solver = ready("faer-lu", &problem).unwrap();
    let rhs = noisy_vector(a.rows());
    for _ in 0..3 {
        add_to_diagonal(&mut a, |i| 0.3 * noise(i));
        solver.refresh(a.view()).unwrap();
        let mut x = vec![0.0; a.rows()];
        solver.solve(a.view(), &rhs, &mut x).unwrap();
        assert!(relative_error(&x, &dense_solution(&a, &rhs)) < 1e-12);
    }
    let counters = solver.counters();
    assert_eq!((counters.analyses, counters.factorisations), (1, 4));
}

#[test]
fn singular_matrices_are_errors_by_name() {
    // Structurally (two rows with one column), and by value.
    let structural = from_dense([[0.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 3.0]]);
    let by_value = from_dense([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [1.0, 0.0, 1.0]]);
    for a in [structural, by_value] {
        let problem = Problem::new(a.view(), Symmetry::General, 1);
        let outcome = ready("faer-lu", &problem)
            .and_then(|mut solver| solver.solve(a.view(), &[1.0, 1.0, 1.0], &mut [0.0; 3]));
        let error = outcome.unwrap_err();
        let named = matches!(
            error,
            SolveError::ZeroPivot { .. } | SolveError::Inaccurate { .. }
        );
        assert!(named, "{error}");
    }
}

#[test]
fn large_systems_are_refused_with_the_way_out() {
    let a = grid_laplacian(101, 100, 0.0);
    for (symmetry, way) in [
        (Symmetry::General, "keep the system symmetric"),
        (Symmetry::PositiveDefinite, "faer-llt"),
        (Symmetry::QuasiDefinite, "faer-ldlt"),
    ] {
        let problem = Problem::new(a.view(), symmetry, 1);
        let error = ready("faer-lu", &problem).map(|_| ()).unwrap_err();
        assert!(matches!(error, SolveError::Refused { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.contains(way) && text.contains("max_unknowns=10000"),
            "{text}"
        );
    }
    let problem = Problem::new(a.view(), Symmetry::PositiveDefinite, 1);
    assert!(ready("faer-lu:max_unknowns=10100", &problem).is_ok());
}

#[test]
fn bits_are_equal_for_one_two_and_three_threads() {
    let a = transport(60, 70);
    let (problem, rhs) = (
        Problem::new(a.view(), Symmetry::General, 1),
        noisy_vector(4200),
    );
    let bits = |threads| {
        in_pool(threads, || {
            let mut x = vec![0.0; 4200];
            let mut solver = ready("faer-lu", &problem).unwrap();
            solver.solve(a.view(), &rhs, &mut x).unwrap();
            x.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        })
    };
    let single = bits(1);
    assert_eq!(single, bits(2));
    assert_eq!(single, bits(3));
}
