//! Rows that are kept change the way to equilibrium, not the equilibrium.

use std::path::Path;

use super::tangents::KEPT;
use super::*;
use crate::plan::{Plan, resolve};
use crate::report::Timers;
use crate::scene::load_str;

fn plan() -> Plan {
    let text = include_str!("../../../cases/notched-tension/scene.toml");
    let small = [
        "geometry.points=[20, 20]",
        "damage.length_scale=0.2 mm",
        "damage.tolerance=1e-8",
    ];
    let loaded = load_str("notch", text, Path::new(""), &small.map(str::to_owned));
    resolve(&loaded.unwrap(), "notch").unwrap()
}

/// Displacement after some damage, and how many families were filled.
fn pulled(kept: f64) -> (Vec<f64>, u64) {
    let plan = plan();
    let model = Model::<2>::build(&plan, &mut Timers::default()).unwrap();
    let damage = plan.damage.unwrap();
    let mut solver = Fracture::new(&plan.fracture_demand(), &model, damage).unwrap();
    solver.tangent.kept = kept;
    let mut state = State::initial(&model);
    for time in [1500.0, 2500.0, 3000.0] {
        state.time = time;
        solver.equilibrate(&model, &mut state).unwrap();
        crate::schemes::advance(&model, &mut state);
    }
    (state.displacement, solver.tangent.refilled)
}

#[test]
fn the_full_refill_gives_the_same_field_with_more_work() {
    let ((sparing, few), (full, many)) = (pulled(KEPT), pulled(0.0));
    let largest = full.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let apart = full.iter().zip(&sparing).map(|(f, s)| (f - s).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart < 1e-5 * largest, "{apart} of {largest}");
    assert!(2 * few < many, "{few} {many}");
}
