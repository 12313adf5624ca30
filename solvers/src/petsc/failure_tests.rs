//! Mistakes and systems without a solution.

use super::tests::{missing, solver};
use super::*;
use crate::CsrMatrix;
use crate::test_support::*;

/// The error of a solver on a matrix that is said to be positive definite.
fn error(spec: &str, matrix: &CsrMatrix, symmetry: Symmetry) -> SolveError {
    let mut solver = solver(spec);
    let problem = Problem::new(matrix.view(), symmetry, 1);
    let rhs = noisy_vector(matrix.rows());
    let outcome = solver
        .analyse(&problem)
        .and_then(|()| solver.refresh(matrix.view()))
        .and_then(|()| solver.solve(matrix.view(), &rhs, &mut vec![0.0; matrix.rows()]));
    outcome.unwrap_err()
}

#[test]
fn mistakes_in_flags_are_named() {
    if missing() {
        return;
    }
    let matrix = grid_laplacian(4, 3, 0.0);
    let definite = Symmetry::PositiveDefinite;
    let unknown = error("petsc:-ksp_type cgg", &matrix, definite).to_string();
    assert!(unknown.contains("cgg"), "{unknown}");
    let unused = error(
        "petsc:-pc_type jacobi -pc_gamg_treshold 1 -ksp_view",
        &matrix,
        definite,
    );
    let expected = SolveError::UnusedFlags {
        solver: "petsc",
        flags: "-pc_gamg_treshold".into(),
    };
    assert_eq!(unused, expected);
}

#[test]
fn matrices_that_cannot_be_solved_are_named() {
    if missing() {
        return;
    }
    let mut matrix = grid_laplacian(5, 1, 0.0);
    matrix.data_mut()[0] = -1.0;
    let (definite, indefinite) = (Symmetry::PositiveDefinite, Symmetry::Indefinite);
    let negative = error("petsc", &matrix, definite);
    assert!(
        matches!(negative, SolveError::NotPositiveDefinite { row: 0, .. }),
        "{negative}"
    );
    let path = |diagonal: f64| {
        let mut matrix = grid_laplacian(5, 1, 0.0);
        for row in 0..5 {
            let place = matrix.nnz_index(row, row).unwrap().0;
            matrix.data_mut()[place] = diagonal;
        }
        matrix
    };
    let saddle = error("petsc:-ksp_type cg -pc_type jacobi", &path(0.5), definite);
    assert!(matches!(saddle, SolveError::Breakdown { .. }), "{saddle}");
    let mut singular = path(1.0);
    singular.data_mut().fill(1.0);
    let singular = CsrMatrix::new(
        (2, 2),
        vec![0, 2, 4],
        vec![0, 1, 0, 1],
        singular.data()[..4].to_vec(),
    );
    for flags in ["", ":-pc_type lu -pc_factor_mat_solver_type petsc"] {
        let pivot = error(&format!("petsc{flags}"), &singular, indefinite);
        let known = matches!(
            pivot,
            SolveError::Failed { .. } | SolveError::Inaccurate { .. }
        );
        assert!(known, "{flags} {pivot}");
    }
}

#[test]
fn stages_out_of_order_are_refused() {
    if missing() {
        return;
    }
    let matrix = grid_laplacian(4, 3, 0.0);
    let mut solver = solver("petsc");
    let stage = |outcome: Result<(), SolveError>| match outcome {
        Err(SolveError::NotAnalysed { missing, .. }) => missing,
        other => panic!("{other:?}"),
    };
    assert_eq!(stage(solver.refresh(matrix.view())), "analyse");
    solver
        .analyse(&positive_definite(&matrix, None, 1))
        .unwrap();
    let early = solver.solve(matrix.view(), &[1.0; 12], &mut [0.0; 12]);
    assert_eq!(stage(early.map(|_| ())), "refresh");
    let other = grid_laplacian(3, 4, 0.0);
    let changed = solver.refresh(other.view()).unwrap_err();
    assert!(matches!(changed, SolveError::PatternChanged { .. }));
}
