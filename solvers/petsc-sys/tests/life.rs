//! PETSc from start to end, in one process without `mpirun`.

#![allow(clippy::unwrap_used)]

use perifrac_petsc_sys::{
    Comm, Failure, Gather, Kind, Matrix, Parked, PetscError, Rows, Solver, Vector, finish, run,
};

/// Set where PETSc must be there.
const REQUIRED: &str = "PERIFRAC_REQUIRE_PETSC";

/// A tridiagonal matrix of the second difference.
fn matrix(size: usize, kind: Kind) -> Result<Parked<Matrix>, PetscError> {
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..size {
        for column in row.saturating_sub(1)..(row + 2).min(size) {
            columns.push(column as i32);
            values.push(if row == column { 2.0 } else { -1.0 });
        }
        starts.push(columns.len() as i32);
    }
    run(|session| {
        let rows = Rows {
            starts: &starts,
            columns: &columns,
            size,
            block: 1,
        };
        let mut matrix = Matrix::new(session, Comm::Own, &rows, kind)?;
        matrix.set_values(&values)?;
        Ok(Parked::new(session, matrix))
    })?
}

fn solve(matrix: &mut Parked<Matrix>, options: &str) -> Result<(Vec<f64>, usize), PetscError> {
    run(|session| {
        let mut solver = Solver::new(session, Comm::Own, &[], options)?;
        solver.set_matrix(matrix.get(session))?;
        solver.configure()?;
        solver.set_tolerance(1e-13)?;
        assert_eq!(solver.set_up()?, None);
        let mut rhs = Vector::new(session, Comm::Own, 8, 1)?;
        let mut x = Vector::new(session, Comm::Own, 8, 1)?;
        rhs.set(&[1.0; 8])?;
        let outcome = solver.solve(&rhs, &mut x)?;
        assert_eq!(outcome.failure, None);
        let mut values = vec![0.0; 8];
        x.get(&mut values)?;
        assert_eq!(solver.unused_flags()?, Vec::<String>::new());
        Ok((values, outcome.iterations))
    })?
}

fn one_thread_serves_all(exact: &[f64]) {
    std::thread::scope(|scope| {
        for options in [
            "-ksp_type cg -pc_type jacobi",
            "-ksp_type preonly -pc_type lu",
        ] {
            scope.spawn(move || {
                let mut matrix = matrix(8, Kind::PositiveDefinite).unwrap();
                let (x, _) = solve(&mut matrix, options).unwrap();
                for (found, exact) in x.iter().zip(exact) {
                    assert!((found - exact).abs() < 1e-12, "{options}: {x:?}");
                }
            });
        }
    });
}

fn errors_come_back_as_values() {
    let mut matrix = matrix(8, Kind::General).unwrap();
    let error = solve(&mut matrix, "-ksp_type nonsense").unwrap_err();
    let PetscError::Call {
        function, message, ..
    } = &error
    else {
        unreachable!("{error}")
    };
    assert_eq!(*function, "KSPSetFromOptions");
    assert!(message.contains("nonsense"), "{message}");
    let unused = run(|session| {
        let options = "-pc_type jacobi -pc_gamg_threshold 0.1";
        let mut solver = Solver::new(session, Comm::Own, &[], options)?;
        solver.set_matrix(matrix.get(session))?;
        solver.configure()?;
        solver.set_up()?;
        solver.unused_flags()
    });
    assert_eq!(unused.unwrap().unwrap(), ["pc_gamg_threshold"]);
}

fn failures_have_names() {
    let failure = run(|session| {
        let rows = Rows {
            starts: &[0, 2, 4],
            columns: &[0, 1, 0, 1],
            size: 2,
            block: 1,
        };
        let mut matrix = Matrix::new(session, Comm::Own, &rows, Kind::Symmetric)?;
        matrix.set_values(&[1.0, 1.0, 1.0, 1.0])?;
        let options = "-ksp_type preonly -pc_type lu";
        let mut solver = Solver::new(session, Comm::Own, &[], options)?;
        solver.set_matrix(&matrix)?;
        solver.configure()?;
        solver.set_up()
    });
    assert_eq!(failure.unwrap().unwrap(), Some(Failure::ZeroPivot));
}

fn wrong_input_is_refused() {
    for (starts, columns) in [
        (&[0, 1, 1][..], &[0, 1][..]),
        (&[0, 2, 1, 2], &[0, 1]),
        (&[0, 1, 2], &[0, 2]),
        (&[0, 2, 2], &[1, 0]),
        (&[0, 1], &[0]),
    ] {
        let rows = Rows {
            starts,
            columns,
            size: 2,
            block: 1,
        };
        let made = run(|session| Matrix::new(session, Comm::Own, &rows, Kind::General).map(drop));
        assert!(
            matches!(made, Ok(Err(PetscError::Input(_)))),
            "{starts:?} {columns:?}"
        );
    }
}

fn a_team_of_one_gathers_its_own() {
    let all = run(|session| {
        let mut all = [0.0; 3];
        Gather::new(session, 3)?.gather(&[1.0, 2.0, 3.0], &mut all)?;
        Ok::<_, PetscError>(all)
    });
    assert_eq!(all.unwrap().unwrap().map(|value| value as i32), [1, 2, 3]);
}

#[test]
fn petsc_works_from_start_to_end() {
    let info = match run(|session| session.info().clone()) {
        Ok(info) => info,
        Err(reason) => {
            assert!(
                std::env::var_os(REQUIRED).is_none(),
                "{REQUIRED} is set, but {reason}"
            );
            eprintln!("skipped: {reason}");
            return;
        }
    };
    assert!(
        info.version.starts_with("3.") && info.path.contains("petsc"),
        "{info:?}"
    );
    assert_eq!((info.rank, info.size), (0, 1));
    let exact: Vec<f64> = (1..9).map(|i| 0.5 * f64::from(i * (9 - i))).collect();
    one_thread_serves_all(&exact);
    errors_come_back_as_values();
    failures_have_names();
    wrong_input_is_refused();
    a_team_of_one_gathers_its_own();
    let kept = matrix(8, Kind::General).unwrap();
    finish();
    assert_eq!(run(|_| ()), Err(PetscError::Finished));
    drop(kept);
    finish();
}
