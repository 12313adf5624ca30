//! Patch tests: a linear pressure on clouds of varying spacing must be exact.

use crate::support::run_text;

/// A unit pressure drop along x over a uniform rock; the two-layer reference is linear then.
pub const COLUMN: &str = r#"
title = "column"
[geometry]
type = "graded"
axes = [
    [{ length = 0.5, spacing = 0.02 }, { length = 0.5, spacing = [0.02, 0.06] }],
    [{ length = 0.2, spacing = 0.02 }, { length = 0.2, spacing = [0.02, 0.05] }],
]
[fluid]
viscosity = 1
[materials.near]
permeability = 1
storage = 1
[materials.far]
permeability = 1
storage = 1
region = { type = "half-plane", point = [0.5, 0], normal = [1, 0] }
[flow]
[flow.boundary.left]
pressure = 1
[flow.boundary.right]
pressure = 0
[time]
mode = "steady"
[reference]
type = "two-layer"
"#;

const BLOCKS: &str = r#"geometry={type="blocks", size=[1, 0.4], spacing=0.05, refine=[{levels=2, region={type="box", min=[0, 0], max=[0.3, 0.4]}}]}"#;
const JITTERED: &str =
    r#"geometry={type="lattice", size=[1, 0.4], points=[25, 10], jitter=0.2, seed=4}"#;
const SOLID: &str = r#"geometry={type="blocks", size=[1, 0.5, 0.5], spacing=0.125, refine=[{levels=1, region={type="box", min=[0, 0, 0], max=[0.3, 0.3, 0.5]}}]}"#;
const SOLID_REGION: &str =
    r#"materials.far.region={type="half-plane", point=[0.5, 0, 0], normal=[1, 0, 0]}"#;

fn errors(overrides: &[&str]) -> (f64, f64) {
    let plain = [overrides, &["flow.gradient=plain"]].concat();
    let consistent = [overrides, &["flow.gradient=divergence-consistent"]].concat();
    let (with, _) = run_text(COLUMN, &consistent);
    let quality = with.consistency.expect("corrected");
    assert!(quality.after < 1e-11 && quality.ratio < 0.6, "{quality:?}");
    let (without, _) = run_text(COLUMN, &plain);
    println!("plain {:?}, consistent {:?}", without.errors, with.errors);
    (without.errors["pressure"].max, with.errors["pressure"].max)
}

#[test]
fn tensor_grading_with_sealed_sides() {
    let (plain, consistent) = errors(&[]);
    assert!(consistent <= 1e-10, "{consistent:.1e}");
    assert!(plain > 1e-3, "the plain gradient fails it: {plain:.1e}");
}

#[test]
fn two_to_one_blocks_with_sealed_sides() {
    let (plain, consistent) = errors(&[BLOCKS]);
    assert!(consistent <= 1e-10, "{consistent:.1e}");
    assert!(plain > 1e-3, "the plain gradient fails it: {plain:.1e}");
}

#[test]
fn a_jittered_cloud_with_sealed_sides() {
    let (plain, consistent) = errors(&[JITTERED]);
    assert!(consistent <= 1e-10, "{consistent:.1e}");
    assert!(plain > 1e-4, "the plain gradient fails it: {plain:.1e}");
}

#[test]
fn blocks_in_three_dimensions() {
    let (plain, consistent) = errors(&[SOLID, SOLID_REGION]);
    assert!(consistent <= 1e-10, "{consistent:.1e}");
    assert!(plain > 1e-3, "the plain gradient fails it: {plain:.1e}");
}

#[test]
fn the_correction_is_on_by_default_wherever_spacing_varies_and_only_there() {
    let operator = "flow.operator=correspondence";
    let (graded, _) = run_text(COLUMN, &[operator]);
    assert!(graded.consistency.is_some());
    let lattice = r#"geometry={type="lattice", size=[1, 0.4], points=[25, 10]}"#;
    let (uniform, _) = run_text(COLUMN, &[lattice, operator]);
    assert!(uniform.consistency.is_none() && uniform.second_hops == 0);
}

#[test]
fn a_prescribed_flux_balances_a_linear_pressure_for_every_operator() {
    let lattice = r#"geometry={type="lattice", size=[1, 0.4], points=[25, 10]}"#;
    // One unit of flux in through the left side gives the same linear pressure.
    let flux = "flow.boundary.left={flux=1}";
    for geometry in [lattice, BLOCKS] {
        for operator in ["path", "correspondence", "bond"] {
            let operator = &*format!("flow.operator={operator}");
            let plan = [geometry, operator, flux];
            let text = COLUMN.replace("[reference]\ntype = \"two-layer\"\n", "");
            let (summary, state) = run_text(&text, &plan);
            assert!((summary.outflow["right"] - 0.4).abs() < 1e-12);
            assert!(summary.balance.mass < 1e-12);
            if geometry == lattice {
                let exact = |i: usize| 1.0 - (0.5 + (i % 25) as f64) / 25.0;
                let gap = (0..state.pressure.len())
                    .map(|i| (state.pressure[i] - exact(i)).abs())
                    .fold(0.0, f64::max);
                assert!(gap < 1e-11, "{operator}: {gap:.1e}");
            }
        }
    }
}
