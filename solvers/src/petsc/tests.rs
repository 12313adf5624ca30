use super::*;
use crate::test_support::*;
use crate::{Coordinates, CsrMatrix, NearNullspace, SolverSpec};

/// Set where PETSc must be there; elsewhere its tests are skipped.
const REQUIRED: &str = "PERIFRAC_REQUIRE_PETSC";

pub(super) fn missing() -> bool {
    let Err(error) = petsc_status() else {
        return false;
    };
    assert!(
        std::env::var_os(REQUIRED).is_none(),
        "{REQUIRED} is set, but {error}"
    );
    eprintln!("skipped: {error}");
    true
}

pub(super) fn solver(spec: &str) -> Box<dyn LinearSolver> {
    spec.parse::<SolverSpec>().unwrap().build().unwrap()
}

fn elastic<'a>(matrix: &'a CsrMatrix, cloud: &'a Cloud) -> Problem<'a> {
    Problem {
        near_nullspace: NearNullspace::RigidModes,
        ..positive_definite(matrix, Some(cloud), 2)
    }
}

/// Displacements and pressure at each point: [K B; Bᵀ −C].
fn monolithic(cloud: &Cloud) -> CsrMatrix {
    let (solid, fluid) = (
        wide_stencil(cloud, 2, 2.3, 1),
        wide_stencil(cloud, 1, 2.3, 2),
    );
    let mut triplets = sprs::TriMatI::<f64, u32>::new((3 * cloud.points(), 3 * cloud.points()));
    for (value, (row, column)) in &solid {
        let place = |unknown: u32| (3 * (unknown / 2) + unknown % 2) as usize;
        triplets.add_triplet(place(row), place(column), *value);
    }
    for (value, (row, column)) in &fluid {
        let (p, q) = (row as usize, column as usize);
        triplets.add_triplet(3 * p + 2, 3 * q + 2, -0.1 * value);
        for axis in 0..2 {
            let offset = cloud.coordinates[2 * q + axis] - cloud.coordinates[2 * p + axis];
            triplets.add_triplet(3 * p + axis, 3 * q + 2, 0.05 * offset);
            triplets.add_triplet(3 * q + 2, 3 * p + axis, 0.05 * offset);
        }
    }
    triplets.to_csr()
}

fn solve(spec: &str, problem: &Problem<'_>, matrix: &CsrMatrix) -> (Vec<f64>, SolveReport) {
    let mut solver = solver(spec);
    solver.analyse(problem).unwrap();
    solver.refresh(matrix.view()).unwrap();
    let (rhs, mut x) = (noisy_vector(matrix.rows()), vec![0.0; matrix.rows()]);
    let report = solver.solve(matrix.view(), &rhs, &mut x);
    (x, report.unwrap_or_else(|error| panic!("{spec}: {error}")))
}

fn check(spec: &str, problem: &Problem<'_>, matrix: &CsrMatrix) {
    let (x, report) = solve(spec, problem, matrix);
    let exact = dense_solution(matrix, &noisy_vector(matrix.rows()));
    let error = relative_error(&x, &exact);
    assert!(
        error < 1e-9 && report.true_residual <= 1e-12,
        "{spec}: {error:e} {report:?}"
    );
}

#[test]
fn methods_chosen_by_flags_solve_positive_definite_systems() {
    if missing() {
        return;
    }
    let cloud = jittered_grid(14, 11, 0.2);
    let flow = wide_stencil(&cloud, 1, 2.3, 5);
    let solid = wide_stencil(&cloud, 2, 2.3, 6);
    for flags in [
        "",
        ":-ksp_type cg -pc_type jacobi",
        ":-ksp_type cg -pc_type icc",
        ":-ksp_type cg -pc_type gamg",
        ":-pc_type gamg",
        ":-ksp_type cg",
        ":-ksp_type cg -pc_type bjacobi -sub_pc_type icc",
        ":-ksp_type minres -pc_type jacobi",
        ":-ksp_type gmres -pc_type ilu",
        ":-ksp_type fgmres -pc_type gamg",
        ":-ksp_type bcgs -pc_type jacobi",
        ":-ksp_type preonly -pc_type cholesky",
        ":-pc_type lu -pc_factor_mat_solver_type petsc",
    ] {
        let spec = format!("petsc{flags}");
        check(&spec, &positive_definite(&flow, Some(&cloud), 1), &flow);
        check(&spec, &positive_definite(&flow, None, 1), &flow);
        check(&spec, &elastic(&solid, &cloud), &solid);
    }
}

#[test]
fn external_packages_serve_where_they_are() {
    if missing() {
        return;
    }
    let packages = petsc_status().unwrap().packages;
    let cloud = jittered_grid(14, 11, 0.2);
    let solid = wide_stencil(&cloud, 2, 2.3, 6);
    for (package, flags) in [
        ("hypre", "-pc_type hypre -pc_hypre_type boomeramg"),
        (
            "mumps",
            "-pc_type cholesky -pc_factor_mat_solver_type mumps",
        ),
        ("superlu", "-pc_type lu -pc_factor_mat_solver_type superlu"),
    ] {
        if packages.contains(&package) {
            check(&format!("petsc:{flags}"), &elastic(&solid, &cloud), &solid);
        }
    }
}

#[test]
fn monolithic_systems_are_factorised_or_split_into_blocks() {
    if missing() {
        return;
    }
    let cloud = jittered_grid(14, 11, 0.2);
    let matrix = monolithic(&cloud);
    let problem = Problem {
        symmetry: Symmetry::QuasiDefinite,
        near_nullspace: NearNullspace::RigidModes,
        coordinates: Some(Coordinates {
            dimension: 2,
            values: &cloud.coordinates,
        }),
        ..Problem::new(matrix.view(), Symmetry::QuasiDefinite, 3)
    };
    for flags in [
        "",
        ":-pc_type fieldsplit",
        ":-ksp_type fgmres -pc_type fieldsplit -fieldsplit_p_pc_type jacobi",
        ":-ksp_type fgmres",
        ":-ksp_type gmres -pc_type ilu",
    ] {
        check(&format!("petsc{flags}"), &problem, &matrix);
    }
}

#[test]
fn general_matrices_are_factorised() {
    if missing() {
        return;
    }
    let mut matrix = grid_laplacian(9, 8, 0.3);
    let mut shear = 0.0;
    matrix.data_mut().iter_mut().for_each(|value| {
        shear += 0.01;
        *value += shear;
    });
    let problem = Problem::new(matrix.view(), Symmetry::General, 1);
    check("petsc", &problem, &matrix);
    check("petsc:-ksp_type gmres -pc_type ilu", &problem, &matrix);
}

#[test]
fn new_values_take_effect_and_work_is_counted() {
    if missing() {
        return;
    }
    let cloud = jittered_grid(14, 11, 0.2);
    let mut matrix = wide_stencil(&cloud, 1, 2.3, 5);
    let rhs = noisy_vector(matrix.rows());
    for flags in ["", ":-pc_type gamg", ":-pc_type icc"] {
        let mut solver = solver(&format!("petsc{flags}"));
        let problem = positive_definite(&matrix, Some(&cloud), 1);
        solver.analyse(&problem).unwrap();
        let mut x = vec![0.0; matrix.rows()];
        for round in 0..3 {
            damage(
                &mut matrix,
                |i, j| 1.0 / (1 + (i + j + round) % 3) as f64,
                |_| 0.1,
            );
            solver.refresh(matrix.view()).unwrap();
            let report = solver.solve(matrix.view(), &rhs, &mut x).unwrap();
            let exact = dense_solution(&matrix, &rhs);
            assert!(relative_error(&x, &exact) < 1e-9, "{flags} {report:?}");
        }
        let counters = solver.counters().clone();
        let counts = (counters.analyses, counters.refreshes, counters.solves);
        assert_eq!(counts, (1, 3, 3));
        assert_eq!(counters.factorisations, 3);
        assert!(counters.iterations >= 3);
        if flags.is_empty() {
            assert!(counters.factor_nonzeros > matrix.nnz() as u64 / 2);
        } else {
            let again = solver.solve(matrix.view(), &rhs, &mut x).unwrap();
            assert_eq!(
                again.iterations, 0,
                "{flags}: a solution is its own start value"
            );
        }
    }
}

#[test]
fn solvers_with_different_flags_do_not_mix() {
    if missing() {
        return;
    }
    let matrix = grid_laplacian(9, 8, 0.1);
    let problem = positive_definite(&matrix, None, 1);
    let mut few = solver("petsc:-ksp_type cg -pc_type jacobi -ksp_max_it 2");
    let mut many = solver("petsc:-ksp_type cg -pc_type jacobi");
    for solver in [&mut few, &mut many] {
        solver.analyse(&problem).unwrap();
    }
    for solver in [&mut few, &mut many] {
        solver.refresh(matrix.view()).unwrap();
    }
    let (rhs, mut x) = (noisy_vector(72), vec![0.0; 72]);
    let stopped = few.solve(matrix.view(), &rhs, &mut x).unwrap_err();
    assert!(
        matches!(stopped, SolveError::NotConverged { .. }),
        "{stopped}"
    );
    x.fill(0.0);
    many.solve(matrix.view(), &rhs, &mut x).unwrap();
}

#[test]
fn the_tolerance_is_that_of_the_flag() {
    if missing() {
        return;
    }
    let cloud = jittered_grid(14, 11, 0.2);
    let matrix = wide_stencil(&cloud, 1, 2.3, 5);
    let problem = positive_definite(&matrix, Some(&cloud), 1);
    let spec = "petsc:-ksp_type cg -pc_type jacobi -ksp_rtol 1e-4";
    let (_, report) = solve(spec, &problem, &matrix);
    assert!((1e-7..1e-4).contains(&report.true_residual), "{report:?}");
    let wrong = "petsc:-ksp_rtol 2".parse::<SolverSpec>().unwrap().build();
    assert!(matches!(wrong.err(), Some(SpecError::InvalidValue { .. })));
}

#[test]
fn right_hand_sides_of_any_size_are_solved() {
    if missing() {
        return;
    }
    let matrix = grid_laplacian(4, 3, 0.0);
    for flags in ["", ":-ksp_type cg -pc_type jacobi"] {
        let mut solver = solver(&format!("petsc{flags}"));
        solver
            .analyse(&positive_definite(&matrix, None, 1))
            .unwrap();
        solver.refresh(matrix.view()).unwrap();
        for size in [1e200, 1e-200, 0.0] {
            let mut x = [1.0; 12];
            let report = solver.solve(matrix.view(), &[size; 12], &mut x).unwrap();
            assert!(
                report.true_residual < 1e-12 && x[0] >= 0.1 * size,
                "{flags} {report:?}"
            );
        }
        assert!(matches!(
            solver.solve(matrix.view(), &[f64::NAN; 12], &mut [0.0; 12]),
            Err(SolveError::NotFinite { row: 0, .. })
        ));
    }
}

/// Iterations on an intact matrix and, with its aggregates or afresh, on one with contrasts.
fn iterations(flags: &str, matrices: &[&CsrMatrix], cloud: &Cloud) -> (Vec<usize>, SolverCounters) {
    let mut solver = solver(&format!("petsc:-pc_type gamg {flags}"));
    let problem = positive_definite(matrices[0], Some(cloud), 1);
    solver.analyse(&problem).unwrap();
    let solve = |matrix: &&CsrMatrix| {
        solver.refresh(matrix.view()).unwrap();
        let (rhs, mut x) = (noisy_vector(matrix.rows()), vec![0.0; matrix.rows()]);
        let report = solver.solve(matrix.view(), &rhs, &mut x);
        report
            .unwrap_or_else(|error| panic!("{flags}: {error}"))
            .iterations
    };
    let counts = matrices.iter().map(solve).collect();
    (counts, solver.counters().clone())
}

#[test]
fn aggregates_are_kept_while_they_serve_and_made_anew_where_they_fail() {
    if missing() {
        return;
    }
    let cloud = jittered_grid(60, 40, 0.2);
    let intact = wide_stencil(&cloud, 1, 2.3, 5);
    let mut damaged = intact.clone();
    let soft = |point: usize| if noise(point / 7) < 0.0 { 1e-4 } else { 1.0 };
    damage(&mut damaged, |i, j| soft(i) * soft(j), |i| 0.05 * soft(i));
    let (kept, counters) = iterations("", &[&intact, &damaged], &cloud);
    assert_eq!(counters.factorisations, 2);
    let (fresh, _) = iterations("", &[&damaged], &cloud);
    assert!(
        kept[1] > fresh[0] && fresh[0] >= kept[0],
        "{kept:?} {fresh:?}"
    );
    let limit = format!("-ksp_max_it {}", fresh[0]);
    let (_, counters) = iterations(&limit, &[&intact, &damaged], &cloud);
    assert_eq!(counters.factorisations, 3);
    let by_user = "-pc_gamg_reuse_interpolation false";
    let (renewed, _) = iterations(by_user, &[&intact, &damaged], &cloud);
    assert_eq!(renewed[1], fresh[0]);
}
