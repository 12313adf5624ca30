//! What a plan promises before anything is built, against what the run then holds.

use perifrac::explain::{Explanation, explain};

use crate::support::{plan, try_run};

fn compare(case: &str, overrides: &[&str]) {
    let plan = plan(case, overrides);
    let told: Explanation = explain(&plan).unwrap();
    let (summary, _) = try_run(&plan).unwrap();
    let within = |what: &str, told: f64, found: f64, factor: f64| {
        let ratio = told / found;
        assert!(
            ratio < factor && ratio > 1.0 / factor,
            "{case} {what}: told {told:.3e}, found {found:.3e}"
        );
    };
    assert_eq!(told.points, summary.points);
    within("bonds", told.bonds as f64, summary.bonds as f64, 1.05);
    within(
        "nonzeros",
        told.nonzeros as f64,
        summary.nonzeros as f64,
        1.15,
    );
    assert_eq!(told.unknowns, summary.unknowns);
    let mechanics = summary.counters.mechanics.as_ref();
    let factor = summary.counters.solver.factor_bytes + mechanics.map_or(0, |m| m.factor_bytes);
    let factor = factor as f64;
    within("factor", told.memory.factor as f64, factor, 2.0);
    if let Some(limit) = &summary.limit {
        within("limit", told.limits[0].dt, limit.dt, 1.05);
    }
}

#[test]
fn sizes_told_by_the_plan_are_those_of_the_run() {
    compare("five-spot", &["time.mode=steady"]);
    compare(
        "five-spot",
        &[
            "time.mode=steady",
            "flow.hourglass=0.5",
            "geometry.points=[90, 90]",
        ],
    );
    compare(
        "five-spot",
        &["time.mode=steady", "solver.name=faer-cg:preconditioner=amg"],
    );
    compare(
        "reservoir-3d",
        &["time.end=100", "time.step=100", "output.times=[]"],
    );
    for scheme in ["scheme.name=monolithic", "scheme.name=staggered"] {
        compare(
            "terzaghi",
            &[scheme, "time.end=2", "time.step=1", "output={times=[]}"],
        );
    }
}
