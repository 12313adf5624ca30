use super::complement::SelfComplement;
use super::split::Blocks;
use crate::test_support::*;
use crate::{Coordinates, LinearSolver, NearNullspace, Problem, SolveError, SolverSpec, Symmetry};

fn problem<'a>(matrix: &'a crate::CsrMatrix, cloud: &'a Cloud) -> Problem<'a> {
    Problem {
        coordinates: Some(Coordinates {
            dimension: 2,
            values: &cloud.coordinates,
        }),
        near_nullspace: NearNullspace::RigidModes,
        ..Problem::new(matrix.view(), Symmetry::QuasiDefinite, 3)
    }
}

fn solver(spec: &str) -> Box<dyn LinearSolver> {
    spec.parse::<SolverSpec>().unwrap().build().unwrap()
}

/// Iterations and error of one solve.
fn solved(spec: &str, problem: &Problem<'_>, matrix: &crate::CsrMatrix) -> (usize, f64) {
    let mut solver = solver(spec);
    solver.analyse(problem).unwrap();
    solver.refresh(matrix.view()).unwrap();
    let rhs = noisy_vector(matrix.rows());
    let mut x = vec![0.0; rhs.len()];
    let report = solver.solve(matrix.view(), &rhs, &mut x).unwrap();
    (
        report.iterations,
        relative_error(&x, &dense_solution(matrix, &rhs)),
    )
}

#[test]
fn blocks_are_separated_and_joined_without_loss() {
    let cloud = jittered_grid(7, 5, 0.2);
    let a = biot(&cloud, 1.0, 0.3);
    let mut blocks = Blocks::analyse(a.view(), 3);
    blocks.fill(a.view());
    for (value, (row, column)) in a.iter() {
        let (i, j) = ((row / 3) as usize, (column / 3) as usize);
        let (r, c) = ((row % 3) as usize, (column % 3) as usize);
        let found = match (r == 2, c == 2) {
            (false, false) => blocks.stiffness.get(2 * i + r, 2 * j + c).copied(),
            (false, true) => blocks.gradient.get(2 * i + r, j).copied(),
            (true, false) => blocks.divergence.get(i, 2 * j + c).copied(),
            (true, true) => blocks.storage.get(i, j).map(|own| -own),
        };
        assert_eq!(found.map(f64::to_bits), Some(value.to_bits()));
    }
    let whole = noisy_vector(a.rows());
    let (mut inner, mut last, mut back) = (vec![0.0; 70], vec![0.0; 35], vec![0.0; 105]);
    blocks.separate(&whole, &mut inner, &mut last);
    blocks.join(&inner, &last, &mut back);
    assert_eq!(whole, back);
}

/// C + B D⁻¹ Bᵀ entry by entry from the dense blocks.
#[test]
fn the_complement_is_that_of_the_point_blocks() {
    let cloud = jittered_grid(6, 5, 0.2);
    let a = biot(&cloud, 1.0, 0.3);
    let mut blocks = Blocks::analyse(a.view(), 3);
    blocks.fill(a.view());
    let found = SelfComplement::analyse(&blocks).matrix(&blocks);
    let get = |row: usize, column: usize| a.get(row, column).copied().unwrap_or(0.0);
    for i in 0..30 {
        for j in 0..30 {
            let mut expected = -get(3 * i + 2, 3 * j + 2);
            for point in 0..30 {
                let d = |r: usize, c: usize| get(3 * point + r, 3 * point + c);
                let determinant = d(0, 0) * d(1, 1) - d(0, 1) * d(1, 0);
                let inverse = [[d(1, 1), -d(0, 1)], [-d(1, 0), d(0, 0)]];
                for (r, row) in inverse.iter().enumerate() {
                    for (c, entry) in row.iter().enumerate() {
                        let left = get(3 * i + 2, 3 * point + r);
                        let right = get(3 * j + 2, 3 * point + c);
                        expected += left * entry / determinant * right;
                    }
                }
            }
            let own = found.get(i, j).copied().unwrap_or(0.0);
            assert!((own - expected).abs() < 1e-12, "{i} {j}: {own} {expected}");
        }
    }
}

#[test]
fn a_coupled_system_is_solved_in_few_iterations_and_by_inner_ones_in_fewer() {
    let cloud = jittered_grid(16, 14, 0.2);
    for storage in [0.3, 30.0] {
        let a = biot(&cloud, 1.0, storage);
        let problem = problem(&a, &cloud);
        let (once, error) = solved("gmres:preconditioner=schur", &problem, &a);
        assert!(once <= 60 && error < 1e-8, "{storage}: {once} {error}");
        let (inner, error) = solved("fgmres:preconditioner=schur,inner=4", &problem, &a);
        assert!(inner <= once && error < 1e-8, "{storage}: {inner} {error}");
    }
}

#[test]
fn a_given_storage_serves_instead_of_the_point_blocks() {
    let cloud = jittered_grid(16, 14, 0.2);
    let a = biot(&cloud, 1.0, 30.0);
    let given = vec![10.0; cloud.points()];
    let with = Problem {
        schur_diagonal: Some(&given),
        ..problem(&a, &cloud)
    };
    let (iterations, error) = solved("fgmres:preconditioner=fixed-stress", &with, &a);
    assert!(iterations <= 60 && error < 1e-8, "{iterations} {error}");
}

#[test]
fn what_cannot_work_is_refused_by_name() {
    let cloud = jittered_grid(6, 5, 0.2);
    let a = biot(&cloud, 1.0, 0.3);
    let problem = problem(&a, &cloud);
    let without = solver("fgmres:preconditioner=fixed-stress").analyse(&problem);
    let text = without.unwrap_err().to_string();
    assert!(text.contains("choose preconditioner=schur"), "{text}");
    let rigid = solver("gmres:preconditioner=schur,inner=3").analyse(&problem);
    let text = rigid.unwrap_err().to_string();
    assert!(text.contains("`fgmres`, or inner=1"), "{text}");
    let flow = grid_laplacian(6, 5, 0.0);
    let other = solver("gmres:preconditioner=schur").analyse(&positive_definite(&flow, None, 1));
    assert!(matches!(other, Err(SolveError::Refused { .. })));
}
