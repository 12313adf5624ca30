//! A solver takes time, not steps: where rock breaks, every backend takes the steps and passes that the
//! embedded factor takes, or refuses the matrix by name. Solves that fail hide behind steps that are cut.

use perifrac::run::{RunError, Summary};
use perifrac::schemes::StepError;
use perifrac_solvers::{BACKENDS, SolveError};

use crate::support::{plan_of_variant, try_run};

/// Smoke variants, shortened so that the weakest preconditioners end in seconds.
const SMOKE: [(&str, &[&str]); 4] = [
    (
        "natural-fractures",
        &[
            "geometry.spacing=3 cm",
            "damage.length_scale=4.5 cm",
            "time.end=0.01",
            "time.max_step=0.01",
            "output.times=[]",
        ],
    ),
    ("pressurised-notch", &["time.end=420 s", "output.times=[]"]),
    ("penny-3d", &["geometry.points=[7, 7, 7]"]),
    ("notched-tension", &["geometry.points=[20, 20]"]),
];

/// Specifications beyond the backends with their own choices: preconditioners that may lag behind.
const FURTHER: [&str; 1] = ["fgmres:preconditioner=schur"];

fn run(case: &str, overrides: &[&str], spec: &str) -> Result<Summary, RunError> {
    let mut plan = plan_of_variant(case, "smoke", overrides);
    plan.solver = spec.parse().unwrap();
    Ok(try_run(&plan)?.0)
}

/// Whether a backend is not for the matrix, or not there.
fn is_refusal(error: &RunError) -> bool {
    let RunError::Step { source, .. } = error else {
        return false;
    };
    match source {
        StepError::Solve(SolveError::Refused { .. } | SolveError::UnusedFlags { .. }) => true,
        StepError::Solve(SolveError::Unavailable { .. }) => {
            std::env::var_os("PERIFRAC_REQUIRE_PETSC").is_none()
        }
        _ => false,
    }
}

/// Steps, rejected ones, and passes of both kinds.
fn effort(summary: &Summary) -> [u64; 3] {
    let counters = &summary.counters;
    let passes = counters.coupling_iterations + counters.newton_iterations;
    [summary.steps, summary.rejected, passes]
}

#[test]
fn steps_and_passes_are_the_same_over_all_backends_within_a_fifth() {
    let mut solved = 0;
    for (case, overrides) in SMOKE {
        let expected = effort(&run(case, overrides, "faer-ldlt").unwrap());
        println!("{case}: {expected:?}");
        for spec in BACKENDS.iter().map(|backend| backend.name).chain(FURTHER) {
            let summary = match run(case, overrides, spec) {
                Ok(summary) => summary,
                Err(error) if is_refusal(&error) => continue,
                Err(error) => panic!("{case} by {spec}: {error}"),
            };
            let found = effort(&summary);
            println!("{case} by {spec}: {found:?}, {:.1} s", summary.wall_s);
            let fits = |(found, expected): (&u64, &u64)| *found as f64 <= 1.2 * *expected as f64;
            assert!(
                found.iter().zip(&expected).all(fits),
                "{case} by {spec}: {found:?}, with the factor {expected:?}"
            );
            solved += 1;
        }
    }
    assert!(solved >= 4 * 6, "{solved}");
}
