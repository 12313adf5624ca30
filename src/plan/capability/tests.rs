//! Every rule of the table, each broken once in an otherwise sound scene, and its page.

use std::path::Path;

use super::*;
use crate::plan::{resolve, resolve_for};
use crate::scene::rules_tests::SOUND;
use crate::scene::rules_tests::coupling::without as cut_out;
use crate::scene::rules_tests::cracks::SOLID;
use crate::scene::rules_tests::damage::{DISC, PUMPED, without};
use crate::scene::rules_tests::mechanics::COUPLED;
use crate::scene::{Diagnostic, SceneErrors, load_str};

fn planned(text: &str, overrides: &[&str]) -> Result<Plan, SceneErrors> {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    resolve(
        &load_str("case.toml", text, Path::new("cases"), &overrides)?,
        "case",
    )
}

/// The faults as pairs of message and underlined words.
fn faults(text: &str, overrides: &[&str]) -> Vec<(String, String)> {
    let Err(errors) = planned(text, overrides) else {
        return Vec::new();
    };
    let excerpt = |fault: &Diagnostic| {
        let place = fault.place.and_then(|place| errors.sources.excerpt(place));
        (fault.message.clone(), place.unwrap_or("").to_owned())
    };
    errors.diagnostics.iter().map(excerpt).collect()
}

fn messages(text: &str, overrides: &[&str]) -> Vec<String> {
    let found = faults(text, overrides).into_iter();
    found.map(|(message, _)| message).collect()
}

fn one(message: &str, place: &str) -> Vec<(String, String)> {
    vec![(message.to_owned(), place.to_owned())]
}

/// A rock that can be drained and broken, with a density for what needs one.
const PUMPED_AND_WEIGHED: &str = "materials.rock.density=2300";

#[test]
fn the_page_in_the_folder_of_documents_is_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/combinations.md");
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        written.trim_end() == page().trim_end(),
        "write it anew: perifrac schemes > docs/combinations.md"
    );
}

#[test]
fn sound_scenes_are_admitted() {
    for text in [SOUND, COUPLED, PUMPED, DISC, SOLID] {
        assert_eq!(faults(text, &[]), []);
    }
}

#[test]
fn effects_have_something_to_act_on() {
    let rest = format!(
        "{}{}",
        SOUND.split("[flow]").next().unwrap(),
        &SOUND[SOUND.find("[wells.injector]").unwrap()..]
    );
    let found = faults(&rest, &[]);
    let expected = [
        "[gravity] has nothing to act on",
        "[wells] need [flow]",
        "the scene names no effect, so nothing would happen",
    ];
    assert_eq!(messages(&rest, &[]), expected);
    assert_eq!(found[0].1, "[gravity]");
    let start = SOUND.find("[gravity]").unwrap();
    let end = SOUND.find("[flow]").unwrap();
    let light = format!("{}{}", &SOUND[..start], &SOUND[end..]);
    let hydrostatic = |name: &str| (format!("`{name}` needs [gravity]"), "true".to_owned());
    assert_eq!(
        faults(&light, &[]),
        [hydrostatic("hydrostatic_start"), hydrostatic("hydrostatic")]
    );
}

#[test]
fn wells_of_known_pressure_stand_in_rock_that_stays_whole() {
    let hole = ["wells.injector.wellbore_radius=\"1 cm\""];
    assert_eq!(faults(SOUND, &hole), []);
    let loaded = load_str(
        "case.toml",
        SOUND,
        Path::new("cases"),
        &hole.map(str::to_owned),
    );
    let Err(errors) = resolve_for(&loaded.unwrap(), "case", 2) else {
        panic!("it works in one process only");
    };
    let message = &errors.diagnostics[0].message;
    assert_eq!(
        message,
        "wells whose bottom-hole pressure is known work in one process"
    );
    let well = "wells.w={at = [0.5, 0.5], pressure = 1, wellbore_radius = 1e-3}";
    let found = messages(PUMPED, &[well]);
    assert_eq!(found, ["no index of a well is known where rock breaks"]);
}

#[test]
fn coupling_joins_flow_and_mechanics() {
    let uncoupled = cut_out("[coupling]", "[time]");
    let expected = "flow and mechanics without [coupling] would not feel each other";
    assert_eq!(faults(&uncoupled, &[]), one(expected, "[mechanics]"));
    let dry = cut_out("[flow", "[mechanics]");
    assert_eq!(
        faults(&dry, &[]),
        one("[coupling] needs [flow]", "[coupling]")
    );
    let rigid = cut_out("[mechanics]", "[coupling]");
    assert_eq!(
        faults(&rigid, &[]),
        one("[coupling] needs [mechanics]", "[coupling]")
    );
}

#[test]
fn inertia_needs_a_scheme_that_has_it() {
    let dynamic = COUPLED.replace("\"quasi-static\"", "\"dynamic\"");
    for name in ["implicit", "staggered", "monolithic"] {
        let text = dynamic.replace("\"staggered\"", &format!("\"{name}\""));
        let message = format!("`{name}` has no inertia");
        assert_eq!(faults(&text, &[]), one(&message, &format!("\"{name}\"")));
    }
    let unnamed = dynamic.replace("name = \"staggered\"\n", "");
    let expected = one("`implicit` has no inertia", "\"dynamic\"");
    assert_eq!(faults(&unnamed, &[]), expected);
    let start = dynamic.find("[scheme]").unwrap();
    assert_eq!(
        faults(&dynamic[..start], &[]),
        expected,
        "no [scheme] at all"
    );
    for name in ["explicit", "semi-implicit"] {
        let set = format!("scheme.name={name}");
        assert_eq!(faults(&dynamic, &[&set]), []);
    }
    let implicit = ["scheme.name=semi-implicit", "time.integrator=tr-bdf2"];
    let expected = one("dynamics take the pressure by backward Euler", "tr-bdf2");
    assert_eq!(faults(&dynamic, &implicit), expected);
    let plate = [
        "scheme.name=explicit",
        "mechanics.boundary.right={plate = 1}",
    ];
    assert_eq!(messages(&dynamic, &plate), ["a rigid `plate` has no mass"]);
}

#[test]
fn a_steady_run_has_neither_inertia_nor_steps() {
    let still = COUPLED
        .replace("end = \"1 d\"", "mode = \"steady\"")
        .replace("{ time = [0, 1], value = [0, \"1 mm\"] }", "\"1 mm\"");
    assert_eq!(faults(&still, &[]), []);
    let found = faults(&still, &["scheme.name=semi-implicit"]);
    let expected = one("a steady run has no semi-implicit scheme", "semi-implicit");
    assert_eq!(found, expected);
    let found = messages(&still, &["mechanics.mode=dynamic"]);
    assert_eq!(found, ["a steady run cannot be dynamic"]);
}

#[test]
fn stabilisation_needs_a_system() {
    let set = ["coupling.stabilisation=1", "scheme.name=explicit"];
    let expected = one("`stabilisation` needs a linear system", "1");
    assert_eq!(faults(COUPLED, &set), expected);
    assert_eq!(faults(COUPLED, &set[..1]), []);
}

#[test]
fn damage_needs_mechanics_at_rest_without_plates() {
    let rigid = without(
        &without(&without(DISC, "[mechanics"), "[cracks"),
        "[materials",
    ) + "[materials.rock]\nfracture_energy = 1\n";
    assert!(messages(&rigid, &[]).contains(&"[damage] needs [mechanics]".to_owned()));
    let dynamic = [
        "mechanics.mode=dynamic",
        "scheme.name=explicit",
        PUMPED_AND_WEIGHED,
        "time={end = 1}",
    ];
    assert_eq!(
        messages(DISC, &dynamic),
        ["damage needs quasi-static mechanics"]
    );
    let plate = ["mechanics.boundary.right={plate = 1}"];
    let expected = ["a rigid `plate` and [damage] do not go together"];
    assert_eq!(messages(PUMPED, &plate), expected);
}

#[test]
fn a_steady_run_has_damage_without_flow_only() {
    let steady = PUMPED
        .replace("end = \"10 s\"", "mode = \"steady\"")
        .replace("shortest_step = \"1 ms\"\n", "");
    let expected = one("a steady run has no flow in fractures", "[fracture_flow]");
    assert_eq!(faults(&steady, &[]), expected);
    let plain = without(&without(&steady, "[fracture_flow]"), "[cracks");
    let expected = one("a steady run with [flow] has no [damage]", "[damage]");
    assert_eq!(faults(&plain, &[]), expected);
    let transient = without(&without(PUMPED, "[fracture_flow]"), "[cracks");
    let expected = one("[damage] and [flow] need [fracture_flow]", "[damage]");
    assert_eq!(faults(&transient, &[]), expected);
}

#[test]
fn fracture_flow_needs_damage_flow_and_coupling() {
    for section in ["[damage]", "[flow]", "[coupling]"] {
        let text = without(&without(PUMPED, section), "[cracks")
            .replace("[horizon]\nlength_scale_ratio = 0.5\n", "");
        let expected = (
            format!("[fracture_flow] needs {section}"),
            "[fracture_flow]".to_owned(),
        );
        let found = faults(&text, &[]);
        assert!(found.contains(&expected), "{found:?}");
    }
}

#[test]
fn flow_in_fractures_does_without_much() {
    let side = "mechanics.boundary.right={normal_displacement = 1}";
    let weighed = ["gravity.acceleration=[0, -9.81]", PUMPED_AND_WEIGHED];
    let rows: [(&[&str], &str); 5] = [
        (&[side], "sides do not move where fluid flows in fractures"),
        (&weighed, "gravity does not act on flow in fractures yet"),
        (
            &["coupling.stabilisation=1"],
            "flow in fractures has no `stabilisation`",
        ),
        (
            &["time.integrator=tr-bdf2"],
            "flow in fractures needs backward-euler: its coefficients change within a step",
        ),
        (
            &["scheme.name=semi-implicit"],
            "fractures have no undrained start with the semi-implicit scheme",
        ),
    ];
    for (set, message) in rows {
        assert_eq!(messages(PUMPED, set), [message]);
    }
    let drained = [
        "scheme.name=semi-implicit",
        "coupling.undrained_start=false",
    ];
    assert_eq!(faults(PUMPED, &drained), []);
    let moved = ["mechanics.boundary.right={normal_displacement = 0}"];
    assert_eq!(faults(PUMPED, &moved), [], "a side that stays where it is");
}

#[test]
fn cracks_need_what_makes_and_fills_them() {
    let alone = SOLID.replace("[mechanics.boundary.left]\nclamped = true\n", "");
    assert!(messages(&alone, &[]).contains(&"[cracks] need [mechanics]".to_owned()));
    let cut = PUMPED.replace("kind = \"damaged\"", "kind = \"cut\"");
    let message = "a cut crack and [flow] do not go together";
    assert_eq!(faults(&cut, &[]), one(message, "\"cut\""));
    let unsaid = PUMPED.replace("kind = \"damaged\"\n", "");
    assert_eq!(faults(&unsaid, &[]), one(message, "notch"));
    let text = without(PUMPED, "[fracture_flow]");
    let message = "a damaged crack and [flow] need [fracture_flow]";
    assert_eq!(faults(&text, &[]), one(message, "\"damaged\""));
    let whole = without(DISC, "[damage]");
    assert_eq!(messages(&whole, &[]), ["a damaged crack needs [damage]"]);
    let dry = "cracks.penny.injection={rate = 1, at = [0.5, 0.5, 0.5]}";
    let text = DISC.replace("pressure = \"1 MPa\"\n", "");
    assert_eq!(messages(&text, &[dry]), ["an `injection` needs [flow]"]);
}

#[test]
fn cracks_that_are_cut_keep_the_plain_gradient() {
    let asked = ["mechanics.gradient=divergence-consistent"];
    let message =
        "the divergence-consistent gradient does not go together with cracks that are cut";
    assert_eq!(faults(SOLID, &asked), one(message, "divergence-consistent"));
    assert_eq!(messages(DISC, &asked), [""; 0]);
}

#[test]
fn rock_that_breaks_has_the_moduli_of_its_points() {
    let message = "rock that breaks has the moduli of its points, not those of layers";
    let asked = ["mechanics.interfaces=laminate"];
    assert_eq!(faults(DISC, &asked), one(message, "laminate"));
    assert_eq!(messages(DISC, &["mechanics.interfaces=auto"]), [""; 0]);
}

#[test]
fn processes_are_for_schemes_with_systems() {
    let among_two = |text: &str, set: &[&str]| {
        let set: Vec<String> = set.iter().map(|&text| text.to_owned()).collect();
        let loaded = load_str("case.toml", text, Path::new("cases"), &set).unwrap();
        match resolve_for(&loaded, "case", 2) {
            Ok(plan) => refusals(&plan, 2).iter().map(ToString::to_string).collect(),
            Err(errors) => (errors.diagnostics.iter())
                .map(|fault| fault.message.clone())
                .collect::<Vec<String>>(),
        }
    };
    assert_eq!(among_two(SOUND, &[]), [""; 0]);
    let explicit = among_two(SOUND, &["scheme.name=explicit"]);
    assert_eq!(explicit, ["the explicit scheme works in one process"]);
    assert_eq!(among_two(PUMPED, &[]), ["damage works in one process"]);
    let dynamic = ["mechanics.mode=dynamic", "scheme.name=explicit"];
    assert_eq!(
        among_two(COUPLED, &dynamic),
        ["dynamics work in one process"]
    );
    let alone = among_two(SOUND, &["solver.name=faer-llt"]);
    assert!(alone[0].contains("choose `petsc` or `auto`"), "{alone:?}");
}

#[test]
fn a_solver_takes_the_systems_of_the_scheme() {
    let refused = |set: &[&str]| {
        let plan = planned(COUPLED, set).unwrap();
        refusals(&plan, 1)
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<String>>()
    };
    let solver = "solver.name=faer-llt";
    assert_eq!(refused(&[solver]), [""; 0]);
    let found = refused(&[solver, "scheme.name=monolithic"]);
    assert!(
        found[0].contains("refuses a quasi-definite system"),
        "{found:?}"
    );
    assert_eq!(refused(&[solver, "scheme.name=explicit"]), [""; 0]);
}

/// A rule that no features can break, or that another one always goes with, would say nothing.
#[test]
fn every_rule_is_broken_by_what_it_names() {
    for rule in RULES {
        let named: Features = rule.with.iter().copied().collect();
        let schemes = match rule.schemes.is_empty() {
            true => &[SchemeName::Implicit][..],
            false => rule.schemes,
        };
        for scheme in schemes {
            let mut found = broken(*scheme, &named);
            assert!(found.any(|own| std::ptr::eq(own, rule)), "{}", rule.reason);
        }
    }
}
