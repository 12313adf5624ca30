//! Tests of the driver, with conjugate gradients and the kept factor.

use crate::test_support::*;
use crate::{SolveError, SolverSpec};

const STALE: &str = "faer-cg:preconditioner=stale";

#[test]
fn solutions_match_a_dense_factorisation() {
    let cloud = jittered_grid(15, 11, 0.3);
    let cases = [
        (wide_stencil(&cloud, 1, 4.6, 1), 1),
        (wide_stencil(&cloud, 3, 2.3, 3), 3),
    ];
    for ((a, per_point), kind) in cases
        .iter()
        .flat_map(|case| [(case, "jacobi"), (case, "stale"), (case, "none")])
    {
        let spec = format!("faer-cg:preconditioner={kind}");
        let mut solver = prepared(&spec, a, Some(&cloud), *per_point);
        let (rhs, mut x) = (noisy_vector(a.rows()), vec![0.0; a.rows()]);
        let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
        assert!(
            report.true_residual <= 1e-12,
            "{kind}: {}",
            report.true_residual
        );
        assert_eq!(solver.counters().iterations, report.iterations as u64);
        assert!(relative_error(&x, &dense_solution(a, &rhs)) < 1e-10);
    }
}

#[test]
fn iterations_grow_with_the_grid_and_shrink_with_the_preconditioner() {
    let iterations = |spec: &str, size: usize| {
        let mut a = grid_laplacian(size, size, 0.0);
        // Rows scaled by up to 1000 on both sides: easy for Jacobi, hard without.
        let scale = |i: usize| 10_f64.powf(1.5 * noise(i));
        for (row, mut vector) in a.outer_iterator_mut().enumerate() {
            vector
                .iter_mut()
                .for_each(|(column, value)| *value *= scale(row) * scale(column));
        }
        let mut solver = prepared(spec, &a, None, 1);
        let mut x = vec![0.0; a.rows()];
        solver
            .solve(a.view(), &noisy_vector(a.rows()), &mut x)
            .unwrap()
            .iterations
    };
    let (small, large) = (iterations("faer-cg", 12), iterations("faer-cg", 24));
    assert!(
        small >= 12 && large > small + small / 2 && large < 3 * small,
        "{small} {large}"
    );
    assert!(iterations("faer-cg:preconditioner=none", 12) > 3 * small);
    assert!(iterations(STALE, 24) <= 2);
}

#[test]
fn a_warm_start_from_the_solution_needs_no_iteration() {
    let a = grid_laplacian(20, 20, 0.0);
    let mut solver = prepared("faer-cg:tolerance=1e-10", &a, None, 1);
    let (rhs, mut x) = (noisy_vector(400), vec![0.0; 400]);
    assert!(solver.solve(a.view(), &rhs, &mut x).unwrap().iterations > 20);
    assert_eq!(solver.solve(a.view(), &rhs, &mut x).unwrap().iterations, 0);
    let mut absurd = vec![1e30; 400];
    solver.solve(a.view(), &rhs, &mut absurd).unwrap();
    assert!(relative_error(&absurd, &x) < 1e-8);
    let report = solver.solve(a.view(), &vec![0.0; 400], &mut x).unwrap();
    assert!(report.iterations == 0 && x.iter().all(|value| value.abs() == 0.0));
}

#[test]
fn a_kept_factor_is_renewed_only_after_a_slow_solve() {
    let cloud = jittered_grid(25, 25, 0.2);
    let mut a = wide_stencil(&cloud, 1, 2.5, 1);
    let mut solver = prepared(STALE, &a, Some(&cloud), 1);
    let (rhs, mut x) = (noisy_vector(a.rows()), vec![0.0; a.rows()]);
    let mut step = |a: &crate::CsrMatrix| {
        solver.refresh(a.view()).unwrap();
        x.fill(0.0);
        let iterations = solver.solve(a.view(), &rhs, &mut x).unwrap().iterations;
        (iterations, solver.counters().factorisations)
    };
    add_to_diagonal(&mut a, |_| 1e-4);
    let (gentle, factorisations) = step(&a);
    assert!(
        (1..=12).contains(&gentle) && factorisations == 1,
        "{gentle}"
    );
    add_to_diagonal(&mut a, |i| 2.0 * (1.0 + noise(i)));
    let (slow, factorisations) = step(&a);
    assert!(
        (13..=48).contains(&slow) && factorisations == 1,
        "{slow} {factorisations}"
    );
    let (renewed, factorisations) = step(&a);
    assert!(
        renewed <= 2 && factorisations == 2,
        "{renewed} {factorisations}"
    );
}

#[test]
fn a_hopeless_factor_is_renewed_within_the_solve() {
    let cloud = jittered_grid(25, 25, 0.2);
    let mut a = wide_stencil(&cloud, 1, 2.5, 1);
    let mut solver = prepared(
        "faer-cg:preconditioner=stale,refactor_above=3",
        &a,
        Some(&cloud),
        1,
    );
    add_to_diagonal(&mut a, |i| 10_f64.powf(3.0 * noise(i)));
    solver.refresh(a.view()).unwrap();
    assert_eq!(solver.counters().factorisations, 1);
    let (rhs, mut x) = (noisy_vector(a.rows()), vec![0.0; a.rows()]);
    let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
    assert!(
        (12..=15).contains(&report.iterations),
        "{}",
        report.iterations
    );
    assert_eq!(solver.counters().factorisations, 2);
    assert!(relative_error(&x, &dense_solution(&a, &rhs)) < 1e-10);
}

#[test]
fn too_few_iterations_are_reported_with_the_true_residual() {
    let a = grid_laplacian(30, 30, 0.0);
    let mut solver = prepared("faer-cg:max_iterations=5", &a, None, 1);
    let (rhs, mut x) = (noisy_vector(900), vec![0.0; 900]);
    let error = solver.solve(a.view(), &rhs, &mut x).unwrap_err();
    let SolveError::NotConverged {
        iterations,
        residual,
        ..
    } = error
    else {
        panic!("{error}");
    };
    let mut r = vec![0.0; 900];
    crate::residual(a.view(), &x, &rhs, &mut r);
    assert_eq!(iterations, 5);
    assert!((residual - crate::norm2(&r) / crate::norm2(&rhs)).abs() < 1e-14);
    assert_eq!(solver.counters().solves, 0);
}

#[test]
fn an_indefinite_operator_breaks_down_and_a_bad_diagonal_is_named() {
    let mut a = grid_laplacian(6, 6, -3.0);
    let mut solver = prepared("faer-cg", &a, None, 1);
    let error = solver
        .solve(a.view(), &[1.0; 36], &mut [0.0; 36])
        .unwrap_err();
    assert!(matches!(error, SolveError::Breakdown { .. }), "{error}");
    let position = a.nnz_index(3, 3).unwrap().0;
    a.data_mut()[position] = -1.0;
    let error = solver.refresh(a.view()).unwrap_err();
    assert_eq!(
        error,
        SolveError::NotPositiveDefinite {
            row: 3,
            diagonal: -1.0
        }
    );
}

#[test]
fn a_tolerance_below_rounding_stops_at_the_rounding_floor() {
    let a = grid_laplacian(30, 30, 0.0);
    let mut solver = prepared("faer-cg:tolerance=1e-30,max_iterations=400", &a, None, 1);
    let (rhs, mut x) = (noisy_vector(900), vec![0.0; 900]);
    let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
    assert!(report.true_residual > 1e-17 && report.true_residual < 1e-13);
}

#[test]
fn bits_are_equal_for_one_and_two_threads() {
    let cloud = jittered_grid(50, 50, 0.3);
    let a = wide_stencil(&cloud, 2, 2.3, 1);
    let rhs = noisy_vector(a.rows());
    for spec in ["faer-cg", STALE] {
        let bits = |threads| {
            in_pool(threads, || {
                let mut solver = prepared(spec, &a, Some(&cloud), 2);
                let mut x = vec![0.0; a.rows()];
                let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
                x.push(report.scaled_residual);
                x.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
            })
        };
        assert_eq!(bits(1), bits(2));
    }
}

#[test]
fn a_guess_that_is_not_finite_is_refused() {
    let a = grid_laplacian(3, 3, 0.0);
    let mut solver = "faer-cg".parse::<SolverSpec>().unwrap().build().unwrap();
    let error = solver
        .solve(a.view(), &[1.0; 9], &mut [0.0; 9])
        .unwrap_err();
    assert_eq!(
        error,
        SolveError::NotAnalysed {
            solver: "faer-cg",
            missing: "analyse"
        }
    );
    let mut solver = prepared("faer-cg", &a, None, 1);
    let error = solver
        .solve(a.view(), &[1.0; 9], &mut [f64::NAN; 9])
        .unwrap_err();
    assert!(matches!(
        error,
        SolveError::NotFinite {
            what: "the initial guess",
            ..
        }
    ));
}

#[test]
fn a_soft_band_is_solved_by_every_backend() {
    let cloud = jittered_grid(24, 16, 0.2);
    let cracked = |point: usize| (11..=12).contains(&(point % 24));
    for softness in [1e-3, 1e-6] {
        let mut a = wide_stencil(&cloud, 1, 2.5, 1);
        let factor = |i, j| {
            if cracked(i) || cracked(j) {
                softness
            } else {
                1.0
            }
        };
        damage(&mut a, factor, |i| {
            if i % 24 == 0 || i % 24 == 23 {
                1.0
            } else {
                0.0
            }
        });
        let rhs = noisy_vector(a.rows());
        let exact = dense_solution(&a, &rhs);
        for spec in ["faer-llt", "faer-cg", STALE] {
            let mut x = vec![0.0; a.rows()];
            let report = prepared(spec, &a, Some(&cloud), 1)
                .solve(a.view(), &rhs, &mut x)
                .unwrap();
            assert!(
                report.true_residual <= 1e-10,
                "{spec} {softness} {report:?}"
            );
            assert!(relative_error(&x, &exact) < 1e-8, "{spec} {softness}");
        }
    }
}

#[test]
fn a_body_that_nothing_holds_is_never_reported_as_solved() {
    let cloud = jittered_grid(16, 12, 0.2);
    let mut a = wide_stencil(&cloud, 1, 2.5, 1);
    damage(&mut a, |_, _| 1.0, |_| 0.0);
    for spec in ["faer-llt", "faer-llt:ordering=amd", "faer-cg", STALE] {
        let mut solver = spec.parse::<SolverSpec>().unwrap().build().unwrap();
        solver
            .analyse(&positive_definite(&a, Some(&cloud), 1))
            .unwrap();
        let (rhs, mut x) = (vec![1.0; a.rows()], vec![0.0; a.rows()]);
        let error = solver
            .refresh(a.view())
            .and_then(|()| solver.solve(a.view(), &rhs, &mut x).map(|_| ()))
            .unwrap_err();
        let known = matches!(
            error,
            SolveError::NotPositiveDefinite { .. }
                | SolveError::Inaccurate { .. }
                | SolveError::NotConverged { .. }
                | SolveError::Breakdown { .. }
        );
        assert!(known, "{spec}: {error}");
    }
}
