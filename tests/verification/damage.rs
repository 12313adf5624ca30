//! Rock that breaks, against closed forms (REFERENCES.md: damage bar, pressurised crack).

use crate::support::{model, plan, plan_of, run_case, try_run};
use perifrac::run::openings;

/// A strip of 1 m that is pulled along x without a change across: the bar of the closed form.
const BAR: &str = r#"title = "Bar"
[geometry]
type = "lattice"
size = [1, 0.2]
points = [20, 4]
[materials.rock]
youngs_modulus = "20 GPa"
poissons_ratio = 0
fracture_energy = "100 J/m^2"
[mechanics.boundary.left]
roller = true
[mechanics.boundary.right]
normal_displacement = { time = [0, 1, 2], value = [0, 1, 0] }
[mechanics.boundary.top]
roller = true
[mechanics.boundary.bottom]
roller = true
[damage]
model = "paper"
length_scale = "0.01 m"
tolerance = 1e-9
[time]
end = 1
step = 0.1
"#;

const MODULUS: f64 = 2e10;
/// G_c/ℓ.
const TOUGHNESS: f64 = 1e4;

/// Peak stress (3√3/16)√(2EG_c/ℓ) at the strain √(2G_c/3Eℓ), and E ε/(1 + ½Eε²ℓ/G_c)² before.
#[test]
fn a_bar_follows_the_closed_form_to_its_peak() {
    let critical = (2.0 * TOUGHNESS / (3.0 * MODULUS)).sqrt();
    let strength = 3.0 * 3.0_f64.sqrt() / 16.0 * (2.0 * MODULUS * TOUGHNESS).sqrt();
    for share in [0.3, 0.7, 1.0] {
        let strain = share * critical;
        let pull = format!(
            "mechanics.boundary.right={{normal_displacement = {{time = [0, 1], value = [0, {strain}]}}}}"
        );
        let (summary, state) = try_run(&plan_of(BAR, &[&pull])).unwrap();
        let results = summary.results.unwrap();
        // Force in kN of a slab of 1 m on a height of 0.2 m.
        let stress = results.peak_force.unwrap() * 1e3 / 0.2;
        let half = 0.5 * MODULUS * strain * strain / TOUGHNESS;
        let exact = MODULUS * strain / (1.0 + half).powi(2);
        assert!(
            (stress / exact - 1.0).abs() < 1e-5,
            "{share}: {stress} {exact}"
        );
        assert!(share < 1.0 || (stress / strength - 1.0).abs() < 1e-5);
        let solid = model::<2>(&plan_of(BAR, &[&pull])).solid.unwrap();
        let damage = solid.damage.as_ref().unwrap();
        let found = damage.of(&state.history);
        let expected = half / (1.0 + half);
        assert!(
            found.iter().all(|s| (s - expected).abs() < 1e-5),
            "{share}: {expected}"
        );
    }
}

/// Sneddon with the factor 0.939 of a clamped block of 1 m (REFERENCES.md).
#[test]
fn a_damaged_band_opens_like_a_cut_crack() {
    let damaged = [
        "geometry.spacing=0.01",
        "cracks.main.kind=damaged",
        "damage.model=paper",
        "damage.length_scale=0.01",
        "materials.rock.fracture_energy=1e9",
    ];
    let plan = plan("sneddon", &damaged);
    let (summary, state) = try_run(&plan).unwrap();
    let found = openings(&model::<2>(&plan), &state, 0);
    let exact = |x: f64| 4.0 * 1e7 * 0.96 / 2e10 * (0.01 - x * x).sqrt();
    let places = found
        .iter()
        .enumerate()
        .map(|(k, jump)| (0.002 * (k as f64 + 0.5), jump[0]));
    let pairs: Vec<(f64, f64)> = places.map(|(x, jump)| (jump, 0.939 * exact(x))).collect();
    let norm = |value: &dyn Fn(&(f64, f64)) -> f64| {
        pairs
            .iter()
            .map(|pair| value(pair).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let error = norm(&|(found, exact)| found - exact) / norm(&|(_, exact)| *exact);
    assert!(error < 0.10, "{error}");
    let cut = run_case("sneddon", &["geometry.spacing=0.01"]).0;
    let both = [&summary, &cut].map(|s| s.errors["opening"].l2_over_norm);
    assert!((both[0] - both[1]).abs() < 0.10, "{both:?}");
    assert!(summary.counters.newton_iterations <= 12);
}

/// A damaged crack in a block under 30 MPa across it, at any angle to the rows: its faces are together, however much
/// the rock beside it is compressed.
#[test]
fn the_faces_of_a_closed_crack_do_not_overlap() {
    for points in ["[[0.3, 0.5], [0.7, 0.5]]", "[[0.35, 0.4], [0.65, 0.6]]"] {
        let plan = plan_of(&CLOSED.replace("POINTS", points), &[]);
        let (summary, state) = try_run(&plan).unwrap();
        let compressed = 30e6 / 22.2e9;
        let jumps = openings(&model::<2>(&plan), &state, 0);
        let overlap = jumps.iter().map(|jump| jump[0].abs()).fold(0.0, f64::max);
        assert!(overlap < 1e-6 * compressed, "{points}: {overlap} m");
        assert!(summary.displacement_max.unwrap() > 0.9 * compressed);
    }
}

const CLOSED: &str = r#"title = "Closed crack"
[geometry]
type = "lattice"
size = [1, 1]
points = [25, 25]
[materials.rock]
youngs_modulus = "20 GPa"
poissons_ratio = 0.2
fracture_energy = "100 J/m^2"
[mechanics.boundary]
left = { roller = true }
right = { roller = true }
bottom = { roller = true }
top = { traction = [0, "-30 MPa"] }
[damage]
friction = 10
[cracks.main]
kind = "damaged"
points = POINTS
[time]
mode = "steady"
[output]
vtu = false
"#;

/// What a scene does not name is not there.
#[test]
fn without_damage_there_is_no_history_and_no_evaluation() {
    let (summary, state) = run_case("sneddon", &["geometry.spacing=0.025"]);
    assert!(state.history.is_empty() && summary.results.is_none());
    assert_eq!(summary.counters.evaluations("damage"), 0);
    assert!(!summary.counters.field_bytes.contains_key("history"));
    assert_eq!(
        summary.counters.bytes.get("damage").copied().unwrap_or(0),
        0
    );
}
