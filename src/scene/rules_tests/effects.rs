//! Rules of gravity, flow, wells and reference solutions.

use super::{SOUND, check, faults};

#[test]
fn gravity_rules() {
    check(&[(
        "[0, -9.81]",
        "[0, 0, -9.81]",
        "`acceleration` needs 2 components, found 3",
        "[0, 0, -9.81]",
    )]);
}

#[test]
fn flow_rules() {
    check(&[
        (
            "operator = \"correspondence\"",
            "hourglass = 0",
            "`hourglass` must lie between 0.1 and 10, found 0",
            "0",
        ),
        (
            "operator = \"correspondence\"",
            "operator = \"bond\"\ngradient = \"plain\"",
            "the bond operator has no gradient to choose",
            "\"plain\"",
        ),
        (
            "[flow.boundary.top]",
            "[flow.boundary.back]",
            "a plane domain has no side `back`",
            "[flow.boundary.back]",
        ),
        (
            "[flow.boundary.top]",
            "[flow.boundary.tpo]",
            "unknown key `tpo`",
            "tpo",
        ),
        (
            "sealed = true",
            "sealed = false",
            "`sealed` can only be true",
            "false",
        ),
        (
            "sealed = true",
            "sealed = true\nflux = 1",
            "`sealed` excludes `flux`",
            "flux",
        ),
        (
            "sealed = true",
            "",
            "`pressure`, `flux` or `sealed` is missing",
            "[flow.boundary.top]",
        ),
        (
            "[0, \"10 s\", 20]",
            "[0, 30, 20]",
            "`time` must increase from entry to entry",
            "20",
        ),
        (
            "[0, \"10 s\", 20]",
            "[0, 10, 10]",
            "`time` must increase from entry to entry",
            "10",
        ),
        (
            "[0, \"1 MPa\", 0]",
            "[0, 1]",
            "`value` needs one entry for each of the 3 times, found 2",
            "[0, 1]",
        ),
        (
            "{ time = [0, \"10 s\", 20], value = [0, \"1 MPa\", 0] }",
            "{ time = [], value = [] }",
            "`time` needs at least one entry",
            "[]",
        ),
        (
            "\"2 bar\"",
            "\"2 mm\"",
            "expected a pressure (Pa), found a length: \"2 mm\"",
            "\"2 mm\"",
        ),
    ]);
}

#[test]
fn well_rules() {
    check(&[
        (
            "at = [0.5, 0.5]\n",
            "at = [0.5, 1.5]\n",
            "`at` lies outside the domain",
            "[0.5, 1.5]",
        ),
        (
            "at = [0.5, 0.5]\n",
            "at = [0.5]\n",
            "`at` needs 2 components, found 1",
            "[0.5]",
        ),
        (
            "at = [0.5, 0.5]\n",
            "",
            "`at` is missing",
            "[wells.injector]",
        ),
        (
            "\"5 cm\"",
            "\"0 cm\"",
            "`radius` must be positive",
            "\"0 cm\"",
        ),
        (
            "\"1e-6 m^2/s\"",
            "\"1e-6 m/s\"",
            "expected a flow rate (m^3/s), found a velocity: \"1e-6 m/s\"",
            "\"1e-6 m/s\"",
        ),
    ]);
}

#[test]
fn rules_of_wells_that_are_held_at_a_pressure() {
    let rate = "rate = \"1e-6 m^2/s\"\n";
    check(&[
        (rate, "", "a well needs `rate` or `pressure`", "injector"),
        (
            rate,
            "rate = 1\npressure = 7\nwellbore_radius = 1e-3\n",
            "`rate` excludes `pressure`",
            "7",
        ),
        (
            rate,
            "pressure = \"1 MPa\"\n",
            "`pressure` needs `wellbore_radius`",
            "\"1 MPa\"",
        ),
        (
            rate,
            "rate = 1\nskin = 3\n",
            "`skin` needs `wellbore_radius`",
            "3",
        ),
        (
            rate,
            "rate = 1\nwellbore_radius = 0\n",
            "`wellbore_radius` must be positive",
            "0",
        ),
        (
            rate,
            "pressure = 7\nwellbore_radius = 1e-3\npressure_min = 5\n",
            "`pressure_min` limits a `rate`, not a `pressure`",
            "5",
        ),
        (
            rate,
            "rate = 7\nwellbore_radius = 1e-3\nrate_max = 5\n",
            "`rate_max` limits a `pressure`, not a `rate`",
            "5",
        ),
        (
            rate,
            "rate = 7\nwellbore_radius = 1e-3\npressure_min = 5\n",
            "`pressure_min` limits the pressure of a producer, and `rate` is never below zero",
            "5",
        ),
        (
            rate,
            "rate = -7\nwellbore_radius = 1e-3\npressure_max = 5\n",
            "`pressure_max` limits the pressure of an injector, and `rate` is never above zero",
            "5",
        ),
        (
            rate,
            "rate = { time = [0, 1], value = [-1, 1] }\nwellbore_radius = 1e-3\npressure_min = 5\npressure_max = 4\n",
            "`pressure_max` must be greater than `pressure_min`",
            "4",
        ),
        (
            rate,
            "pressure = 7\nwellbore_radius = 1e-3\nrate_max = -5\n",
            "`rate_max` must be positive",
            "-5",
        ),
    ]);
}

#[test]
fn reference_rules() {
    let with = |set: &[&str]| faults(SOUND, set);
    let found = with(&["reference.type=five-spot"]);
    let messages: Vec<&str> = found.iter().map(|(message, _)| message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "a five-spot has its wells in corners of the domain",
            "the five-spot needs a square domain",
            "this reference needs [wells] with 2 of them, found 1",
        ]
    );
    assert_eq!(
        with(&["reference.type=theis", "reference.exclude=10 cm"]),
        []
    );
    assert_eq!(with(&["reference.type=two-layer"]), []);
    assert_eq!(with(&["reference.type=manufactured"]), []);
    let found = with(&["reference.type=theis", "reference.exclude=0"]);
    assert_eq!(
        found,
        [("`exclude` must be positive".to_owned(), "0".to_owned())]
    );
    let found = with(&["reference.type=thies"]);
    assert_eq!(
        found,
        [("`thies` is not known here".to_owned(), "thies".to_owned())]
    );
}
