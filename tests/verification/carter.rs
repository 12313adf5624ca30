//! Fluid that leaks out of a crack into the rock beside it (Carter).

use std::f64::consts::PI;

use crate::support::{plan_of, try_run};

/// A quarter of a plane with a crack that fluid without viscosity drives, in rock that lets it in.
const LEAKING: &str = r#"
title = "A crack that leaks"
geometry = { type = "lattice", size = ["1.5 m", "1.5 m"], spacing = "5 cm" }
fluid.viscosity = "1e-6 Pa s"
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "100 J/m^2", permeability = "5e-19 m^2", storage = "5e-11 1/Pa", biot_coefficient = 0 }
initial.stress = { xx = "-10 MPa", yy = "-5 MPa" }
mechanics.boundary = { left = { roller = true }, bottom = { roller = true }, top = { roller = true } }
flow.operator = "bond"
damage = {}
fracture_flow = {}
time = { end = "1.6 s", first_step = "0.1 s", tolerance = 0.1, max_step = "0.1 s" }
[cracks.main]
kind = "damaged"
points = [["0 m", "0 m"], ["0.5 m", "0 m"]]
injection = { rate = "1e-4 m^2/s", at = ["0 m", "0 m"] }
[coupling]
undrained_start = false
[scheme]
name = "monolithic"
"#;

const MODULUS: f64 = 20e9 / 0.96;
const RATE: f64 = 1e-4;
const ACROSS: f64 = 5e6;
const NOTCH: f64 = 0.5;

/// Fluid efficiency after `end` seconds of a crack whose fluid has no friction: 2π l² p/E′ of it is open at the net
/// pressure p, at most K_Ic/√(πl), and every point of its four faces has taken 2 √(κ s/π) ∫ √(t − t′) dp(t′) since it
/// came to be. Integrated in time, with faces of 2 mm.
fn efficiency(mobility: f64, storage: f64, end: f64) -> f64 {
    const FACE: f64 = 2e-3;
    let dt = end / 400.0;
    let toughness = (100.0 * MODULUS).sqrt();
    let leaks = 2.0 * (mobility * storage / PI).sqrt();
    let mut since: Vec<f64> = vec![0.0; (NOTCH / FACE) as usize];
    let mut pressure: Vec<(f64, f64)> = Vec::new();
    let mut open = 0.0;
    for step in 1..=400 {
        let t = f64::from(step) * dt;
        let middle = t - 0.5 * dt;
        let leaked = |since: &[f64], pressure: &[(f64, f64)]| -> f64 {
            let taken = |from: f64| -> f64 {
                let mut before = 0.0;
                let mut sum = 0.0;
                for (at, value) in pressure {
                    sum += (value - before) * (t - at.max(from)).max(0.0).sqrt();
                    before = *value;
                }
                leaks * sum
            };
            4.0 * FACE * since.iter().map(|from| taken(*from)).sum::<f64>()
        };
        let filled = |since: &[f64], net: f64| {
            let mut now = pressure.clone();
            now.push((middle, (ACROSS + net).max(0.0)));
            let length = FACE * since.len() as f64;
            let volume = 2.0 * PI * length * length * net.max(0.0) / MODULUS;
            (volume + leaked(since, &now), volume)
        };
        let most = |since: &[f64]| toughness / (PI * FACE * since.len() as f64).sqrt();
        let mut net = most(&since);
        if filled(&since, net).0 >= RATE * t {
            let (mut low, mut high) = (-ACROSS, net);
            for _ in 0..50 {
                net = 0.5 * (low + high);
                match filled(&since, net).0 > RATE * t {
                    true => high = net,
                    false => low = net,
                }
            }
        } else {
            while filled(&since, net).0 < RATE * t {
                since.push(middle);
                net = most(&since);
            }
        }
        open = filled(&since, net).1;
        pressure.push((middle, (ACROSS + net).max(0.0)));
    }
    open / (RATE * end)
}

/// Carter's leak-off with constant diffusion into rock beside the crack: the band of a crack is no reservoir.
#[test]
fn half_of_the_fluid_leaks_off_by_carters_law() {
    let (summary, _) = try_run(&plan_of(LEAKING, &[])).unwrap();
    let found = summary.results.unwrap().fluid_efficiency.unwrap();
    let exact = efficiency(5e-13, 5e-11, 1.6);
    assert!((0.45..0.55).contains(&exact), "{exact}");
    assert!((found / exact - 1.0).abs() < 0.12, "{found} for {exact}");
    assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
}

/// Rock that lets nothing in drinks nothing, however much its pores would hold.
#[test]
fn what_rock_stores_does_not_matter_where_nothing_leaks() {
    let coarse = [
        "geometry.spacing=10 cm",
        "materials.rock.permeability=1e-30 m^2",
    ];
    let (summary, _) = try_run(&plan_of(LEAKING, &coarse)).unwrap();
    let kept = summary.results.unwrap().fluid_efficiency.unwrap();
    assert!(kept > 0.98, "{kept}");
}
