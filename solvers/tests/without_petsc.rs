//! A machine without PETSc: this program starts itself with the library hidden.

#![allow(clippy::unwrap_used)]

use std::process::Command;

use perifrac_solvers::{
    CsrMatrix, Problem, SolveError, SolverSpec, Symmetry, petsc_finish as finish, petsc_status,
    petsc_team,
};

/// Names the file of the library; here one that does not exist.
const PATH: &str = "PERIFRAC_PETSC";
const NOWHERE: &str = "/nonexistent/libpetsc.so";

#[test]
fn everything_else_works_and_the_error_names_the_remedy() {
    if std::env::var(PATH).as_deref() != Ok(NOWHERE) {
        let output = Command::new(std::env::current_exe().unwrap())
            .env(PATH, NOWHERE)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{told}");
        return;
    }
    let matrix = CsrMatrix::new((2, 2), vec![0, 1, 2], vec![0, 1], vec![2.0, 4.0]);
    let problem = Problem::new(matrix.view(), Symmetry::PositiveDefinite, 1);
    let mut solver = "petsc:-ksp_type cg"
        .parse::<SolverSpec>()
        .unwrap()
        .build()
        .unwrap();
    let missing = solver.analyse(&problem).unwrap_err();
    assert!(matches!(
        missing,
        SolveError::Unavailable {
            solver: "petsc",
            ..
        }
    ));
    let text = missing.to_string();
    assert!(
        text.contains(NOWHERE) && text.contains("apt-get install libpetsc-real-dev"),
        "{text}"
    );
    assert_eq!(petsc_status().unwrap_err(), missing);
    assert_eq!(petsc_team().unwrap_err(), missing);
    let mut solver = SolverSpec::default().build().unwrap();
    solver.analyse(&problem).unwrap();
    solver.refresh(matrix.view()).unwrap();
    let mut x = [0.0; 2];
    solver.solve(matrix.view(), &[1.0, 1.0], &mut x).unwrap();
    assert!((x[0] - 0.5).abs() < 1e-15);
    finish();
}
