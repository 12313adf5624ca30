//! Rules of damage, of damaged cracks, and of flow in what is broken.

use super::{faults, load};
use crate::scene::{CrackKind, DamageModel, HorizonSize, Normalise};

/// A sound scene of a crack that fluid is pumped into.
pub(crate) const PUMPED: &str = r#"title = "Pumped"
[geometry]
type = "lattice"
size = [1, 1]
points = [10, 10]
[horizon]
length_scale_ratio = 0.5
[fluid]
viscosity = "1 cP"
[materials.rock]
permeability = "1 mD"
storage = "1e-10 1/Pa"
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
biot_coefficient = 0.8
fracture_energy = "100 J/m^2"
[flow]
[mechanics.boundary]
left.clamped = true
right.free = true
[coupling]
[damage]
model = "paper"
length_scale = "40 cm"
split = "volumetric-deviatoric"
residual_stiffness = 1e-8
normalise = false
method = "newton"
tolerance = 1e-6
iterations = 50
largest_increment = 0.2
shortest_step = "1 ms"
[fracture_flow]
aperture = "mean"
transmissivity = "paper"
lower_threshold = 0.4
upper_threshold = 0.9
storage = "4e-10 1/Pa"
biot_coefficient = 0.95
viscosity = "2 cP"
permeability = "1 D"
[cracks.notch]
kind = "damaged"
points = [[0.4, 0.5], [0.6, 0.5]]
injection = { rate = "1e-6 m^2/s", at = [0.5, 0.5] }
[time]
end = "10 s"
"#;

/// A sound scene of a flat crack in space that nothing flows in.
pub(crate) const DISC: &str = r#"title = "Disc"
[geometry]
type = "lattice"
size = [1, 1, 1]
points = [8, 8, 8]
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
fracture_energy = 100
[mechanics.boundary.left]
clamped = true
[damage]
model = "paper"
length_scale = 0.5
[cracks.penny]
kind = "damaged"
disc = { centre = [0.5, 0.5, 0.5], normal = [0, 0, 2], radius = "40 cm" }
pressure = "1 MPa"
[time]
mode = "steady"
"#;

/// Each row: text to replace, replacement, message, underlined words. Exactly this fault is found.
fn check(scene: &str, table: &[(&str, &str, &str, &str)]) {
    for (from, to, message, excerpt) in table {
        assert!(scene.contains(from), "{from}");
        let found = faults(&scene.replacen(from, to, 1), &[]);
        let expected = [((*message).to_owned(), (*excerpt).to_owned())];
        assert_eq!(found, expected, "{from} -> {to}");
    }
}

fn messages(scene: &str, overrides: &[&str]) -> Vec<String> {
    let found = faults(scene, overrides).into_iter();
    found.map(|(message, _)| message).collect()
}

/// The text without a section, from its heading to the next one.
pub(crate) fn without(scene: &str, heading: &str) -> String {
    let start = scene.find(heading).unwrap();
    let end = scene[start + 1..]
        .find("\n[")
        .map_or(scene.len(), |end| start + end + 2);
    format!("{}{}", &scene[..start], &scene[end..])
}

#[test]
fn sound_scenes_are_read() {
    let scene = load(PUMPED, &[]).unwrap().scene;
    let size = scene.horizon.size(scene.damage.as_deref());
    let HorizonSize::Radius(radius) = size else {
        panic!("{size:?}")
    };
    assert!((radius - 0.2).abs() < 1e-12);
    let notch = scene.cracks.get("notch").unwrap();
    assert_eq!(notch.kind.value, CrackKind::Damaged);
    assert!(notch.injection.is_some() && notch.disc.is_none());
    let scene = load(DISC, &[]).unwrap().scene;
    assert!(scene.cracks.get("penny").unwrap().points.is_none());
    let normal = scene.cracks.get("penny").unwrap().disc.as_ref().unwrap();
    assert!((normal.unit_normal()[2] - 1.0).abs() < 1e-15);
}

#[test]
fn damage_rules() {
    check(
        PUMPED,
        &[
            (
                "length_scale = \"40 cm\"",
                "length_scale = 0",
                "`length_scale` must be positive",
                "0",
            ),
            (
                "residual_stiffness = 1e-8",
                "residual_stiffness = 1e-15",
                "`residual_stiffness` must lie between 1e-14 and 0.001, found 1e-15",
                "1e-15",
            ),
            (
                "residual_stiffness = 1e-8",
                "residual_stiffness = 1",
                "`residual_stiffness` must lie between 1e-14 and 0.001, found 1",
                "1",
            ),
            (
                "\"volumetric-deviatoric\"",
                "\"spectrum\"",
                "`spectrum` is not known here",
                "\"spectrum\"",
            ),
            (
                "\"newton\"",
                "\"nwton\"",
                "`nwton` is not known here",
                "\"nwton\"",
            ),
            (
                "tolerance = 1e-6",
                "tolerance = 0",
                "`tolerance` must lie between 1e-12 and 0.001, found 0",
                "0",
            ),
            (
                "tolerance = 1e-6",
                "tolerance = 0.1",
                "`tolerance` must lie between 1e-12 and 0.001, found 0.1",
                "0.1",
            ),
            (
                "iterations = 50",
                "iterations = 0",
                "`iterations` must lie between 1 and 1e6, found 0",
                "0",
            ),
            (
                "largest_increment = 0.2",
                "largest_increment = 0",
                "`largest_increment` must lie between 0.001 and 1, found 0",
                "0",
            ),
            (
                "largest_increment = 0.2",
                "largest_increment = 1.5",
                "`largest_increment` must lie between 0.001 and 1, found 1.5",
                "1.5",
            ),
            (
                "\"1 ms\"",
                "\"0 ms\"",
                "`shortest_step` must be positive",
                "\"0 ms\"",
            ),
            (
                "length_scale_ratio = 0.5",
                "length_scale_ratio = 0",
                "`length_scale_ratio` must lie between 0.1 and 5, found 0",
                "0",
            ),
            (
                "length_scale_ratio = 0.5",
                "length_scale_ratio = 0.5\nradius = 0.2",
                "`radius` excludes `length_scale_ratio`",
                "0.5",
            ),
            (
                "fracture_energy = \"100 J/m^2\"\n",
                "",
                "material `rock` has no `fracture_energy`",
                "rock",
            ),
            (
                "\"100 J/m^2\"",
                "-1",
                "`fracture_energy` must be positive",
                "-1",
            ),
            (
                "\"100 J/m^2\"",
                "\"100 J\"",
                "expected an energy per area (J/m^2), found an energy: \"100 J\"",
                "\"100 J\"",
            ),
        ],
    );
    assert_eq!(
        faults(PUMPED, &["materials.rock.fracture_energy=0.1 kN/m"]),
        []
    );
}

#[test]
fn a_horizon_in_length_scales_needs_damage() {
    let size = ["horizon.length_scale_ratio=0.5"];
    let elastic = without(&without(DISC, "[damage]"), "[cracks");
    assert_eq!(
        messages(&elastic, &size),
        ["`length_scale_ratio` needs [damage]"]
    );
}

/// A scene of the split model, which needs nothing in its section.
#[test]
fn the_split_model_is_the_default_and_needs_no_length_scale() {
    let text = DISC.replace("model = \"paper\"\nlength_scale = 0.5\n", "");
    let scene = load(&text, &[]).unwrap().scene;
    let damage = scene.damage.as_ref().unwrap();
    assert_eq!(damage.model, DamageModel::Split);
    assert_eq!(damage.normalisation(), Normalise::Mean);
    assert_eq!(scene.horizon.size(Some(damage)), HorizonSize::Ratio(2.3));
    let paper = load(DISC, &[]).unwrap().scene;
    let damage = paper.damage.as_ref().unwrap();
    assert_eq!(damage.normalisation(), Normalise::Off);
    assert_eq!(
        paper.horizon.size(Some(damage)),
        HorizonSize::Neighbours(15)
    );
    assert_eq!(
        messages(&text, &["horizon.length_scale_ratio=0.5"]),
        ["`length_scale_ratio` needs damage.length_scale"]
    );
    for strength in ["damage.model=paper", "damage.normalise=false"] {
        assert_eq!(
            messages(&text, &[strength]),
            ["[damage] needs `length_scale`, or normalise = \"mean\""]
        );
    }
}

#[test]
fn keys_of_both_models_have_their_ranges() {
    for (key, message) in [
        ("damage.model=griffith", "`griffith` is not known here"),
        (
            "damage.exponent=3",
            "`exponent` = 3: there are laws for 1.5 and 2 only",
        ),
        (
            "fluid.cavitation_pressure=0 Pa",
            "`cavitation_pressure` holds in cracks of the split model",
        ),
        (
            "fracture_flow.residual_aperture=0",
            "`residual_aperture` must be positive",
        ),
    ] {
        assert_eq!(messages(PUMPED, &[key]), [message], "{key}");
    }
    for sound in ["damage.exponent=1.5", "damage.exponent=2"] {
        assert_eq!(faults(PUMPED, &[sound]), [], "{sound}");
    }
}

#[test]
fn friction_is_of_faces_that_touch() {
    let split = DISC.replace("model = \"paper\"\nlength_scale = 0.5\n", "");
    for (key, message) in [
        (
            "damage.friction=-0.1",
            "`friction` must lie between 0 and 10, found -0.1",
        ),
        (
            "damage.friction=11",
            "`friction` must lie between 0 and 10, found 11",
        ),
    ] {
        assert_eq!(messages(&split, &[key]), [message], "{key}");
    }
    assert_eq!(faults(&split, &["damage.friction=0.3"]), []);
    assert_eq!(
        messages(DISC, &["damage.friction=0.3"]),
        [
            "`friction` belongs to damage.model = \"split\": faces of the model of the paper do not touch; leave it out, \
             or set damage.model = \"split\""
        ]
    );
}

#[test]
fn fracture_flow_rules() {
    check(
        PUMPED,
        &[
            (
                "lower_threshold = 0.4",
                "lower_threshold = 0",
                "`lower_threshold` must lie between 0.01 and 0.99, found 0",
                "0",
            ),
            (
                "lower_threshold = 0.4",
                "lower_threshold = 0.9",
                "`lower_threshold` must be below `upper_threshold`",
                "0.9",
            ),
            (
                "upper_threshold = 0.9",
                "upper_threshold = 1.1",
                "`upper_threshold` must lie between 0.02 and 1, found 1.1",
                "1.1",
            ),
            (
                "lower_threshold = 0.4\nupper_threshold = 0.9",
                "upper_threshold = 0.5",
                "`lower_threshold` must be below `upper_threshold`",
                "0.5",
            ),
            (
                "biot_coefficient = 0.95",
                "biot_coefficient = 1.1",
                "`biot_coefficient` must lie between 0 and 1, found 1.1",
                "1.1",
            ),
            ("\"4e-10 1/Pa\"", "0", "`storage` must be positive", "0"),
            ("\"2 cP\"", "0", "`viscosity` must be positive", "0"),
            ("\"1 D\"", "0", "`permeability` must be positive", "0"),
            (
                "aperture = \"mean\"",
                "aperture = \"median\"",
                "`median` is not known here",
                "\"median\"",
            ),
            (
                "transmissivity = \"paper\"",
                "transmissivity = \"square\"",
                "`square` is not known here",
                "\"square\"",
            ),
        ],
    );
    assert_eq!(faults(PUMPED, &["time.integrator=backward-euler"]), []);
}

#[test]
fn fluid_is_pumped_into_a_crack_at_one_place_of_the_domain() {
    check(
        PUMPED,
        &[
            (
                "at = [0.5, 0.5]",
                "at = [0.5, 0.5, 0]",
                "`at` needs 2 components, found 3",
                "[0.5, 0.5, 0]",
            ),
            (
                "at = [0.5, 0.5]",
                "at = [0.5, 5]",
                "`at` lies outside the domain",
                "[0.5, 5]",
            ),
            (
                "injection =",
                "pressure = \"1 MPa\"\ninjection =",
                "`pressure` excludes `injection`",
                "{ rate = \"1e-6 m^2/s\", at = [0.5, 0.5] }",
            ),
        ],
    );
}

#[test]
fn a_disc_is_for_space_and_points_are_for_planes() {
    check(
        DISC,
        &[
            (
                "kind = \"damaged\"\n",
                "",
                "a `disc` needs kind = \"damaged\"",
                "{ centre = [0.5, 0.5, 0.5], normal = [0, 0, 2], radius = \"40 cm\" }",
            ),
            (
                "normal = [0, 0, 2]",
                "normal = [0, 0, 0]",
                "`normal` must not be zero",
                "[0, 0, 0]",
            ),
            (
                "normal = [0, 0, 2]",
                "normal = [0, 2]",
                "`normal` needs 3 components, found 2",
                "[0, 2]",
            ),
            (
                "radius = \"40 cm\"",
                "radius = 0",
                "`radius` must be positive",
                "0",
            ),
            (
                "radius = \"40 cm\"",
                "radius = 0.6",
                "the crack leaves the domain",
                "[0.5, 0.5, 0.5]",
            ),
            (
                "centre = [0.5, 0.5, 0.5]",
                "centre = [0.5, 0.5, 1.5]",
                "the crack leaves the domain",
                "[0.5, 0.5, 1.5]",
            ),
        ],
    );
    let quarter = DISC.replace("centre = [0.5, 0.5, 0.5]", "centre = [0, 1, 0.02]");
    assert_eq!(faults(&quarter, &[]), [], "planes of symmetry cut the disc");
    let both = messages(DISC, &["cracks.penny.points=[[0, 0], [1, 1]]"]);
    assert_eq!(
        both,
        [
            "`points` excludes `disc`",
            "the `points` of a crack are for planes"
        ]
    );
    let flat = ["geometry.size=[1, 1]", "geometry.points=[8, 8]"];
    assert_eq!(
        messages(DISC, &flat),
        ["the `disc` of a crack is for three dimensions"]
    );
    let placeless = PUMPED.replace("points = [[0.4, 0.5], [0.6, 0.5]]\n", "");
    assert_eq!(
        faults(&placeless, &[]),
        [(
            "a crack needs `points` or a `disc`".to_owned(),
            "notch".to_owned()
        )]
    );
}

/// A key that takes a switch or a word.
#[test]
fn normalise_is_a_switch_or_a_word() {
    let read = |value: &str| {
        let text = PUMPED.replace("normalise = false", &format!("normalise = {value}"));
        load(&text, &[]).map(|loaded| loaded.scene.damage.as_ref().unwrap().normalise)
    };
    assert_eq!(read("false").unwrap(), Some(Normalise::Off));
    assert_eq!(read("true").unwrap(), Some(Normalise::Horizon));
    assert_eq!(read("\"mean\"").unwrap(), Some(Normalise::Mean));
    for (value, found) in [("\"median\"", "\"median\""), ("1", "1")] {
        let text = PUMPED.replace("normalise = false", &format!("normalise = {value}"));
        let message = format!("expected `true`, `false` or \"mean\", found {found}");
        assert_eq!(faults(&text, &[]), [(message, value.to_owned())]);
    }
}
