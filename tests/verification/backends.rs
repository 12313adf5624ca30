//! Every backend gives the same field for every bundled case, or refuses by name.
//!
//! Small versions of the cases with a few constant steps: the sequence of steps must not depend on
//! rounding, since the fields are compared to 1e-8 of their range.

use perifrac::run::RunError;
use perifrac::schemes::{State, StepError};
use perifrac_solvers::{BACKENDS, OptionValue, PRECONDITIONERS, SolveError};

use crate::support::{plan, try_run};

/// Case and overrides that make it small; those in which rock breaks end their iterations at a balance
/// of forces, not at 1e-8 of the fields.
const CASES: [(&str, &[&str]); 15] = [
    ("five-spot", &["geometry.points=[24, 24]", "time.step=0.05"]),
    ("two-layer", &["time.step=0.02"]),
    (
        "channel",
        &[
            "geometry.points=[21, 21]",
            "materials.channel.region.min=[0, 0.47619]",
            "materials.channel.region.max=[1, 0.52381]",
            "time.step=100",
        ],
    ),
    (
        "heterogeneous",
        &["geometry.points=[24, 24]", "time.step=1000"],
    ),
    (
        "reservoir-3d",
        &["geometry.points=[9, 9, 5]", "time.step=5e4"],
    ),
    ("theis", &["geometry.points=[24, 24]", "time.step=0.5"]),
    ("terzaghi", &["geometry.spacing=0.25", "time.step=20"]),
    (
        "terzaghi-graded",
        &["geometry.spacing=0.25", "time.step=30"],
    ),
    (
        "terzaghi-tensor",
        &[
            "geometry.axes=[[{length=15, spacing=[0.1, 0.4]}], [{length=1, spacing=0.1}]]",
            "time.step=30",
        ],
    ),
    ("column-3d", &["geometry.spacing=0.2", "time.step=5"]),
    ("mandel", &["time.step=0.1"]),
    ("footing", &["geometry.spacing=0.4", "time.step=2e5"]),
    ("layers-stiffness", &[]),
    ("sneddon", &["geometry.spacing=0.025"]),
    (
        "manufactured",
        &["geometry.points=[16, 16]", "time.step=0.1"],
    ),
];

/// One specification per backend, and one per preconditioner of those that take one; the weakest ones
/// do without the hard cases they would need thousands of iterations for.
fn specs() -> Vec<String> {
    let mut specs = Vec::new();
    for backend in BACKENDS {
        let takes = backend
            .options
            .iter()
            .find(|option| option.key == "preconditioner");
        match takes.map(|option| option.value) {
            Some(OptionValue::OneOf(words)) => {
                let strong = words.iter().filter(|word| !WEAK.contains(word));
                specs.extend(strong.map(|word| format!("{}:preconditioner={word}", backend.name)));
            }
            _ => specs.push(backend.name.to_owned()),
        }
    }
    specs.extend(FLAGS.map(str::to_owned));
    specs
}

/// Preconditioners whose iterations grow without bound on hard cases; the tests of the crate of
/// solvers hold them against exact solutions.
const WEAK: [&str; 5] = ["none", "jacobi", "block-jacobi", "ic0", "ilu0"];

/// PETSc with methods of its own.
const FLAGS: [&str; 4] = [
    "petsc:-ksp_type cg -pc_type gamg",
    "petsc:-ksp_type cg -pc_type hypre",
    "petsc:-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps",
    "petsc:-ksp_type fgmres -pc_type fieldsplit",
];

/// What a run may end with instead of a field: a refusal, PETSc's absence where it may be absent, or
/// an iteration that says it did not converge.
fn is_refusal(error: &RunError) -> bool {
    let RunError::Step { source, .. } = error else {
        return false;
    };
    match source {
        StepError::Solve(error) => match error {
            SolveError::Refused { .. }
            | SolveError::UnusedFlags { .. }
            | SolveError::External { .. }
            | SolveError::Failed { .. }
            | SolveError::NotConverged { .. }
            | SolveError::Stagnated { .. }
            | SolveError::Breakdown { .. }
            | SolveError::IncompletePivot { .. } => true,
            SolveError::Unavailable { .. } => std::env::var_os("PERIFRAC_REQUIRE_PETSC").is_none(),
            _ => false,
        },
        _ => false,
    }
}

/// Largest difference of a field relative to its range, the zero included.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    let range = expected.iter().fold(0.0_f64, |m, value| m.max(value.abs()));
    let pairs = found.iter().zip(expected);
    let largest = pairs.fold(0.0_f64, |m, (f, e)| m.max((f - e).abs()));
    if range > 0.0 {
        largest / range
    } else {
        largest
    }
}

fn run(case: &str, overrides: &[&str], spec: &str) -> Result<State, RunError> {
    let mut plan = plan(case, overrides);
    plan.solver = spec.parse().unwrap();
    Ok(try_run(&plan)?.1)
}

#[test]
fn every_backend_gives_the_same_fields_for_every_bundled_case_or_refuses_by_name() {
    let mut solved: Vec<(String, usize)> = specs().into_iter().map(|spec| (spec, 0)).collect();
    for (case, overrides) in CASES {
        let expected =
            run(case, overrides, "auto").unwrap_or_else(|error| panic!("{case}: {error}"));
        for (spec, count) in &mut solved {
            let state = match run(case, overrides, spec) {
                Ok(state) => state,
                Err(error) if is_refusal(&error) => continue,
                Err(error) => panic!("{case} by {spec}: {error}"),
            };
            let pressure = difference(&state.pressure, &expected.pressure);
            let displacement = difference(&state.displacement, &expected.displacement);
            assert!(
                pressure < 1e-8 && displacement < 1e-8,
                "{case} by {spec}: pressure {pressure:e}, displacement {displacement:e}"
            );
            *count += 1;
        }
    }
    let least = |spec: &str, count: usize| {
        let own = solved.iter().find(|(name, _)| name == spec).unwrap();
        assert!(own.1 >= count, "{spec} solved {} cases", own.1);
    };
    // Seven cases of flow alone, six coupled ones in one system.
    least("auto", 13);
    least("faer-ldlt", 13);
    least("faer-llt", 7);
    least("faer-cg:preconditioner=amg", 7);
    least("faer-cg:preconditioner=f32", 7);
    least("gmres:preconditioner=f32", 13);
    least("fgmres:preconditioner=schur", 5);
    assert!(PRECONDITIONERS.len() >= 10);
}

/// The same for the two fields in turn, where mechanics has a positive definite system of its own.
#[test]
fn mechanics_in_turn_with_flow_gives_the_same_fields_by_multigrid() {
    let overrides = [
        "geometry.spacing=0.25",
        "time.step=20",
        "scheme.name=staggered",
    ];
    let expected = run("terzaghi", &overrides, "faer-llt").unwrap();
    for spec in [
        "faer-cg:preconditioner=amg",
        "minres:preconditioner=amg",
        "faer-cg:preconditioner=f32",
    ] {
        let state = run("terzaghi", &overrides, spec).unwrap();
        assert!(
            difference(&state.pressure, &expected.pressure) < 1e-8,
            "{spec}"
        );
        assert!(
            difference(&state.displacement, &expected.displacement) < 1e-8,
            "{spec}"
        );
    }
}
