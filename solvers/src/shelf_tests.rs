//! The whole shelf: every backend with every preconditioner on every kind of system.

use crate::test_support::*;
use crate::{
    BACKENDS, Backend, Coordinates, CsrMatrix, OptionValue, Problem, SolveError, SolverSpec,
    Symmetry,
};

/// A small system of one kind.
struct Case {
    name: &'static str,
    matrix: CsrMatrix,
    cloud: Cloud,
    symmetry: Symmetry,
    per_point: usize,
    schur_diagonal: Vec<f64>,
}

impl Case {
    fn problem(&self) -> Problem<'_> {
        Problem {
            coordinates: Some(Coordinates {
                dimension: 2,
                values: &self.cloud.coordinates,
            }),
            schur_diagonal: (!self.schur_diagonal.is_empty()).then_some(&self.schur_diagonal),
            ..Problem::new(self.matrix.view(), self.symmetry, self.per_point)
        }
    }

    fn with(self, symmetry: Symmetry, matrix: CsrMatrix) -> Self {
        Self {
            symmetry,
            matrix,
            ..self
        }
    }
}

fn flow(name: &'static str) -> Case {
    let cloud = jittered_grid(14, 11, 0.3);
    Case {
        name,
        matrix: wide_stencil(&cloud, 1, 2.5, 1),
        cloud,
        symmetry: Symmetry::PositiveDefinite,
        per_point: 1,
        schur_diagonal: Vec::new(),
    }
}

fn cases() -> Vec<Case> {
    let cloud = jittered_grid(11, 9, 0.2);
    let mut shifted = grid_laplacian(14, 11, 0.0);
    // Between the eigenvalues of the grid: some are negative now, none is near zero.
    add_to_diagonal(&mut shifted, |_| -0.55);
    vec![
        flow("flow"),
        Case {
            name: "elasticity",
            matrix: wide_stencil(&cloud, 2, 2.3, 2),
            cloud: jittered_grid(11, 9, 0.2),
            symmetry: Symmetry::PositiveDefinite,
            per_point: 2,
            schur_diagonal: Vec::new(),
        },
        Case {
            name: "poroelasticity",
            matrix: biot(&cloud, 1.0, 0.3),
            cloud,
            symmetry: Symmetry::QuasiDefinite,
            per_point: 3,
            schur_diagonal: vec![10.0; 99],
        },
        flow("indefinite").with(Symmetry::Indefinite, shifted),
        flow("transport").with(Symmetry::General, transport(14, 11)),
    ]
}

/// Every specification of a backend: one for each preconditioner if it takes any.
fn specs(backend: &Backend) -> Vec<String> {
    let words = backend
        .options
        .iter()
        .find_map(|option| match option.value {
            OptionValue::OneOf(words) if option.key == "preconditioner" => Some(words),
            _ => None,
        });
    words.map_or_else(
        || vec![backend.name.to_owned()],
        |words| {
            let spec = |word: &&str| format!("{}:preconditioner={word}", backend.name);
            words.iter().map(spec).collect()
        },
    )
}

fn every_spec() -> Vec<String> {
    BACKENDS.iter().flat_map(specs).collect()
}

#[test]
fn every_backend_and_preconditioner_solves_or_refuses_by_name() {
    for case in cases() {
        let (problem, rhs) = (case.problem(), noisy_vector(case.matrix.rows()));
        let exact = dense_solution(&case.matrix, &rhs);
        let mut solved = Vec::new();
        for spec in every_spec() {
            let backend = Backend::find(spec.split(':').next().unwrap()).unwrap();
            let place = format!("{spec} on {}", case.name);
            let mut solver = match ready(&spec, &problem) {
                Ok(solver) => solver,
                Err(SolveError::Refused { solver, .. }) => {
                    assert_eq!(solver, backend.name, "{place}");
                    continue;
                }
                Err(SolveError::Unavailable { .. }) if !petsc_is_required() => continue,
                Err(other) => panic!("{place}: {other}"),
            };
            assert!(backend.symmetries.contains(&case.symmetry), "{place}");
            let mut x = vec![0.0; rhs.len()];
            let report = solver.solve(case.matrix.view(), &rhs, &mut x);
            let report = report.unwrap_or_else(|error| panic!("{place}: {error}"));
            assert!(report.true_residual <= 1e-11, "{place}: {report:?}");
            assert!(relative_error(&x, &exact) < 1e-8, "{place}");
            assert!(report.iterations <= 4 * rhs.len(), "{place}: {report:?}");
            let counters = solver.counters();
            let counted = [counters.analyses, counters.refreshes, counters.solves];
            assert_eq!(counted, [1, 1, 1], "{place}");
            let steps = counters.iterations + counters.refinements;
            assert_eq!(steps, report.iterations as u64, "{place}");
            solved.push(spec);
        }
        let least = match case.symmetry {
            Symmetry::PositiveDefinite => 30,
            Symmetry::QuasiDefinite => 24,
            Symmetry::Indefinite => 16,
            Symmetry::General => 13,
        };
        assert!(solved.len() >= least, "{}: {solved:?}", case.name);
    }
}

#[test]
fn a_correction_takes_no_more_digits_than_it_is_asked_for() {
    let case = flow("flow");
    let rhs = noisy_vector(case.matrix.rows());
    for spec in every_spec() {
        let Ok(mut solver) = ready(&spec, &case.problem()) else {
            continue;
        };
        let mut run = |tolerance| {
            let mut x = vec![0.0; rhs.len()];
            let report = solver.solve_to(case.matrix.view(), &rhs, &mut x, tolerance);
            let report = report.unwrap_or_else(|error| panic!("{spec}: {error}"));
            (report.iterations, report.true_residual)
        };
        let (full, rough, again) = (run(0.0), run(1e-3), run(0.0));
        assert!(rough.1 <= 1e-3 && rough.0 <= full.0, "{spec}: {rough:?}");
        if full.0 > 6 {
            assert!(3 * rough.0 <= 2 * full.0, "{spec}: {rough:?} {full:?}");
        }
        // The solver's own tolerance has come back.
        assert!(again.1 <= 1e-11, "{spec}: {again:?}");
    }
}

/// On systems large enough that vectors and rows are shared out.
#[test]
fn bits_are_equal_for_one_two_and_three_threads() {
    let cloud = jittered_grid(72, 70, 0.3);
    let flow = Case {
        name: "flow",
        matrix: wide_stencil(&cloud, 1, 2.3, 1),
        cloud,
        symmetry: Symmetry::PositiveDefinite,
        per_point: 1,
        schur_diagonal: Vec::new(),
    };
    let cloud = jittered_grid(40, 35, 0.2);
    let poroelasticity = Case {
        name: "poroelasticity",
        matrix: biot(&cloud, 1.0, 0.3),
        cloud,
        symmetry: Symmetry::QuasiDefinite,
        per_point: 3,
        schur_diagonal: Vec::new(),
    };
    for case in [flow, poroelasticity] {
        let rhs = noisy_vector(case.matrix.rows());
        for mut spec in every_spec().into_iter().filter(|spec| spec != "faer-lu") {
            if spec.contains(':') {
                // Whether it converges does not matter here.
                spec += ",max_iterations=30";
            }
            let bits = |threads| {
                in_pool(threads, || {
                    let mut x = vec![0.0; rhs.len()];
                    let mut solver = ready(&spec, &case.problem()).ok()?;
                    let outcome = solver.solve(case.matrix.view(), &rhs, &mut x);
                    let size = outcome.map_or(-1.0, |report| report.scaled_residual);
                    x.push(size);
                    Some(x.iter().map(|value| value.to_bits()).collect::<Vec<_>>())
                })
            };
            let single = bits(1);
            assert_eq!(single, bits(2), "{spec} on {}", case.name);
            assert_eq!(single, bits(3), "{spec} on {}", case.name);
        }
    }
}

#[test]
fn a_warm_start_from_the_solution_takes_no_iteration() {
    let case = flow("flow");
    let (problem, rhs) = (case.problem(), noisy_vector(case.matrix.rows()));
    for spec in every_spec().iter().filter(|spec| spec.contains(':')) {
        let Ok(mut solver) = ready(spec, &problem) else {
            continue;
        };
        let mut x = vec![0.0; rhs.len()];
        solver.solve(case.matrix.view(), &rhs, &mut x).unwrap();
        let again = solver.solve(case.matrix.view(), &rhs, &mut x).unwrap();
        assert_eq!(again.iterations, 0, "{spec}");
        let zero = solver.solve(case.matrix.view(), &vec![0.0; rhs.len()], &mut x);
        assert_eq!(zero.unwrap().iterations, 0, "{spec}");
        assert!(x.iter().all(|value| value.abs() == 0.0), "{spec}");
    }
}

/// What a matrix without a solution ends in, whatever the backend.
fn is_named(error: &SolveError) -> bool {
    matches!(
        error,
        SolveError::Refused { .. }
            | SolveError::Singular { .. }
            | SolveError::NotPositiveDefinite { .. }
            | SolveError::ZeroPivot { .. }
            | SolveError::IncompletePivot { .. }
            | SolveError::Inaccurate { .. }
            | SolveError::NotConverged { .. }
            | SolveError::Stagnated { .. }
            | SolveError::Breakdown { .. }
    )
}

/// The error of a full run through a solver.
fn failure(spec: &str, problem: &Problem<'_>, rhs: &[f64]) -> Option<SolveError> {
    let mut x = vec![0.0; rhs.len()];
    let outcome = ready(spec, problem)
        .and_then(|mut solver| solver.solve(problem.pattern, rhs, &mut x).map(|_| ()));
    outcome.err()
}

#[test]
fn a_singular_matrix_without_solution_is_an_error_everywhere() {
    // A body that nothing holds, drawn to one side.
    let mut free = flow("free body");
    damage(&mut free.matrix, |_, _| 1.0, |_| 0.0);
    let rhs = vec![1.0; free.matrix.rows()];
    for symmetry in [
        Symmetry::PositiveDefinite,
        Symmetry::Indefinite,
        Symmetry::General,
    ] {
        let problem = Problem {
            symmetry,
            ..free.problem()
        };
        for spec in every_spec() {
            let error = failure(&spec, &problem, &rhs);
            assert!(error.as_ref().is_some_and(is_named), "{spec}: {error:?}");
        }
    }
}

#[test]
fn an_indefinite_matrix_said_to_be_definite_is_an_error_or_solved() {
    let mut wrong = flow("wrong").with(Symmetry::PositiveDefinite, grid_laplacian(14, 11, -0.55));
    wrong.name = "indefinite";
    let rhs = noisy_vector(wrong.matrix.rows());
    let exact = dense_solution(&wrong.matrix, &rhs);
    for spec in every_spec() {
        let mut x = vec![0.0; rhs.len()];
        let outcome = ready(&spec, &wrong.problem())
            .and_then(|mut solver| solver.solve(wrong.matrix.view(), &rhs, &mut x).map(|_| ()));
        match outcome {
            Ok(()) => assert!(relative_error(&x, &exact) < 1e-8, "{spec}"),
            Err(error) => assert!(is_named(&error), "{spec}: {error}"),
        }
    }
}

#[test]
fn numbers_that_are_none_are_refused_everywhere() {
    for case in cases() {
        let rhs = noisy_vector(case.matrix.rows());
        for spec in every_spec() {
            let mut solver = spec.parse::<SolverSpec>().unwrap().build().unwrap();
            if solver.analyse(&case.problem()).is_err() {
                continue;
            }
            let mut broken = case.matrix.clone();
            broken.data_mut()[5] = f64::NAN;
            let error = solver.refresh(broken.view()).unwrap_err();
            assert!(matches!(error, SolveError::NotFinite { .. }), "{spec}");
            solver.refresh(case.matrix.view()).unwrap();
            let mut bad = rhs.clone();
            bad[3] = f64::INFINITY;
            let error = solver.solve(case.matrix.view(), &bad, &mut vec![0.0; rhs.len()]);
            assert!(matches!(error, Err(SolveError::NotFinite { .. })), "{spec}");
        }
    }
}

#[test]
fn an_iteration_count_that_is_too_small_is_named_with_the_true_residual() {
    let case = flow("flow");
    let rhs = noisy_vector(case.matrix.rows());
    for name in ["faer-cg", "minres", "gmres", "fgmres", "bicgstab"] {
        let spec = format!("{name}:max_iterations=4");
        let mut solver = ready(&spec, &case.problem()).unwrap();
        let mut x = vec![0.0; rhs.len()];
        let error = solver.solve(case.matrix.view(), &rhs, &mut x).unwrap_err();
        let SolveError::NotConverged {
            iterations,
            residual,
            ..
        } = error
        else {
            panic!("{name}: {error}");
        };
        let mut r = vec![0.0; rhs.len()];
        crate::residual(case.matrix.view(), &x, &rhs, &mut r);
        assert_eq!(iterations, 4, "{name}");
        let true_residual = crate::norm2(&r) / crate::norm2(&rhs);
        assert!((residual - true_residual).abs() < 1e-14, "{name}");
    }
}

/// Where PETSc must be there, its absence is a failure.
fn petsc_is_required() -> bool {
    std::env::var_os("PERIFRAC_REQUIRE_PETSC").is_some()
}

#[test]
fn an_interrupted_backend_neither_factorises_nor_solves() {
    let case = flow("flow");
    let rhs = noisy_vector(case.matrix.rows());
    for backend in BACKENDS
        .iter()
        .filter(|own| own.name != "petsc" && own.name != "auto" && !own.lattices_only)
    {
        let mut solver = ready(backend.name, &case.problem()).unwrap();
        let interrupt = crate::Interrupt::default();
        interrupt.raise();
        let mut x = vec![0.0; rhs.len()];
        let stopped = interrupt.during(|| {
            let solved = solver.solve(case.matrix.view(), &rhs, &mut x).map(|_| ());
            [solved, solver.refresh(case.matrix.view())]
        });
        assert_eq!(stopped[0], Err(SolveError::Interrupted), "{}", backend.name);
        assert_eq!(stopped[1], Err(SolveError::Interrupted), "{}", backend.name);
        solver.refresh(case.matrix.view()).unwrap();
        solver.solve(case.matrix.view(), &rhs, &mut x).unwrap();
    }
}
