//! Tests of the Cholesky backend.

use crate::test_support::*;
use crate::{CsrMatrix, SolveError, SolverSpec};

#[test]
fn solutions_match_a_dense_factorisation() {
    let cloud = jittered_grid(17, 13, 0.3);
    let cases = [
        (grid_laplacian(17, 13, 0.0), 1),
        (wide_stencil(&cloud, 1, 4.6, 1), 1),
        (wide_stencil(&cloud, 2, 2.3, 2), 2),
        (wide_stencil(&cloud, 3, 2.3, 3), 3),
    ];
    for ((a, per_point), ordering) in cases
        .iter()
        .flat_map(|case| [(case, "nd"), (case, "amd"), (case, "auto")])
    {
        let spec = format!("faer-llt:ordering={ordering}");
        let mut solver = prepared(&spec, a, Some(&cloud), *per_point);
        let rhs = noisy_vector(a.rows());
        let mut x = vec![f64::NAN; a.rows()];
        let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
        assert!(report.true_residual <= 1e-12 && report.scaled_residual <= 1e-12);
        let error = relative_error(&x, &dense_solution(a, &rhs));
        assert!(error < 1e-11, "{spec}: {error}");
    }
}

#[test]
fn the_analysis_is_done_once_for_five_refreshes() {
    let cloud = jittered_grid(20, 20, 0.2);
    let mut a = wide_stencil(&cloud, 1, 2.5, 1);
    let mut solver = prepared("faer-llt", &a, Some(&cloud), 1);
    let rhs = noisy_vector(a.rows());
    for step in 1..5 {
        a.data_mut()
            .iter_mut()
            .for_each(|value| *value *= 1.0 + 0.1 * step as f64);
        solver.refresh(a.view()).unwrap();
        let mut x = vec![0.0; a.rows()];
        solver.solve(a.view(), &rhs, &mut x).unwrap();
        assert!(relative_error(&x, &dense_solution(&a, &rhs)) < 1e-11);
    }
    let counters = solver.counters();
    assert_eq!(
        (
            counters.analyses,
            counters.refreshes,
            counters.factorisations
        ),
        (1, 5, 5)
    );
    let size = crate::predict(&positive_definite(&a, Some(&cloud), 1)).unwrap();
    assert_eq!(counters.factor_nonzeros, size.nonzeros);
    assert_eq!(counters.factor_bytes, size.bytes);
}

#[test]
fn bits_are_equal_for_one_and_two_threads() {
    let cloud = jittered_grid(60, 60, 0.3);
    let a = wide_stencil(&cloud, 2, 2.3, 1);
    let rhs = noisy_vector(a.rows());
    let bits = |threads| {
        in_pool(threads, || {
            let mut solver = prepared("faer-llt", &a, Some(&cloud), 2);
            let mut x = vec![0.0; a.rows()];
            let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
            x.push(report.true_residual);
            x.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        })
    };
    let single = bits(1);
    assert_eq!(single, bits(2));
    assert_eq!(single, bits(2));
}

#[test]
fn zero_right_hand_side_and_empty_system_are_solved() {
    let a = grid_laplacian(5, 5, 0.0);
    let mut x = vec![3.0; 25];
    let mut solver = prepared("faer-llt", &a, None, 1);
    let report = solver.solve(a.view(), &[0.0; 25], &mut x).unwrap();
    assert!(x.iter().all(|value| value.abs() == 0.0));
    assert!(report.true_residual.abs() == 0.0);
    let empty = CsrMatrix::new((0, 0), vec![0], vec![], vec![]);
    for spec in [
        "auto",
        "faer-llt",
        "faer-cg",
        "faer-cg:preconditioner=stale",
    ] {
        prepared(spec, &empty, None, 1)
            .solve(empty.view(), &[], &mut [])
            .unwrap();
    }
}

#[test]
fn an_indefinite_matrix_names_the_row() {
    let cloud = jittered_grid(9, 9, 0.0);
    let small = grid_laplacian(9, 9, 0.0);
    names_the_row(small, &cloud);
    // Wide enough for the supernodal variant.
    let cloud = jittered_grid(40, 40, 0.0);
    names_the_row(wide_stencil(&cloud, 1, 4.6, 1), &cloud);
}

fn names_the_row(mut a: CsrMatrix, cloud: &Cloud) {
    let position = a.nnz_index(40, 40).unwrap().0;
    a.data_mut()[position] = -2.0;
    for ordering in ["nd", "amd"] {
        let spec: SolverSpec = format!("faer-llt:ordering={ordering}").parse().unwrap();
        let mut solver = spec.build().unwrap();
        solver
            .analyse(&positive_definite(&a, Some(cloud), 1))
            .unwrap();
        let error = solver.refresh(a.view()).unwrap_err();
        assert_eq!(
            error,
            SolveError::NotPositiveDefinite {
                row: 40,
                diagonal: -2.0
            }
        );
        let rhs = vec![1.0; a.rows()];
        let missing = solver.solve(a.view(), &rhs, &mut rhs.clone()).unwrap_err();
        assert_eq!(
            missing,
            SolveError::NotAnalysed {
                solver: "faer-llt",
                missing: "refresh"
            }
        );
    }
}

#[test]
fn a_matrix_that_is_not_the_refreshed_one_is_found_inaccurate() {
    let mut a = grid_laplacian(8, 8, 0.0);
    let mut solver = prepared("faer-llt", &a, None, 1);
    a.data_mut().iter_mut().for_each(|value| *value *= -3.0);
    let error = solver
        .solve(a.view(), &noisy_vector(64), &mut [0.0; 64])
        .unwrap_err();
    assert!(matches!(error, SolveError::Inaccurate { residual, .. } if residual > 1.0));
    assert_eq!(solver.counters().solves, 0);
}

#[test]
fn refinement_repairs_a_factor_of_a_slightly_different_matrix() {
    let mut a = grid_laplacian(8, 8, 1.0);
    let mut solver = prepared("faer-llt", &a, None, 1);
    a.data_mut()[0] += 1e-3;
    let mut x = [0.0; 64];
    let report = solver.solve(a.view(), &noisy_vector(64), &mut x).unwrap();
    assert_eq!((report.iterations, solver.counters().refinements), (2, 2));
    assert!(report.true_residual < 1e-12);
}
