//! Rules of what mechanics and flow need of the materials, of each other, and of the scheme.

use super::mechanics::{COUPLED, check, messages};
use super::{faults, load};

/// The coupled scene without the text from one heading to another.
pub(crate) fn without(from: &str, to: &str) -> String {
    let start = COUPLED.find(from).unwrap();
    let end = start + COUPLED[start..].find(to).unwrap();
    format!("{}{}", &COUPLED[..start], &COUPLED[end..])
}

#[test]
fn material_rules_of_mechanics() {
    check(&[
        (
            "youngs_modulus = \"10 GPa\"",
            "youngs_modulus = 0",
            "`youngs_modulus` must be positive",
            "0",
        ),
        (
            "poissons_ratio = 0.25",
            "poissons_ratio = 0.5",
            "`poissons_ratio` must be below 0.5",
            "0.5",
        ),
        (
            "poissons_ratio = 0.25",
            "poissons_ratio = -0.1",
            "`poissons_ratio` must not be negative",
            "-0.1",
        ),
        ("\"2300 kg/m^3\"", "-1", "`density` must be positive", "-1"),
        (
            "permeability = \"1 mD\"\n",
            "",
            "material `rock` has no `permeability`",
            "rock",
        ),
        (
            "youngs_modulus = \"10 GPa\"\n",
            "",
            "material `rock` has no `youngs_modulus`",
            "rock",
        ),
        (
            "poissons_ratio = 0.25\n",
            "",
            "material `rock` has no `poissons_ratio`",
            "rock",
        ),
        (
            "biot_coefficient = 0.8\n",
            "",
            "material `rock` has no `biot_coefficient`",
            "rock",
        ),
        (
            "density = \"2300 kg/m^3\"\n",
            "",
            "material `rock` has no `density`",
            "rock",
        ),
        (
            "storage = \"1e-10 1/Pa\"\n",
            "",
            "material `rock` has no storage",
            "rock",
        ),
        (
            "biot_coefficient = 0.8",
            "biot_coefficient = 0.8\nporosity = 0.1",
            "`storage` excludes `porosity`",
            "0.1",
        ),
        (
            "biot_coefficient = 0.8",
            "biot_coefficient = 0.8\nbulk_modulus = 1",
            "`storage` excludes `bulk_modulus`",
            "1",
        ),
    ]);
}

#[test]
fn density_is_needed_for_weight_and_inertia_only() {
    let light = without("[gravity]", "[flow").replace("density = \"2300 kg/m^3\"\n", "");
    assert_eq!(faults(&light, &[]), []);
    let dynamic = ["mechanics.mode=dynamic", "scheme.name=semi-implicit"];
    assert_eq!(
        messages(&light, &dynamic),
        ["material `rock` has no `density`"]
    );
}

#[test]
fn mechanics_alone_needs_neither_fluid_nor_flow_properties() {
    let text = without("[flow", "[mechanics]");
    let start = text.find("[coupling]").unwrap();
    let end = text.find("[time]").unwrap();
    let text = format!("{}{}", &text[..start], &text[end..])
        .replace("[fluid]\nviscosity = \"1 cP\"\n", "")
        .replace("permeability = \"1 mD\"\nstorage = \"1e-10 1/Pa\"\n", "");
    assert_eq!(
        faults(&text, &[]),
        [],
        "gravity, a lone Biot coefficient, and no storage"
    );
    let steady = text
        .replace("end = \"1 d\"", "mode = \"steady\"")
        .replace("{ time = [0, 1], value = [0, \"1 mm\"] }", "\"1 mm\"");
    assert_eq!(faults(&steady, &[]), []);
    let moving = text.replace("end = \"1 d\"", "mode = \"steady\"");
    let message = "a steady run needs loads that are constant in time";
    assert_eq!(messages(&moving, &[]), [message]);
}

#[test]
fn the_schemes_are_known_and_their_numbers_checked() {
    for name in [
        "implicit",
        "explicit",
        "semi-implicit",
        "staggered",
        "monolithic",
    ] {
        let set = format!("scheme.name={name}");
        let scene = load(COUPLED, &[&set]).unwrap().scene;
        assert_eq!(scene.scheme.name.name(), name);
    }
    check(&[
        (
            "relaxation = 0",
            "relaxation = -1",
            "`relaxation` must lie between 0 and 10, found -1",
            "-1",
        ),
        (
            "acceleration = \"aitken\"",
            "acceleration = \"aitkin\"",
            "`aitkin` is not known here",
            "\"aitkin\"",
        ),
        (
            "coupling_tolerance = 1e-6",
            "coupling_tolerance = 0",
            "`coupling_tolerance` must lie between 1e-14 and 0.001, found 0",
            "0",
        ),
        (
            "coupling_iterations = 20",
            "coupling_iterations = 0",
            "`coupling_iterations` must lie between 1 and 1e6, found 0",
            "0",
        ),
        (
            "solid = \"adr\"",
            "solid = \"ard\"",
            "`ard` is not known here",
            "\"ard\"",
        ),
        (
            "adr_tolerance = 1e-5",
            "adr_tolerance = 0",
            "`adr_tolerance` must lie between 1e-14 and 1e-5, found 0",
            "0",
        ),
        (
            "adr_iterations = 1000",
            "adr_iterations = 0",
            "`adr_iterations` must lie between 1 and 1e9, found 0",
            "0",
        ),
        (
            "adr_smoothing = 1",
            "adr_smoothing = 0",
            "`adr_smoothing` must lie between 0.001 and 1, found 0",
            "0",
        ),
        (
            "adr_smoothing = 1",
            "adr_smoothing = 1.5",
            "`adr_smoothing` must lie between 0.001 and 1, found 1.5",
            "1.5",
        ),
    ]);
}

#[test]
fn coupled_references_need_the_coupling() {
    for name in ["terzaghi", "mandel"] {
        let set = format!("reference.type={name}");
        assert_eq!(faults(COUPLED, &[&set]), []);
        let found = messages(&without("[mechanics]", "[time]"), &[&set]);
        assert_eq!(found, ["this reference needs [coupling]"]);
    }
}
