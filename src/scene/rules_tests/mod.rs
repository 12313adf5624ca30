//! Every rule of the scene language, each broken once in an otherwise sound scene.

pub(crate) mod coupling;
pub(crate) mod cracks;
pub(crate) mod damage;
mod effects;
mod geometry;
mod initial;
mod materials;
pub(crate) mod mechanics;
mod run;

use std::path::Path;

use super::*;

/// A sound scene that uses every section.
pub(crate) const SOUND: &str = r#"title = "Column"
description = "Everything once"

[geometry]
type = "lattice"
size = ["2 m", "1 m"]
origin = [0, 0]
points = [40, 20]
jitter = 0.1
seed = 3

[horizon]
ratio = 2.3
influence = "inverse"

[fluid]
viscosity = "1 cP"
density = "1 g/cm^3"
bulk_modulus = "2.2 GPa"

[materials.sand]
permeability = "10 mD"
storage = "1e-10 1/Pa"

[materials.clay]
region = { type = "box", min = ["0.5 m", 0], max = ["1 m", 1] }
permeability = { distribution = "log-normal", median = "1 mD", log10_std = 0.5, decades = 4, seed = 1 }
porosity = 0.2
biot_coefficient = 0.7
bulk_modulus = "10 GPa"

[gravity]
acceleration = [0, -9.81]

[flow]
operator = "correspondence"
initial_pressure = "1 bar"
hydrostatic_start = true

[flow.boundary.left]
pressure = { time = [0, "10 s", 20], value = [0, "1 MPa", 0] }
hydrostatic = true

[flow.boundary.top]
sealed = true

[[flow.regions]]
region = { type = "disc", centre = [1, 0.5], radius = "10 cm" }
pressure = "2 bar"

[wells.injector]
at = [0.5, 0.5]
rate = "1e-6 m^2/s"
radius = "5 cm"

[time]
end = "100 s"
first_step = 0.1
max_step = 10
tolerance = 1e-6

[scheme]
name = "implicit"

[solver]
name = "auto"

[output]
times = [0, "50 s", 100]
probes.centre = { at = [1, 0.5] }
profiles.axis = { from = [0, 0.5], to = [2, 0.5] }
"#;

fn load(text: &str, overrides: &[&str]) -> Result<LoadedScene, SceneErrors> {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    load_str("case.toml", text, Path::new("cases"), &overrides)
}

/// The faults as pairs of message and underlined words.
fn faults(text: &str, overrides: &[&str]) -> Vec<(String, String)> {
    let Err(errors) = load(text, overrides) else {
        return Vec::new();
    };
    let excerpt = |fault: &Diagnostic| {
        let place = fault.place.and_then(|place| errors.sources.excerpt(place));
        (fault.message.clone(), place.unwrap_or("").to_owned())
    };
    errors.diagnostics.iter().map(excerpt).collect()
}

/// The sound scene with one text replaced, which must be there.
fn broken(from: &str, to: &str) -> Vec<(String, String)> {
    assert!(SOUND.contains(from), "{from}");
    faults(&SOUND.replacen(from, to, 1), &[])
}

/// Each row: text to replace, replacement, message, underlined words. Exactly this fault is found.
fn check(table: &[(&str, &str, &str, &str)]) {
    for (from, to, message, excerpt) in table {
        let expected = [((*message).to_owned(), (*excerpt).to_owned())];
        assert_eq!(broken(from, to), expected, "{from} -> {to}");
    }
}

#[test]
fn the_sound_scene_has_no_fault() {
    assert_eq!(faults(SOUND, &[]), []);
}

#[test]
fn what_must_be_there_is_asked_for() {
    let found = faults("description = \"x\"\n", &[]);
    let messages: Vec<&str> = found.iter().map(|(message, _)| message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "the scene has no [geometry]",
            "the scene has no [materials.NAME]",
            "the scene has no [time]",
        ]
    );
    let start = SOUND.find("[fluid]").unwrap();
    let end = SOUND.find("[materials.sand]").unwrap();
    let found = faults(&format!("{}{}", &SOUND[..start], &SOUND[end..]), &[]);
    assert_eq!(
        found,
        [("[flow] needs a fluid".to_owned(), "[flow]".to_owned())]
    );
    check(&[(
        "title = \"Column\"",
        "title = \"\"",
        "`title` is empty",
        "\"\"",
    )]);
    check(&[("[horizon]", "[horizn]", "unknown key `horizn`", "horizn")]);
}

#[test]
fn faults_of_different_kinds_are_reported_together_in_file_order() {
    let text = SOUND
        .replace("jitter = 0.1", "jitter = 7")
        .replace("\"1 cP\"", "\"1 cp\"")
        .replace("end = \"100 s\"", "end = -1")
        .replace("[solver]", "[slover]");
    let found = faults(&text, &["output.probes.a.at=[9, 9]"]);
    let places: Vec<&str> = found.iter().map(|(_, excerpt)| excerpt.as_str()).collect();
    assert_eq!(places[..2], ["7", "\"1 cp\""]);
    assert!(places.contains(&"-1") && places.contains(&"slover") && places.contains(&"[9, 9]"));
}

#[test]
fn a_solid_domain_has_six_sides_and_three_components() {
    let text = r#"title = "Cube"
[geometry]
type = "lattice"
size = [1, 1, 1]
spacing = 0.1
[fluid]
viscosity = 1e-3
[materials.rock]
permeability = 1e-15
[flow.boundary]
front.pressure = 1
back.flux = "1e-9 m/s"
[time]
mode = "steady"
"#;
    let scene = load(text, &[]).unwrap().scene;
    let flow = scene.flow.unwrap();
    let sides: Vec<_> = flow
        .boundary
        .iter()
        .map(|(side, _)| (side.axis(), side.is_high()))
        .collect();
    assert_eq!(sides, [(2, false), (2, true)]);
    let Geometry::Lattice(lattice) = &scene.geometry.value else {
        panic!("a lattice")
    };
    assert_eq!(lattice.counts(), [10, 10, 10]);
    let found = faults(text, &["gravity.acceleration=[0, -9.81]"]);
    assert_eq!(found[0].0, "`acceleration` needs 3 components, found 2");
    let well = |unit| format!("wells.w={{at = [0, 0, 0], rate = \"1 {unit}\"}}");
    assert_eq!(faults(text, &[&well("m^3/s")]), []);
    let found = faults(text, &[&well("m^2/s")]);
    assert_eq!(
        found[0].0,
        "a rate per metre of thickness has no meaning in three dimensions"
    );
    let found = faults(text, &["geometry.thickness=\"1 m\""]);
    assert_eq!(found[0].0, "`thickness` has no meaning in three dimensions");
    let found = faults(
        text,
        &["flow.boundary.front={}", "flow.boundary.back.flux=1 m"],
    );
    assert_eq!(found.len(), 2, "{found:?}");
}

#[test]
fn a_five_spot_is_accepted_where_it_fits() {
    let text = r#"title = "Five-spot"
[geometry]
type = "lattice"
size = [1, 1]
points = [50, 50]
[fluid]
viscosity = "1 cP"
[materials.rock]
permeability = "1 mD"
[flow]
[wells]
in = { at = [0, 0], rate = "1e-6 m^2/s" }
out = { at = [1, 1], rate = "-1e-6 m^2/s" }
[time]
mode = "steady"
[reference]
type = "five-spot"
exclude = "0.1 m"
"#;
    assert_eq!(faults(text, &[]), []);
    let found = faults(text, &["geometry.size=[1, 2]", "wells.out.at=[1, 2]"]);
    assert_eq!(found[0].0, "the five-spot needs a square domain");
}

proptest::proptest! {
    #[test]
    fn no_damage_to_the_text_makes_loading_panic(
        at in 0..SOUND.len(),
        length in 0_usize..40,
        filling in "[\\[\\]{}=\"\\.,#0-9a-zm \n-]{0,6}",
    ) {
        let end = (at + length).min(SOUND.len());
        let text = format!("{}{filling}{}", &SOUND[..at], &SOUND[end..]);
        if let Err(errors) = load(&text, &[]) {
            proptest::prop_assert!(!errors.diagnostics.is_empty());
            proptest::prop_assert!(!errors.to_string().is_empty());
        }
        let _ = load(SOUND, &[&filling]);
    }
}
