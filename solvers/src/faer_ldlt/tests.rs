//! Tests of the LDLT backend.

use crate::test_support::*;
use crate::{CsrMatrix, LinearSolver, Problem, SolveError, SolverSpec, Symmetry};

fn analysed(spec: &str, a: &CsrMatrix, cloud: &Cloud, per_point: usize) -> Box<dyn LinearSolver> {
    let mut solver = spec.parse::<SolverSpec>().unwrap().build().unwrap();
    let problem = Problem {
        symmetry: Symmetry::QuasiDefinite,
        ..positive_definite(a, Some(cloud), per_point)
    };
    solver.analyse(&problem).unwrap();
    solver
}

/// Solution, true residual and scaled residual.
fn solved(spec: &str, a: &CsrMatrix, cloud: &Cloud, rhs: &[f64]) -> (Vec<f64>, f64, f64) {
    let mut solver = analysed(spec, a, cloud, 3);
    solver.refresh(a.view()).unwrap();
    let mut x = vec![f64::NAN; a.rows()];
    let report = solver.solve(a.view(), rhs, &mut x).unwrap();
    (x, report.true_residual, report.scaled_residual)
}

#[test]
fn solutions_match_a_dense_factorisation_for_every_ordering() {
    let cloud = jittered_grid(17, 13, 0.2);
    let a = biot(&cloud, 1.0, 1e-2);
    let rhs = noisy_vector(a.rows());
    let exact = dense_solution(&a, &rhs);
    for ordering in ["auto", "nd", "sweep", "amd"] {
        let spec = format!("faer-ldlt:ordering={ordering}");
        let (x, plain, scaled) = solved(&spec, &a, &cloud, &rhs);
        assert!(plain < 1e-12 && scaled < 1e-11, "{spec}: {plain} {scaled}");
        assert!(relative_error(&x, &exact) < 1e-10, "{spec}");
    }
}

#[test]
fn a_vanishing_storage_does_not_spoil_geometric_orderings() {
    // The pivot of an interior pressure before its neighbours is −S; growth 1/S would leave
    // nothing of K.
    let cloud = jittered_grid(40, 12, 0.2);
    for storage in [1e-4, 1e-8, 1e-12, 1e-16] {
        let a = biot(&cloud, 1.0, storage);
        let rhs = noisy_vector(a.rows());
        for ordering in ["auto", "nd", "sweep"] {
            let spec = format!("faer-ldlt:ordering={ordering}");
            let (_, plain, _) = solved(&spec, &a, &cloud, &rhs);
            assert!(plain < 1e-10, "{spec} S={storage:e}: {plain:e}");
        }
    }
}

#[test]
fn units_of_very_different_size_do_not_cost_accuracy() {
    let cloud = jittered_grid(17, 13, 0.2);
    let a = biot(&cloud, 1e8, 1e-10);
    let scale = |i: usize| if i % 3 == 2 { 1e4 } else { 1e-4 };
    let mut balanced = a.clone();
    for (row, mut vector) in balanced.outer_iterator_mut().enumerate() {
        vector
            .iter_mut()
            .for_each(|(column, value)| *value *= scale(row) * scale(column));
    }
    let scaled_rhs = noisy_vector(a.rows());
    let exact = dense_solution(&balanced, &scaled_rhs);
    let rhs: Vec<f64> = (0..a.rows()).map(|i| scaled_rhs[i] / scale(i)).collect();
    let (x, plain, _) = solved("faer-ldlt", &a, &cloud, &rhs);
    let x: Vec<f64> = (0..a.rows()).map(|i| x[i] / scale(i)).collect();
    let error = relative_error(&x, &exact);
    assert!(plain < 1e-11 && error < 1e-8, "{plain:e} {error:e}");
}

#[test]
fn a_singular_matrix_names_the_row() {
    // Two points: (1, 1; 1, −1) is quasi-definite, (1, 1; 1, 1) has the pivots 1 and 0.
    let columns = vec![0, 1, 0, 1, 2, 3, 2, 3];
    let values = vec![1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0];
    let a = CsrMatrix::new((4, 4), vec![0, 2, 4, 6, 8], columns, values);
    let cloud = jittered_grid(2, 1, 0.0);
    for ordering in ["nd", "sweep"] {
        let spec = format!("faer-ldlt:ordering={ordering}");
        let mut solver = analysed(&spec, &a, &cloud, 2);
        let error = solver.refresh(a.view()).unwrap_err();
        let diagonal = 1.0;
        assert_eq!(error, SolveError::ZeroPivot { row: 3, diagonal });
        let missing = solver.solve(a.view(), &[1.0; 4], &mut [0.0; 4]);
        assert!(matches!(
            missing.unwrap_err(),
            SolveError::NotAnalysed {
                missing: "refresh",
                ..
            }
        ));
    }
}

#[test]
fn a_pivot_that_overflows_names_the_row() {
    // Large enough for the supernodal variant. Row 1202 gets the pivot −S − (1e200)²/K.
    let cloud = jittered_grid(30, 30, 0.2);
    let mut a = biot(&cloud, 1.0, 1.0);
    let neighbour = (0..1200).step_by(3).rfind(|j| a.get(1202, *j).is_some());
    let j = neighbour.unwrap();
    for (row, column) in [(1202, j), (j, 1202)] {
        let position = a.nnz_index(row, column).unwrap().0;
        a.data_mut()[position] = 1e200;
    }
    let mut solver = analysed("faer-ldlt:ordering=sweep", &a, &cloud, 3);
    let error = solver.refresh(a.view()).unwrap_err();
    let diagonal = -1.0;
    assert_eq!(
        error,
        SolveError::ZeroPivot {
            row: 1202,
            diagonal
        }
    );
}

#[test]
fn a_matrix_that_is_not_the_refreshed_one_is_found_inaccurate() {
    let cloud = jittered_grid(8, 8, 0.2);
    let mut a = biot(&cloud, 1.0, 1e-2);
    let mut solver = analysed("faer-ldlt", &a, &cloud, 3);
    solver.refresh(a.view()).unwrap();
    a.data_mut().iter_mut().for_each(|value| *value *= -3.0);
    let mut x = vec![0.0; a.rows()];
    let error = solver.solve(a.view(), &noisy_vector(a.rows()), &mut x);
    let found = error.unwrap_err();
    assert!(matches!(found, SolveError::Inaccurate { residual, .. } if residual > 1.0));
    assert_eq!(solver.counters().solves, 0);
}

#[test]
fn the_work_is_counted_and_auto_hands_it_over() {
    let cloud = jittered_grid(12, 9, 0.2);
    let mut a = biot(&cloud, 1.0, 1e-3);
    let mut solver = analysed("auto", &a, &cloud, 3);
    for _ in 0..3 {
        a.data_mut().iter_mut().for_each(|value| *value *= 1.5);
        solver.refresh(a.view()).unwrap();
    }
    let mut x = vec![0.0; a.rows()];
    solver
        .solve(a.view(), &noisy_vector(a.rows()), &mut x)
        .unwrap();
    assert_eq!(solver.name(), "faer-ldlt");
    let counters = solver.counters();
    assert_eq!((counters.analyses, counters.refreshes), (1, 3));
    assert_eq!((counters.factorisations, counters.solves), (3, 1));
    assert!(counters.factor_nonzeros > a.nnz() as u64 / 2);
}

#[test]
fn bits_are_equal_for_one_and_two_threads_and_twice() {
    let cloud = jittered_grid(50, 14, 0.2);
    let a = biot(&cloud, 1.0, 1e-6);
    let rhs = noisy_vector(a.rows());
    let bits = |threads| {
        in_pool(threads, || {
            let (mut x, plain, scaled) = solved("faer-ldlt", &a, &cloud, &rhs);
            x.extend([plain, scaled]);
            x.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        })
    };
    let single = bits(1);
    assert_eq!(single, bits(2));
    assert_eq!(single, bits(2));
}

#[test]
fn positive_definite_systems_have_the_solution_of_the_cholesky_backend() {
    let cloud = jittered_grid(20, 15, 0.3);
    let a = wide_stencil(&cloud, 2, 2.3, 2);
    let rhs = noisy_vector(a.rows());
    let solution = |spec| {
        let mut x = vec![0.0; a.rows()];
        let mut solver = prepared(spec, &a, Some(&cloud), 2);
        solver.solve(a.view(), &rhs, &mut x).unwrap();
        x
    };
    assert!(relative_error(&solution("faer-ldlt"), &solution("faer-llt")) < 1e-12);
}
