//! Confined five-spot, Sec. 5.3 of the paper, against the exact lattice sum of image wells.

use crate::support::{largest_difference, run_case};

#[test]
fn steady_pressure_at_200_by_200_is_exact_to_2e_5_in_one_factorisation() {
    let (summary, _) = run_case("five-spot", &["time.mode=steady"]);
    assert_eq!(summary.points, 40_000);
    assert!(
        summary.errors["pressure"].max <= 2e-5,
        "{:?}",
        summary.errors
    );
    assert_eq!(summary.counters.solver.factorisations, 1);
    assert_eq!(summary.counters.solver.analyses, 1);
    assert_eq!(summary.steps, 0);
    assert!(summary.balance.mass <= 1e-10);
}

/// Where the field still moves, against images and modes: second order as in the steady state.
#[test]
fn the_transient_is_exact_to_second_order_at_every_output() {
    let errors = [25, 50].map(|across| {
        let grid = format!("geometry.points=[{across}, {across}]");
        let own = [
            "time.tolerance=1e-6",
            "time.end=0.02",
            "output.times=[0.002, 0.01]",
        ];
        let (summary, _) = run_case("five-spot", &[&own[..], &[&grid]].concat());
        let outputs = summary.errors_over_time.iter();
        let errors: Vec<f64> = outputs.map(|output| output.errors["pressure"].l2).collect();
        assert_eq!(errors.len(), 3, "{errors:?}");
        errors
    });
    for (coarse, fine) in errors[0].iter().zip(&errors[1]) {
        let order = (coarse / fine).log2();
        assert!(*fine < 2e-3 && order > 1.8, "{errors:?}");
    }
}

#[test]
fn the_adaptive_transient_ends_at_the_steady_field() {
    let grid = "geometry.points=[60, 60]";
    let (steady, at_rest) = run_case("five-spot", &[grid, "time.mode=steady"]);
    let (transient, end) = run_case("five-spot", &[grid]);
    let [low, high] = steady.pressure_range.unwrap();
    let range = high - low;
    let gap = largest_difference(&at_rest.pressure, &end.pressure) / range;
    assert!(gap <= 1e-6, "{gap:.2e}");
    assert!(transient.balance.mass <= 1e-10);
    // A factor serves many steps: it is renewed only when the step changes.
    let solver = &transient.counters.solver;
    assert!(
        solver.factorisations * 2 < transient.steps + transient.rejected,
        "{solver:?}"
    );
    // One for the scheme, one for the step across the run that finds the range.
    assert_eq!(solver.analyses, 2);
}

#[test]
fn explicit_and_implicit_agree_at_a_given_time() {
    let common = [
        "geometry.points=[50, 50]",
        "time.end=2e-3",
        "output.times=[]",
    ];
    let explicit = [&common[..], &["scheme.name=explicit", "time.step=1e-6"]].concat();
    let implicit = [&common[..], &["time.step=2e-6"]].concat();
    let (summary, fine) = run_case("five-spot", &explicit);
    let (_, other) = run_case("five-spot", &implicit);
    let [low, high] = summary.pressure_range.unwrap();
    let range = high - low;
    let gap = |state: &perifrac::schemes::State| {
        largest_difference(&state.pressure, &other.pressure) / range
    };
    // Forward Euler is first order: extrapolated from two steps it meets TR-BDF2 to 1e-6.
    let finer = [&common[..], &["scheme.name=explicit", "time.step=5e-7"]].concat();
    let (_, mut finest) = run_case("five-spot", &finer);
    assert!(gap(&finest) < 0.55 * gap(&fine), "first order");
    for (half, whole) in finest.pressure.iter_mut().zip(&fine.pressure) {
        *half = 2.0 * *half - whole;
    }
    assert!(gap(&finest) <= 1e-6, "{:.2e}", gap(&finest));
    assert_eq!(summary.counters.solver.factorisations, 0);
}

#[test]
fn the_bond_operator_is_the_correspondence_operator_on_a_uniform_lattice() {
    // With c = 1 = D/2 and isotropic families the second hop vanishes (docs/theory.md).
    let grid = ["geometry.points=[40, 40]", "time.mode=steady"];
    let of = |operator: &str| {
        let operator = format!("flow.operator={operator}");
        run_case("five-spot", &[&grid[..], &[operator.as_str()]].concat())
    };
    let (correspondence, a) = of("correspondence");
    let (bond, b) = of("bond");
    assert_eq!(correspondence.second_hops, 0);
    assert_eq!(correspondence.nonzeros, bond.nonzeros);
    assert!(
        largest_difference(&a.pressure, &b.pressure) < 1e-6,
        "of 1.7e7 Pa"
    );
}
