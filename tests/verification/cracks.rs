//! Cracks that are cut: Sneddon's opening (Proc. R. Soc. Lond. A 187, 1946, 229–260), and uniform stress
//! around pressurised faces.

use perifrac::geometry::Vector;
use perifrac::run::openings;

use crate::support::{model, plan, plan_of, run_case, try_run};

/// Opening over Sneddon's of a crack of half length 0.1 m in a clamped square of 1 m and of 2 m.
const CLAMPED: [f64; 2] = [0.939, 0.984];

/// Difference to Sneddon's ellipse times the factor of the finite block, norm over norm.
fn difference(overrides: &[&str], factor: f64) -> f64 {
    let plan = plan("sneddon", overrides);
    let (summary, state) = try_run(&plan).unwrap();
    assert_eq!(summary.counters.mechanics.as_ref().unwrap().solves, 1);
    let model = model::<2>(&plan);
    let computed = openings(&model, &state, 0);
    let pressure = plan.cracks[0].pressure.as_ref().unwrap().at(0.0);
    let exact = perifrac::plan::exact_opening(&plan).unwrap().unwrap();
    let places = model.places.cracks[0].iter();
    let exact: Vec<f64> = places
        .map(|faces| factor * exact.opening(faces.on.at.as_slice(), pressure))
        .collect();
    let pairs = || computed.iter().map(|jump| jump[0]).zip(&exact);
    let left: f64 = pairs().map(|(own, exact)| (own - exact).powi(2)).sum();
    let relative = (left / exact.iter().map(|w| w * w).sum::<f64>()).sqrt();
    println!(
        "{overrides:?}: {relative:.4}, {:?}",
        summary.errors["opening"]
    );
    relative
}

#[test]
fn the_opening_of_a_pressurised_crack_is_sneddons() {
    let coarse = difference(&[], CLAMPED[0]);
    let fine = difference(&["geometry.spacing=2.5e-3"], CLAMPED[0]);
    assert!(coarse < 0.06, "{coarse}");
    assert!(fine < 0.035 && fine < coarse, "{fine}");
    let wide = [
        "geometry.size=[1, 2]",
        "cracks.main.points=[[0, 1], [0.1, 1]]",
    ];
    let wide = difference(&wide, CLAMPED[1]);
    assert!(wide < 0.06, "{wide}");
}

#[test]
fn half_a_crack_beside_a_plane_of_symmetry_is_a_whole_one() {
    let (half, _) = run_case("sneddon", &["geometry.spacing=0.0125"]);
    let whole = [
        "geometry.size=[1, 1]",
        "geometry.spacing=0.0125",
        "mechanics.boundary.left={clamped=true}",
        "cracks.main.points=[[0.4, 0.5], [0.6, 0.5]]",
    ];
    let (whole, _) = run_case("sneddon", &whole);
    let largest = [&half, &whole].map(|summary| summary.displacement_max.unwrap());
    assert!(
        (largest[0] - largest[1]).abs() < 1e-9 * largest[0],
        "{largest:?}"
    );
    assert!(largest[0] > 5e-5, "{largest:?}");
}

/// A body under the same pressure from outside and on the faces of its cracks, which hang together, end
/// inside and leave through a side.
const PRESSED: &str = r#"
title = "pressed from all sides"
[geometry]
type = "lattice"
size = [1, 0.8]
points = [40, 32]
[materials.rock]
youngs_modulus = 10
poissons_ratio = 0.2
[mechanics]
[mechanics.boundary.left]
roller = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.right]
traction = [-1e-3, 0]
[mechanics.boundary.top]
traction = [0, -1e-3]
[cracks.bent]
points = [[0.301, 0.2], [0.52, 0.41], [0.7, 0.35]]
pressure = 1e-3
[cracks.across]
points = [[0.4, 0.5], [0.61, 0.203]]
pressure = 1e-3
[cracks.edge]
points = [[0.85, 0.8], [0.83, 0.61]]
pressure = 1e-3
[cracks.symmetry]
points = [[0, 0.7], [0.2, 0.7]]
pressure = 1e-3
[time]
mode = "steady"
"#;

#[test]
fn the_same_pressure_outside_and_on_the_faces_strains_uniformly() {
    let plan = plan_of(PRESSED, &[]);
    let (_, state) = try_run(&plan).unwrap();
    let model = model::<2>(&plan);
    // Plane strain under σ = −p I: ε = −p (1 + ν)(1 − 2ν)/E.
    let strain = -1e-3 * 1.2 * 0.6 / 10.0;
    let positions = model.cloud.position.iter();
    let moved = state.displacement.chunks_exact(2);
    let error = positions
        .zip(moved)
        .map(|(x, u)| (Vector::from([u[0], u[1]]) - x * strain).norm());
    let worst = error.fold(0.0, f64::max) / strain.abs();
    assert!(worst < 1e-10, "{worst:.1e}");
    for crack in 0..plan.cracks.len() {
        let closed = openings(&model, &state, crack);
        assert!(
            closed
                .iter()
                .flatten()
                .all(|jump| jump.abs() < 1e-10 * strain.abs())
        );
    }
    let families = &model.solid.as_ref().unwrap().elastic.around.families;
    let severed = families.severed.as_ref().unwrap();
    assert!(severed.iter().any(|bond| bond.image != 0) && severed.len() > 500);
}

#[test]
fn a_crack_along_the_boundary_separates_nothing() {
    let plan = plan("sneddon", &["cracks.main.points=[[0.1, 1], [0.3, 1]]"]);
    let error = try_run(&plan).unwrap_err().to_string();
    assert!(error.contains("no point on one side"), "{error}");
}

#[test]
fn faces_that_overlap_are_told() {
    let warnings = |pressure| {
        let overrides = ["geometry.spacing=0.025", pressure];
        run_case("sneddon", &overrides).0.warnings
    };
    assert_eq!(warnings("cracks.main.pressure=1e6").len(), 0);
    let told = warnings("cracks.main.pressure=-1e6");
    assert!(told.len() == 1 && told[0].contains("overlap"), "{told:?}");
}

#[test]
fn without_cracks_nothing_of_them_is_held_or_evaluated() {
    let text =
        PRESSED.split("[cracks.bent]").next().unwrap().to_owned() + "[time]\nmode = \"steady\"\n";
    let (summary, _) = try_run(&plan_of(&text, &[])).unwrap();
    let bare = model::<2>(&plan_of(&text, &[])).solid.unwrap();
    assert!(bare.elastic.around.families.severed.is_none());
    assert!(!summary.counters.evaluations.contains_key("crack-pressure"));
    let (cracked, _) = try_run(&plan_of(PRESSED, &[])).unwrap();
    assert!(cracked.counters.evaluations["crack-pressure"] > 0);
    assert!(cracked.bonds < summary.bonds);
}
