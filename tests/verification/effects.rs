//! What a scene does not name is not allocated, assembled or evaluated.

use crate::support::{run_case, run_text};

#[test]
fn a_flow_scene_holds_a_pressure_and_nothing_else() {
    let (summary, _) = run_case(
        "five-spot",
        &[
            "geometry.points=[20, 20]",
            "time.mode=steady",
            "flow.operator=correspondence",
        ],
    );
    let fields = &summary.counters.field_bytes;
    assert_eq!((fields.len(), fields["pressure"]), (1, 8 * 400));
    for absent in ["mechanics", "damage", "coupling", "gravity"] {
        assert_eq!(summary.counters.evaluations(absent), 0, "{absent}");
    }
    assert!(summary.counters.evaluations("wells") > 0);
    // No second hop: no gradient is stored.
    assert_eq!(summary.counters.bytes["operator"], 0);
}

#[test]
fn gravity_costs_one_vector_where_it_is_named_and_nothing_where_it_is_not() {
    let with = [
        "geometry.points=[10, 10, 6]",
        "time.end=10",
        "output.times=[]",
    ];
    let (heavy, _) = run_case("reservoir-3d", &with);
    let text = perifrac::cases::find("reservoir-3d").unwrap().scene;
    let light = text
        .replace("[gravity]\nacceleration = [0, 0, \"-9.81 m/s^2\"]\n", "")
        .replace("hydrostatic_start = true\n", "");
    assert!(!light.contains("gravity]"));
    let (light, _) = run_text(&light, &with);
    assert!(heavy.counters.evaluations("gravity") > 0);
    assert_eq!(light.counters.evaluations("gravity"), 0);
    let extra = heavy.counters.bytes["effects"] - light.counters.bytes["effects"];
    assert_eq!(extra, 8 * heavy.points, "one vector of the weight");
}

#[test]
fn explicit_steps_factor_nothing_and_evaluate_constant_loads_once() {
    let (summary, _) = run_case(
        "five-spot",
        &[
            "geometry.points=[20, 20]",
            "scheme.name=explicit",
            "time.end=1e-3",
            "output.times=[]",
        ],
    );
    assert!(summary.steps > 4);
    assert_eq!(summary.counters.solver.factorisations, 0);
    assert_eq!(
        summary.counters.evaluations("wells"),
        2,
        "two wells, once for all steps"
    );
}
