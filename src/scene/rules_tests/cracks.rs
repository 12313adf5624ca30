//! Rules of cracks that are there from the start.

use super::faults;

pub(crate) const SOLID: &str = r#"title = "Cracked"
[geometry]
type = "lattice"
size = [1, 1]
points = [10, 10]
[materials.rock]
youngs_modulus = "1 GPa"
poissons_ratio = 0.2
[mechanics.boundary.left]
clamped = true
[cracks.main]
points = [["20 cm", 0.5], [0.6, 0.5]]
pressure = "1 MPa"
[time]
mode = "steady"
"#;

#[test]
fn a_crack_is_a_chain_of_places_in_a_plane_domain() {
    let found = |overrides: &[&str]| {
        let found = faults(SOLID, overrides);
        let messages = found.into_iter().map(|(message, _)| message);
        messages.collect::<Vec<String>>()
    };
    assert_eq!(found(&[]), [""; 0]);
    let changes = [
        (
            "cracks.main.points=[[0.2, 0.5]]",
            "a crack needs at least two `points`",
        ),
        (
            "cracks.main.points=[[0.2, 0.5], [0.2, 0.5], [0.3, 0.5]]",
            "two `points` of a crack in a row are the same",
        ),
        (
            "cracks.main.points=[[0.2, 0.5], [1.2, 0.5]]",
            "the crack leaves the domain",
        ),
    ];
    for (change, message) in changes {
        assert_eq!(found(&[change]), [message]);
    }
    let solid = found(&["geometry.size=[1, 1, 1]", "geometry.points=[9, 9, 9]"]);
    assert!(
        solid.contains(&"the `points` of a crack are for planes".to_owned()),
        "{solid:?}"
    );
}

#[test]
fn the_reference_of_a_crack_needs_one() {
    let bare = SOLID.split("[cracks.main]").next().unwrap().to_owned()
        + "[time]\nmode = \"steady\"\n[reference]\ntype = \"sneddon\"\n";
    assert_eq!(faults(&bare, &[])[0].0, "this reference needs [cracks]");
}
