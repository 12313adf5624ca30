//! Rules of mechanics: what holds and loads the body.

use super::{faults, load};
use crate::scene::{Motion, SchemeName, Side};

/// A sound scene of flow and mechanics, coupled.
pub(crate) const COUPLED: &str = r#"title = "Column"

[geometry]
type = "lattice"
size = [1, 2]
points = [10, 20]

[fluid]
viscosity = "1 cP"

[materials.rock]
permeability = "1 mD"
storage = "1e-10 1/Pa"
youngs_modulus = "10 GPa"
poissons_ratio = 0.25
biot_coefficient = 0.8
density = "2300 kg/m^3"

[gravity]
acceleration = [0, -9.81]

[flow.boundary.top]
pressure = 0

[mechanics]
mode = "quasi-static"
hourglass = 0.5
gradient = "plain"
body_force = ["1 kN/m^3", 0]

[mechanics.boundary]
left.roller = true
right.free = true
bottom.displacement = [0, { time = [0, 1], value = [0, "1 mm"] }]
top.traction = [0, "-1 MPa"]

[mechanics.loads.footing]
side = "top"
region = { type = "box", min = [0, 1.9], max = [0.5, 2] }
traction = [0, "-5 bar"]

[coupling]
undrained_start = false

[time]
end = "1 d"

[scheme]
name = "staggered"
relaxation = 0
acceleration = "aitken"
coupling_tolerance = 1e-6
coupling_iterations = 20
solid = "adr"
adr_tolerance = 1e-5
adr_iterations = 1000
adr_smoothing = 1
"#;

/// Each row: text to replace, replacement, message, underlined words. Exactly this fault is found.
pub(super) fn check(table: &[(&str, &str, &str, &str)]) {
    for (from, to, message, excerpt) in table {
        assert!(COUPLED.contains(from), "{from}");
        let found = faults(&COUPLED.replacen(from, to, 1), &[]);
        let expected = [((*message).to_owned(), (*excerpt).to_owned())];
        assert_eq!(found, expected, "{from} -> {to}");
    }
}

pub(super) fn messages(text: &str, overrides: &[&str]) -> Vec<String> {
    let found = faults(text, overrides).into_iter();
    found.map(|(message, _)| message).collect()
}

#[test]
fn the_coupled_scene_has_no_fault() {
    let scene = load(COUPLED, &[]).unwrap().scene;
    let mechanics = scene.mechanics.unwrap();
    assert_eq!(mechanics.mode.value, Motion::QuasiStatic);
    assert_eq!(
        mechanics.loads.get("footing").unwrap().side.value,
        Side::Top
    );
    assert!(!scene.coupling.unwrap().undrained_start);
    assert_eq!(scene.scheme.name.value, SchemeName::Staggered);
}

#[test]
fn every_support_is_read_and_only_one_per_side() {
    for support in [
        "free = true",
        "clamped = true",
        "roller = true",
        "traction = [0, { time = [0, 1], value = [0, 1] }]",
        "displacement = [0, \"1 mm\"]",
        "normal_displacement = \"-1 mm\"",
        "plate = \"-10 kN/m\"",
        "plate = { time = [0, 1], value = [0, \"-10 kN\"] }",
    ] {
        let set = format!("mechanics.boundary.right={{{support}}}");
        assert_eq!(faults(COUPLED, &[&set]), [], "{support}");
    }
    check(&[
        (
            "right.free = true",
            "right = {}",
            "`free`, `clamped`, `roller`, `traction`, `displacement`, `normal_displacement` or \
             `plate` is missing",
            "{}",
        ),
        (
            "right.free = true",
            "right = { plate = 1, roller = true }",
            "`plate` excludes `roller`",
            "roller",
        ),
        (
            "right.free = true",
            "right = { plate = 1, ruller = true }",
            "unknown key `ruller`",
            "ruller",
        ),
        (
            "right.free = true",
            "right.free = false",
            "`free` can only be true",
            "false",
        ),
        (
            "right.free = true",
            "right.clamped = false",
            "`clamped` can only be true",
            "false",
        ),
        (
            "right.free = true",
            "right.roller = false",
            "`roller` can only be true",
            "false",
        ),
    ]);
}

#[test]
fn mechanics_rules() {
    check(&[
        (
            "hourglass = 0.5",
            "hourglass = 0",
            "`hourglass` must lie between 0.1 and 10, found 0",
            "0",
        ),
        (
            "[\"1 kN/m^3\", 0]",
            "[1]",
            "`body_force` needs 2 components, found 1",
            "[1]",
        ),
        (
            "\"1 kN/m^3\"",
            "\"1 kN/m^2\"",
            "expected a force per volume (N/m^3), found a pressure: \"1 kN/m^2\"",
            "\"1 kN/m^2\"",
        ),
        (
            "right.free",
            "front.free",
            "a plane domain has no side `front`",
            "front",
        ),
        (
            "[0, \"-1 MPa\"]",
            "[0, 0, 1]",
            "`traction` needs 2 components, found 3",
            "[0, 0, 1]",
        ),
        (
            "time = [0, 1], value",
            "time = [1, 0], value",
            "`time` must increase from entry to entry",
            "0",
        ),
        (
            "right.free = true",
            "right.normal_displacement = \"1 Pa\"",
            "expected a length (m), found a pressure: \"1 Pa\"",
            "\"1 Pa\"",
        ),
    ]);
}

#[test]
fn a_load_acts_on_a_free_side_only() {
    check(&[
        (
            "side = \"top\"",
            "side = \"left\"",
            "`left` is not free, so it takes no load",
            "\"left\"",
        ),
        (
            "side = \"top\"",
            "side = \"back\"",
            "a plane domain has no side `back`",
            "\"back\"",
        ),
        (
            "side = \"top\"",
            "side = \"tpo\"",
            "`tpo` is not known here",
            "\"tpo\"",
        ),
        (
            "[0, \"-5 bar\"]",
            "[1]",
            "`traction` needs 2 components, found 1",
            "[1]",
        ),
        (
            "max = [0.5, 2]",
            "max = [0, 2]",
            "`max` must be greater than `min` along every axis",
            "[0, 2]",
        ),
    ]);
    let plate = [
        "mechanics.loads.footing.side=right",
        "mechanics.boundary.right={plate = 1}",
    ];
    assert_eq!(
        messages(COUPLED, &plate),
        ["`right` is not free, so it takes no load"]
    );
    assert_eq!(
        messages(COUPLED, &plate[..1]),
        [""; 0],
        "a side declared free"
    );
    let unnamed = COUPLED.replace("right.free = true", "");
    assert_eq!(messages(&unnamed, &plate[..1]), [""; 0], "free by default");
}

#[test]
fn a_quasi_static_body_is_held_along_every_axis() {
    let heading = "[mechanics]".to_owned();
    let along = |axis: &str| {
        (
            format!("nothing holds the body along {axis}"),
            heading.clone(),
        )
    };
    let free = [
        "mechanics.boundary.left={free = true}",
        "mechanics.boundary.bottom={free = true}",
    ];
    assert_eq!(faults(COUPLED, &free), [along("x"), along("y")]);
    let roller = ["mechanics.boundary.left={roller = true}", free[1]];
    assert_eq!(
        faults(COUPLED, &roller),
        [along("y")],
        "a roller holds across its side"
    );
    let plate = [
        "mechanics.boundary.left={plate = 1}",
        "mechanics.boundary.bottom={roller = true}",
    ];
    assert_eq!(faults(COUPLED, &plate), [along("x")], "a plate moves");
    for holds in ["{clamped = true}", "{displacement = [0, 0]}"] {
        let set = format!("mechanics.boundary.left={holds}");
        assert_eq!(faults(COUPLED, &[&set, free[1]]), [], "{holds}");
    }
    let moved = ["mechanics.boundary.left={normal_displacement = 0}"];
    assert_eq!(faults(COUPLED, &moved), []);
    let text = load(COUPLED, &roller).unwrap_err().to_string();
    assert!(
        text.contains("add roller = true on bottom or top, or clamp a side"),
        "{text}"
    );
    let dynamic = ["mechanics.mode=dynamic", "scheme.name=explicit"];
    assert_eq!(
        faults(COUPLED, &[free, dynamic].concat()),
        [],
        "inertia holds"
    );
}

#[test]
fn a_solid_body_has_three_axes_and_whole_forces() {
    let solid = [
        "geometry.size=[1, 2, 1]",
        "geometry.points=[4, 8, 4]",
        "gravity.acceleration=[0, -9.81, 0]",
        "mechanics.body_force=[0, 0, 0]",
        "initial={stress = {yz = \"1 bar\"}}",
        "mechanics.boundary.bottom={roller = true}",
        "mechanics.boundary.top={free = true}",
        "mechanics.boundary.front={roller = true}",
        "mechanics.loads.footing={side = \"back\", traction = [0, 0, 1]}",
    ];
    assert_eq!(faults(COUPLED, &solid), []);
    let free = [&solid[..], &["mechanics.boundary.front={free = true}"]].concat();
    assert_eq!(messages(COUPLED, &free), ["nothing holds the body along z"]);
    let plate = [&solid[..], &["mechanics.boundary.top={plate = \"1 kN/m\"}"]].concat();
    assert_eq!(
        faults(COUPLED, &plate),
        [(
            "a force per metre of thickness has no meaning in three dimensions".to_owned(),
            "\"1 kN/m\"".to_owned()
        )]
    );
}
