//! Tests of what is known of the methods themselves.

use crate::test_support::*;
use crate::{CsrMatrix, Interrupt, Problem, SolveError, Symmetry, norm2};

fn general(matrix: &CsrMatrix, symmetry: Symmetry) -> Problem<'_> {
    Problem::new(matrix.view(), symmetry, 1)
}

/// Residual left after exactly so many iterations, and the error if it is one.
fn after(spec: &str, problem: &Problem<'_>, rhs: &[f64], iterations: usize) -> f64 {
    let spec = format!("{spec},max_iterations={iterations}");
    let mut x = vec![0.0; rhs.len()];
    let mut solver = ready(&spec, problem).unwrap();
    match solver.solve(problem.pattern, rhs, &mut x) {
        Ok(report) => report.true_residual,
        Err(SolveError::NotConverged { residual, .. }) => residual,
        Err(other) => panic!("{spec}: {other}"),
    }
}

/// Smallest residual over x in span(b, A b, …, A^{k−1} b), by dense Gram-Schmidt.
fn least_residual(matrix: &CsrMatrix, rhs: &[f64], steps: usize) -> f64 {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut left, mut power) = (rhs.to_vec(), rhs.to_vec());
    for _ in 0..steps {
        let mut next = vec![0.0; rhs.len()];
        crate::multiply(matrix.view(), &power, &mut next);
        power.clone_from(&next);
        for _ in 0..2 {
            for vector in &basis {
                let part = crate::dot(vector, &next);
                next.iter_mut()
                    .zip(vector)
                    .for_each(|(a, b)| *a -= part * b);
            }
        }
        let size = norm2(&next);
        next.iter_mut().for_each(|value| *value /= size);
        let part = crate::dot(&next, &left);
        left.iter_mut().zip(&next).for_each(|(a, b)| *a -= part * b);
        basis.push(next);
    }
    norm2(&left) / norm2(rhs)
}

#[test]
fn gmres_and_minres_reach_the_least_residual_of_the_krylov_space() {
    let a = grid_laplacian(9, 7, -0.55);
    let rhs = noisy_vector(63);
    let problem = general(&a, Symmetry::Indefinite);
    for steps in [1, 2, 5, 9] {
        let least = least_residual(&a, &rhs, steps);
        for name in ["gmres", "fgmres", "minres"] {
            let found = after(
                &format!("{name}:preconditioner=none"),
                &problem,
                &rhs,
                steps,
            );
            assert!(
                (found - least).abs() < 1e-9 * least,
                "{name} {steps}: {found} {least}"
            );
        }
    }
}

#[test]
fn no_method_does_better_than_gmres_from_the_same_space() {
    let cloud = jittered_grid(12, 9, 0.3);
    let a = wide_stencil(&cloud, 1, 2.5, 1);
    let (rhs, problem) = (noisy_vector(108), positive_definite(&a, Some(&cloud), 1));
    for steps in [1, 3, 6, 10] {
        let residual = |name: &str| {
            after(
                &format!("{name}:preconditioner=none"),
                &problem,
                &rhs,
                steps,
            )
        };
        let (gmres, minres, cg) = (residual("gmres"), residual("minres"), residual("faer-cg"));
        assert!((gmres - minres).abs() < 1e-9 * gmres, "{gmres} {minres}");
        assert!(cg >= gmres * (1.0 - 1e-9), "{gmres} {cg}");
    }
}

#[test]
fn an_exact_preconditioner_leaves_one_or_two_iterations() {
    let a = tridiagonal(80, -1.0, 2.3, -1.0);
    let (rhs, problem) = (noisy_vector(80), positive_definite(&a, None, 1));
    for name in ["faer-cg", "minres", "gmres", "fgmres", "bicgstab"] {
        for preconditioner in ["ic0", "stale"] {
            let spec = format!("{name}:preconditioner={preconditioner}");
            let mut x = vec![0.0; 80];
            let mut solver = ready(&spec, &problem).unwrap();
            let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
            assert!(report.iterations <= 2, "{spec}: {report:?}");
        }
    }
}

#[test]
fn a_cyclic_shift_stalls_every_basis_that_is_too_small() {
    // A e_i = e_{i+1}: the residual stays 1 until the basis is complete.
    const SIZE: usize = 40;
    let mut triplets = sprs::TriMatI::<f64, u32>::new((SIZE, SIZE));
    (0..SIZE).for_each(|i| triplets.add_triplet((i + 1) % SIZE, i, 1.0));
    let a: CsrMatrix = triplets.to_csr();
    let (problem, mut rhs) = (general(&a, Symmetry::General), vec![0.0; SIZE]);
    rhs[0] = 1.0;
    for name in ["gmres", "fgmres"] {
        let mut solver =
            ready(&format!("{name}:preconditioner=none,restart=39"), &problem).unwrap();
        let error = solver.solve(a.view(), &rhs, &mut [0.0; SIZE]).unwrap_err();
        assert!(
            matches!(&error, SolveError::Stagnated { method, iterations: 39, residual, .. }
                if *method == name && (residual - 1.0).abs() < 1e-14),
            "{error}"
        );
        assert!(error.to_string().contains("raise restart"), "{error}");
        let mut solver = ready(&format!("{name}:preconditioner=none"), &problem).unwrap();
        let mut x = vec![0.0; SIZE];
        let report = solver.solve(a.view(), &rhs, &mut x).unwrap();
        assert_eq!(report.iterations, SIZE);
        assert!((x[SIZE - 1] - 1.0).abs() < 1e-14);
    }
    let mut solver = ready("bicgstab:preconditioner=none", &problem).unwrap();
    let error = solver.solve(a.view(), &rhs, &mut [0.0; SIZE]).unwrap_err();
    assert!(error.to_string().contains("became orthogonal"), "{error}");
}

#[test]
fn a_krylov_space_that_closes_without_solution_is_named() {
    // A² = 0: from b = A e_0 the space is closed at once although a solution exists; from e_0 none
    // exists.
    let a = from_dense([[1.0, -1.0], [1.0, -1.0]]);
    let problem = general(&a, Symmetry::General);
    for (name, rhs) in [
        ("gmres", [1.0, 1.0]),
        ("gmres", [1.0, 0.0]),
        ("fgmres", [1.0, 1.0]),
        ("fgmres", [1.0, 0.0]),
    ] {
        let mut solver = ready(&format!("{name}:preconditioner=none"), &problem).unwrap();
        let error = solver.solve(a.view(), &rhs, &mut [0.0; 2]).unwrap_err();
        assert!(
            matches!(error, SolveError::Breakdown { method, .. } if method == name),
            "{error}"
        );
        assert!(error.to_string().contains("singular"), "{error}");
    }
}

#[test]
fn minres_solves_a_consistent_singular_system_and_names_an_inconsistent_one() {
    let mut a = grid_laplacian(8, 5, 0.0);
    damage(&mut a, |_, _| 1.0, |_| 0.0);
    let problem = general(&a, Symmetry::Indefinite);
    let mut rhs = vec![0.0; 40];
    crate::multiply(a.view(), &noisy_vector(40), &mut rhs);
    for name in ["minres", "gmres", "bicgstab"] {
        let mut solver = ready(name, &problem).unwrap();
        let report = solver.solve(a.view(), &rhs, &mut [0.0; 40]).unwrap();
        assert!(report.true_residual < 1e-11, "{name}");
    }
    rhs[3] += 1.0;
    let mut solver = ready("minres", &problem).unwrap();
    let error = solver.solve(a.view(), &rhs, &mut [0.0; 40]).unwrap_err();
    let named = matches!(
        error,
        SolveError::Breakdown { .. } | SolveError::Stagnated { .. }
    );
    assert!(named, "{error}");
}

#[test]
fn methods_that_need_it_refuse_a_preconditioner_that_is_not_definite() {
    let cloud = jittered_grid(6, 5, 0.2);
    let a = biot(&cloud, 1.0, 0.1);
    let problem = Problem::new(a.view(), Symmetry::QuasiDefinite, 3);
    for (spec, accepted) in [
        ("gmres:preconditioner=stale", true),
        ("minres:preconditioner=stale", false),
        ("minres:preconditioner=ic0", false),
        ("gmres:preconditioner=ic0", false),
        ("minres:preconditioner=block-jacobi", true),
    ] {
        let outcome = ready(spec, &problem).map(|_| ());
        assert_eq!(outcome.is_ok(), accepted, "{spec}: {outcome:?}");
        if let Err(error) = outcome {
            let text = error.to_string();
            assert!(
                text.contains("choose one of none, jacobi, block-jacobi"),
                "{text}"
            );
        }
    }
    let error = ready("faer-cg", &problem).map(|_| ()).unwrap_err();
    assert!(matches!(error, SolveError::Refused { .. }), "{error}");
}

#[test]
fn huge_and_tiny_numbers_do_not_upset_the_methods() {
    let cloud = jittered_grid(9, 8, 0.2);
    let mut a = wide_stencil(&cloud, 1, 2.5, 1);
    for size in [1e140, 1e-140] {
        a.data_mut().iter_mut().for_each(|value| *value *= size);
        let problem = positive_definite(&a, Some(&cloud), 1);
        let rhs: Vec<f64> = noisy_vector(72).iter().map(|value| value * size).collect();
        for name in ["minres", "gmres", "fgmres", "bicgstab"] {
            let mut x = vec![0.0; 72];
            let report = ready(name, &problem).unwrap().solve(a.view(), &rhs, &mut x);
            assert!(report.is_ok(), "{name} {size:e}: {report:?}");
        }
        a.data_mut().iter_mut().for_each(|value| *value /= size);
    }
}

/// Far more iterations than can be done before the flag is raised; full recurrences for `gmres`, which would
/// stagnate otherwise.
#[test]
fn an_interruption_ends_every_method_in_the_middle() {
    for (spec, points) in [
        ("faer-cg:preconditioner=none", 200_000),
        ("minres:preconditioner=none", 200_000),
        ("bicgstab:preconditioner=none", 200_000),
        ("gmres:preconditioner=none,restart=5000", 5_000),
        ("fgmres:preconditioner=none,restart=5000", 5_000),
    ] {
        let a = grid_laplacian(points, 1, -2.0);
        let problem = general(&a, Symmetry::PositiveDefinite);
        let mut solver = ready(&format!("{spec},max_iterations=10000000"), &problem).unwrap();
        let (rhs, mut x) = (noisy_vector(points), vec![0.0; points]);
        let interrupt = Interrupt::default();
        let raised = interrupt.clone();
        let solved = interrupt.during(|| {
            std::thread::spawn(move || {
                std::thread::sleep(std::time::Duration::from_millis(20));
                raised.raise()
            });
            solver.solve(problem.pattern, &rhs, &mut x)
        });
        assert_eq!(solved, Err(SolveError::Interrupted), "{spec}");
    }
}
