//! A penny-shaped crack that a viscous fluid drives, against its exact solution (Savitski and Detournay 2002,
//! Propagation of a penny-shaped fluid-driven fracture in an impermeable rock).

use std::f64::consts::PI;

use perifrac::output::History;
use perifrac::run::{Interrupt, Writer, run};

use crate::support::{model, plan};

const MODULUS: f64 = 20e9 / 0.96;
const RATE: f64 = 1e-3;
/// 12 μ, Pa s.
const FRICTION: f64 = 1.2;

/// Radius and opening in the middle, m, without toughness.
fn exact(time: f64) -> (f64, f64) {
    let radius = 0.6976 * (MODULUS * RATE.powi(3) * time.powi(4) / FRICTION).powf(1.0 / 9.0);
    let width = 1.190 * (FRICTION.powi(2) * RATE.powi(3) * time / MODULUS.powi(2)).powf(1.0 / 9.0);
    (radius, width)
}

/// Δx = 20 cm, R = 3.3 Δx at the end; what was broken from the start had 2 Δx.
#[test]
fn a_viscous_fluid_drives_a_penny_at_its_exact_pace() {
    let plan = plan("penny-viscosity", &["time.end=0.45 s"]);
    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(folder.path(), "").unwrap();
    let ran = run(&plan, Some(&mut writer), &mut (), &Interrupt::default());
    let (summary, state) = ran.unwrap_or_else(|error| panic!("{error}"));
    let history = History::read(folder.path().join("history.csv")).unwrap();
    let last = |name: &str| *history.column(name).unwrap().last().unwrap();
    let (radius, width) = exact(last("time_s"));
    let found = (4.0 * last("crack_area_m2") / PI).sqrt();
    assert!((found / radius - 1.0).abs() < 0.04, "{found} for {radius}");
    let opening = last("opening_main_m");
    assert!(
        (opening / width - 1.0).abs() < 0.12,
        "{opening} for {width}"
    );
    // An eighth of the block takes an eighth of the rate.
    let results = summary.results.unwrap();
    let volume = results.crack_volume.unwrap() / (RATE * last("time_s") / 8.0);
    assert!((volume - 1.0).abs() < 1e-5, "{volume}");
    assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
    // The in-situ stress leaves nothing of the strength that fluid must overcome, so all that it ever reached is damaged.
    let model = model::<3>(&plan);
    let solid = model.solid.as_ref().unwrap();
    let damage = solid.damage.as_ref().unwrap().of(&state.history);
    let position = &model.cloud.position;
    let horizon = 2.3 * 0.2 + 1e-9;
    let leads = |from: usize, to: usize| {
        damage[from] > 0.1 && (position[from] - position[to]).norm() <= horizon
    };
    for i in (0..damage.len()).filter(|i| damage[*i] > 1e-6) {
        let broken = (0..damage.len()).any(|j| leads(j, i));
        assert!(broken, "nothing leads to {:?}: {}", position[i], damage[i]);
    }
}
