//! A well in the unbounded plane against the Theis solution.

use crate::support::run_case;

#[test]
fn pressure_around_a_well_over_time() {
    let (summary, _) = run_case("theis", &["geometry.points=[60, 60]", "output.times=[]"]);
    let error = summary.errors["pressure"];
    assert!(error.l2 < 2e-4 && error.max < 2e-3, "{error:?}");
    assert!(summary.balance.mass < 1e-12);
    // A quarter of the rate enters the quarter of the plane.
    let quarter = 0.25 * 1e-4 * summary.t_end;
    assert!((summary.balance.injected / quarter - 1.0).abs() < 1e-12);
}
