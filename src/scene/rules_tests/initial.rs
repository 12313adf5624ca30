//! Rules of the in-situ state.

use super::mechanics::COUPLED;
use super::{faults, load};
use crate::scene::{InitialPressure, StressKind};

/// The faults of the coupled scene with an in-situ state.
fn found(initial: &str, others: &[&str]) -> Vec<(String, String)> {
    let initial = format!("initial={{{initial}}}");
    faults(COUPLED, &[&[&*initial], others].concat())
}

fn one(message: &str, place: &str) -> Vec<(String, String)> {
    vec![(message.to_owned(), place.to_owned())]
}

#[test]
fn an_in_situ_state_is_read_with_its_units() {
    let text = "initial={kind = \"total\", datum = \"1 km\", stress = {xx = \"-1 MPa\"}, \
                stress_gradient = {yy = \"-23 kPa/m\"}, pressure = \"2 bar\"}";
    let scene = load(COUPLED, &[text]).unwrap().scene;
    let initial = scene.initial.unwrap();
    assert_eq!(initial.kind.value, StressKind::Total);
    assert!((initial.datum.unwrap().value() - 1e3).abs() < 1e-12);
    let gradient = initial.stress_gradient.as_ref().unwrap().resolved();
    assert!((gradient[1] + 23e3).abs() < 1e-9);
    assert!((initial.pressure.unwrap().value() - 2e5).abs() < 1e-9);
    let deep = load(COUPLED, &["initial={k0 = 0.5, pressure = \"hydrostatic\"}"]).unwrap();
    let pressure = deep.scene.initial.unwrap().pressure.unwrap();
    assert!(matches!(pressure, InitialPressure::Hydrostatic(_)));
}

#[test]
fn components_are_those_of_the_plane() {
    for key in ["stress", "stress_gradient"] {
        let told = found(&format!("{key} = {{yz = 5}}"), &[]);
        assert_eq!(told, one("a plane domain has no component `yz`", "5"));
        let told = found(&format!("{key} = {{zx = 5}}"), &[]);
        assert_eq!(told, one("unknown key `zx`", "zx"));
    }
}

#[test]
fn what_is_told_twice_is_refused() {
    let told = found("stress = {xx = 1}", &["mechanics.initial_stress={xx = 2}"]);
    let message = "`mechanics.initial_stress` excludes `a stress in [initial]`";
    assert_eq!(told, one(message, "{xx = 1}"));
    let told = found("pressure = 1", &["flow.initial_pressure=2"]);
    let message = "`initial.pressure` excludes `flow.initial_pressure`";
    assert_eq!(told, one(message, "2"));
    let told = found("pressure = \"1 bar\"", &["flow.hydrostatic_start=true"]);
    let message = "`initial.pressure` excludes `flow.hydrostatic_start`";
    assert_eq!(told, one(message, "true"));
    let told = found("k0 = 0.5, stress = {xx = 1}", &[]);
    assert_eq!(told, one("`stress` excludes `k0`", "0.5"));
}

#[test]
fn a_pressure_is_a_number_or_the_word() {
    let told = found("pressure = \"3 m\"", &[]);
    let message = "expected a pressure (Pa), found a length: \"3 m\"";
    assert_eq!(told, one(message, "\"3 m\""));
    let told = found("pressure = true", &[]);
    assert_eq!(told.len(), 1);
    assert!(told[0].0.contains("\"hydrostatic\""), "{told:?}");
}

#[test]
fn k0_is_positive() {
    assert_eq!(found("k0 = 0", &[]), one("`k0` must be positive", "0"));
}
