//! Which diffusion operator a scene gets, and what is left of a uniform flow with the bond operator.

use perifrac::model::{Model, ModelError};
use perifrac::report::Timers;
use perifrac::run::Summary;

use crate::support::{flow_model, plan_of, plan_of_variant, run_text, square};

/// The percentage in the warning about a uniform flow.
fn warned(summary: &Summary) -> Option<f64> {
    let starts = "a uniform flow is off by ";
    let text = summary.warnings.iter().find_map(|w| w.split_once(starts));
    text.map(|(_, rest)| rest.split(' ').next().unwrap().parse().unwrap())
}

#[test]
fn the_bond_operator_tells_how_far_a_uniform_flow_is_off() {
    let run = |sets: &[&str]| run_text(&square(40), &[&["flow.operator=bond"], sets].concat()).0;
    let blocks = r#"geometry={type="blocks", size=[1, 1], spacing=0.05, refine=[{levels=2, region={type="box", min=[0, 0], max=[0.3, 1]}}]}"#;
    for sets in [
        &["geometry.jitter=0.1"][..],
        &["geometry.jitter=0.3"],
        &["geometry.jitter=0.3", "horizon.ratio=3"],
        &[
            "geometry.jitter=0.4",
            "flow.boundary={bottom={pressure=1}, top={pressure=0}}",
        ],
        &[blocks],
    ] {
        let summary = run(sets);
        let out = summary.outflow["right"].max(summary.outflow["top"]);
        let left = 100.0 * (1.0 - out).abs();
        let said = warned(&summary).unwrap_or(0.0);
        println!("{sets:?}: {left} % off, {said} % said");
        assert!((left > 0.1) == (said > 0.0), "{sets:?}: {left} {said}");
        assert!(
            (said - left).abs() < 0.15 * left + 0.1,
            "{sets:?}: {left} {said}"
        );
    }
    assert_eq!(warned(&run(&[])), None);
}

/// What flows through a flux side is no error of the operator.
#[test]
fn flux_sides_are_no_error_of_the_bond_operator() {
    for set in [
        "flow.boundary={left={pressure=1}, right={flux=1}}",
        "flow.boundary={left={pressure=1}, top={flux=1}}",
    ] {
        let (summary, _) = run_text(&square(40), &["flow.operator=bond", set]);
        assert_eq!(warned(&summary), None, "{set}");
    }
}

#[test]
fn the_bond_operator_is_refused_where_a_uniform_flow_is_a_tenth_off() {
    let sets = [
        "flow.operator=bond",
        "geometry.jitter=0.4",
        "horizon.ratio=1.6",
    ];
    let built = Model::<2>::build(&plan_of(&square(40), &sets), &mut Timers::default());
    let Err(ModelError::InconsistentBonds { error, .. }) = built else {
        panic!("not refused");
    };
    assert!((0.1..0.2).contains(&error), "{error}");
}

#[test]
fn the_default_operator_is_path_unless_a_gradient_is_named() {
    let layer = r#"{type="box", min=[0, 0], max=[1, 0.5]}"#;
    let with = format!("materials.layer={{permeability=1e-4, storage=1, region={layer}}}");
    let operator = |sets: &[&str]| run_text(&square(40), sets).0.operator;
    assert_eq!(operator(&[]), "path");
    assert_eq!(operator(&[&with]), "path");
    assert_eq!(operator(&["geometry.jitter=0.2"]), "path");
    assert_eq!(operator(&["flow.gradient=plain"]), "correspondence");
}

/// In the model of the paper fluid in cracks moves by the operator of the rock, and must get past points that are not
/// broken; in the split model it has bonds of its own.
#[test]
fn flow_in_fractures_of_the_paper_takes_the_bond_operator_by_default() {
    let operator = |case: &str, sets: &[&str]| {
        let plan = plan_of_variant(case, "smoke", sets);
        let flow = flow_model::<2>(&plan);
        flow.operator.name()
    };
    let auto = "flow.operator=auto";
    assert_eq!(operator("natural-fractures", &[auto]), "bond");
    assert_eq!(operator("kgd-toughness", &[auto]), "path");
    let named = [auto, "flow.gradient=plain"];
    assert_eq!(operator("kgd-toughness", &named), "correspondence");
}

#[test]
fn the_correspondence_operator_across_layers_is_warned_of() {
    let layer = r#"materials.layer={permeability=1e-4, storage=1, region={type="box", min=[0, 0], max=[1, 0.5]}}"#;
    let doubts = |operator: &str| {
        let (summary, _) = run_text(&square(40), &[layer, &format!("flow.operator={operator}")]);
        summary
            .warnings
            .iter()
            .filter(|w| w.contains("arithmetic mean"))
            .count()
    };
    assert_eq!(
        ["auto", "path", "bond", "correspondence"].map(doubts),
        [0, 0, 0, 1]
    );
}

/// Horizontal layers in series: k = 2/(1/k₁ + 1/k₂) carries the flux.
#[test]
fn flow_across_horizontal_layers_is_right_by_default() {
    let layer = r#"materials.clay={permeability=1e-4, storage=1, region={type="box", min=[0, 0], max=[1, 0.5]}}"#;
    let upward = "flow.boundary={bottom={pressure=1}, top={pressure=0}}";
    let (summary, _) = run_text(&square(40), &[layer, upward]);
    let exact = 2.0 / (1.0 + 1e4);
    let error = (summary.outflow["top"] / exact - 1.0).abs();
    assert!(error < 1e-12, "{error:e}");
}
