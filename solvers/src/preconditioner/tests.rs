//! Tests of what is known of the preconditioners themselves.

use super::{Demand, PRECONDITIONERS, Preconditioner, build, count, words};
use crate::krylov::gmres;
use crate::registry::Options;
use crate::test_support::*;
use crate::{CsrMatrix, Problem, SolveError, Symmetry, multiply};

fn built(name: &str) -> Box<dyn Preconditioner> {
    let given = [("preconditioner".to_owned(), name.to_owned())];
    let options = Options::new(&gmres::BACKEND, &given);
    build(super::find(&options).unwrap(), &options).unwrap()
}

/// ‖M⁻¹ A x − x‖ / ‖x‖: 0 if M = A.
fn distance_from_inverse(name: &str, problem: &Problem<'_>) -> f64 {
    let mut preconditioner = built(name);
    preconditioner.analyse(problem).unwrap();
    preconditioner.refresh(problem.pattern).unwrap();
    let x = noisy_vector(problem.unknowns());
    let (mut b, mut found) = (vec![0.0; x.len()], vec![f64::NAN; x.len()]);
    multiply(problem.pattern, &x, &mut b);
    preconditioner.apply(&b, &mut found);
    relative_error(&found, &x)
}

#[test]
fn incomplete_factors_of_a_matrix_without_fill_are_exact() {
    let symmetric = tridiagonal(60, -1.0, 2.3, -1.0);
    let problem = positive_definite(&symmetric, None, 1);
    assert!(distance_from_inverse("ic0", &problem) < 1e-13);
    assert!(distance_from_inverse("ilu0", &problem) < 1e-13);
    for (left, centre, right) in [(-1.4, 2.9, -0.6), (1.0, -3.0, 0.5)] {
        let a = tridiagonal(60, left, centre, right);
        let problem = Problem::new(a.view(), Symmetry::General, 1);
        let distance = distance_from_inverse("ilu0", &problem);
        assert!(distance < 1e-13, "{distance:e}");
    }
}

#[test]
fn factors_in_single_precision_are_exact_to_single_precision() {
    let cloud = jittered_grid(14, 11, 0.3);
    let mut a = wide_stencil(&cloud, 2, 2.3, 2);
    // Units of unequal size would overflow single precision without the scaling.
    let scale = |i: usize| if i.is_multiple_of(2) { 1e25 } else { 1e-25 };
    for (row, mut vector) in a.outer_iterator_mut().enumerate() {
        let entries = vector.iter_mut();
        entries.for_each(|(column, value)| *value *= scale(row) * scale(column));
    }
    let problem = positive_definite(&a, Some(&cloud), 2);
    let mut single = built("f32");
    single.analyse(&problem).unwrap();
    single.refresh(a.view()).unwrap();
    let mut double = built("stale");
    double.analyse(&problem).unwrap();
    double.refresh(a.view()).unwrap();
    let mut residual = noisy_vector(a.rows());
    let mut found = [vec![0.0; a.rows()], vec![0.0; a.rows()]];
    residual
        .iter_mut()
        .enumerate()
        .for_each(|(i, value)| *value *= scale(i));
    single.apply(&residual, &mut found[0]);
    double.apply(&residual, &mut found[1]);
    for vector in &mut found {
        vector
            .iter_mut()
            .enumerate()
            .for_each(|(i, value)| *value *= scale(i));
    }
    let error = relative_error(&found[0], &found[1]);
    assert!((1e-9..1e-4).contains(&error), "{error:e}");
    let (half, whole) = (single.work(), double.work());
    assert_eq!(half.nonzeros, whole.nonzeros);
    // The indices of a factor this small weigh as much as its values.
    assert!((half.bytes as f64) < 0.7 * whole.bytes as f64);
}

/// A band of weak bonds across the middle, held at both ends.
fn cracked(cloud: &Cloud, columns: usize, softness: f64) -> CsrMatrix {
    let mut a = wide_stencil(cloud, 1, 2.5, 1);
    let middle = columns / 2;
    let weak = |point: usize| (middle..middle + 2).contains(&(point % columns));
    let factor = |i, j| if weak(i) || weak(j) { softness } else { 1.0 };
    let held = |i: usize| i.is_multiple_of(columns) || i % columns == columns - 1;
    damage(&mut a, factor, |i| if held(i) { 1.0 } else { 0.0 });
    a
}

#[test]
fn damage_of_nine_orders_costs_a_factor_in_single_precision_few_iterations() {
    let cloud = jittered_grid(40, 30, 0.2);
    for softness in [1e-3, 1e-6, 1e-9] {
        let a = cracked(&cloud, 40, softness);
        let problem = positive_definite(&a, Some(&cloud), 1);
        let rhs = noisy_vector(a.rows());
        let exact = dense_solution(&a, &rhs);
        for method in ["faer-cg", "minres", "gmres"] {
            let spec = format!("{method}:preconditioner=f32");
            let mut solver = ready(&spec, &problem).unwrap();
            let mut x = vec![0.0; a.rows()];
            let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
            assert!(report.iterations <= 6, "{spec} {softness:e}: {report:?}");
            let error = relative_error(&x, &exact);
            assert!(error < 1e-8, "{spec} {softness:e}: {error:e}");
        }
    }
}

#[test]
fn a_quasi_definite_factor_in_single_precision_serves_gmres() {
    let cloud = jittered_grid(20, 15, 0.2);
    let a = biot(&cloud, 1.0, 1e-2);
    let problem = Problem::new(a.view(), Symmetry::QuasiDefinite, 3);
    let (rhs, mut x) = (noisy_vector(a.rows()), vec![0.0; a.rows()]);
    let mut solver = ready("gmres:preconditioner=f32", &problem).unwrap();
    let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
    assert!(report.iterations <= 6, "{report:?}");
}

/// A crack of nine orders solved with the factor of the rock before it broke: that serves badly, and one in double
/// precision takes over.
#[test]
fn where_a_factor_in_single_precision_serves_badly_one_in_double_takes_over() {
    let cloud = jittered_grid(40, 30, 0.2);
    let (sound, a) = (wide_stencil(&cloud, 1, 2.5, 1), cracked(&cloud, 40, 1e-9));
    let problem = positive_definite(&a, Some(&cloud), 1);
    let rhs = noisy_vector(a.rows());
    let mut solver = ready("gmres:preconditioner=f32,tolerance=1e-10", &problem).unwrap();
    solver.refresh(sound.view()).unwrap();
    let mut x = vec![0.0; a.rows()];
    let before = solver.counters().factorisations;
    let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
    assert_eq!(solver.counters().factorisations, before + 1);
    assert!((30..40).contains(&report.iterations), "{report:?}");
    assert!(relative_error(&x, &dense_solution(&a, &rhs)) < 1e-6);
    // The next matrix has a factor in single precision again.
    solver.refresh(a.view()).unwrap();
    let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
    assert!(report.iterations <= 6, "{report:?}");
    assert_eq!(solver.counters().factorisations, before + 2);
}

#[test]
fn an_incomplete_cholesky_factor_that_fails_is_shifted_until_it_exists() {
    // Kershaw's matrix: positive definite, but the factor without fill has a negative pivot.
    let a = from_dense([
        [3.0, -2.0, 0.0, 2.0],
        [-2.0, 3.0, -2.0, 0.0],
        [0.0, -2.0, 3.0, -2.0],
        [2.0, 0.0, -2.0, 3.0],
    ]);
    let problem = positive_definite(&a, None, 1);
    let (rhs, mut x) = ([1.0, 2.0, 3.0, 4.0], [0.0; 4]);
    let mut solver = ready("faer-cg:preconditioner=ic0", &problem).unwrap();
    solver.solve(a.view(), &rhs, &mut x).unwrap();
    assert!(relative_error(&x, &dense_solution(&a, &rhs)) < 1e-10);
}

#[test]
fn rows_without_usable_pivot_are_named() {
    // The second pivot of [1, 3; 3, 9] is zero; a shift helps. A missing diagonal entry cannot be
    // helped, nor can a matrix far from definite by any shift up to 1.
    let missing: CsrMatrix = {
        let mut triplets = sprs::TriMatI::<f64, u32>::new((2, 2));
        triplets.add_triplet(0, 0, 1.0);
        triplets.add_triplet(0, 1, 1.0);
        triplets.add_triplet(1, 0, 1.0);
        triplets.to_csr()
    };
    let problem = Problem::new(missing.view(), Symmetry::Indefinite, 1);
    let error = ready("gmres:preconditioner=ilu0", &problem)
        .map(|_| ())
        .unwrap_err();
    assert!(
        matches!(
            error,
            SolveError::IncompletePivot {
                preconditioner: "ilu0",
                row: 1,
                ..
            }
        ),
        "{error}"
    );
    let far = from_dense([[1.0, 9.0], [9.0, 1.0]]);
    let problem = positive_definite(&far, None, 1);
    let error = ready("faer-cg:preconditioner=ic0", &problem)
        .map(|_| ())
        .unwrap_err();
    let SolveError::IncompletePivot { row: 1, shift, .. } = error else {
        panic!("{error}");
    };
    assert!(shift > 0.9);
    let zero = from_dense([[1.0, 3.0], [3.0, 9.0 + 1e-15]]);
    let problem = Problem::new(zero.view(), Symmetry::General, 1);
    assert!(ready("gmres:preconditioner=ilu0", &problem).is_ok());
}

#[test]
fn the_table_tells_the_truth_about_definiteness() {
    let cloud = jittered_grid(6, 5, 0.2);
    let (spd, mixed, general) = (
        wide_stencil(&cloud, 3, 2.3, 2),
        biot(&cloud, 1.0, 0.3),
        transport(9, 10),
    );
    for entry in PRECONDITIONERS {
        for (matrix, symmetry) in [
            (&spd, Symmetry::PositiveDefinite),
            (&mixed, Symmetry::QuasiDefinite),
            (&mixed, Symmetry::Indefinite),
            (&general, Symmetry::General),
        ] {
            if !entry.symmetries.contains(&symmetry) {
                continue;
            }
            let mut preconditioner = built(entry.name);
            let given = [10.0; 30];
            let problem = Problem {
                schur_diagonal: Some(&given),
                ..Problem::new(matrix.view(), symmetry, 3)
            };
            preconditioner.analyse(&problem).unwrap();
            preconditioner.refresh(matrix.view()).unwrap();
            let definite = entry.definite.contains(&symmetry);
            assert_eq!(preconditioner.is_symmetric(), definite, "{}", entry.name);
            let (a, b) = (
                noisy_vector(90),
                (0..90).map(|i| noise(i * i)).collect::<Vec<_>>(),
            );
            let (mut ma, mut mb) = (vec![0.0; 90], vec![0.0; 90]);
            preconditioner.apply(&a, &mut ma);
            preconditioner.apply(&b, &mut mb);
            if definite {
                let (left, right) = (crate::dot(&a, &mb), crate::dot(&b, &ma));
                let size = crate::norm2(&a) * crate::norm2(&mb);
                assert!((left - right).abs() < 1e-5 * size, "{}", entry.name);
                assert!(crate::dot(&a, &ma) > 0.0, "{}", entry.name);
            }
        }
    }
}

#[test]
fn methods_are_offered_what_they_can_take() {
    const DEFINITE: [&str; count(Demand::DefiniteMatrix)] = words(Demand::DefiniteMatrix);
    const ANY: [&str; count(Demand::Any)] = words(Demand::Any);
    assert!(DEFINITE.contains(&"ic0") && !DEFINITE.contains(&"ilu0"));
    assert_eq!(ANY.len(), PRECONDITIONERS.len());
}
