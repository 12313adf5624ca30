//! Fluid that leaks out of a crack into the rock beside it (Carter).

use std::f64::consts::PI;

use perifrac::plan::Plan;

use crate::support::{model, plan, plan_of, try_run};

const MODULUS: f64 = 20e9 / 0.96;
const RATE: f64 = 1e-4;
const ACROSS: f64 = 5e6;
const NOTCH: f64 = 0.5;

/// Fluid efficiency after `end` seconds of a crack whose fluid has no friction: 2π l² p/E′ of it is open at the net
/// pressure p, at most K_Ic/√(πl), and every point of its four faces has taken 2 √(κ s/π) ∫ √(t − t′) dp(t′) since it
/// came to be. Each tip takes κ ∫ p dt more: what a slit of pressure takes in the plane, beside its faces, by the
/// corner of 2π at its end (van den Berg and Srisatkunarajah 1990). Integrated in time, with faces of 2 mm.
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
            let tips = 2.0 * mobility * dt * pressure.iter().map(|(_, value)| value).sum::<f64>();
            4.0 * FACE * since.iter().map(|from| taken(*from)).sum::<f64>() + tips
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

/// Share of what was pumped that is in the crack at the end.
fn kept(plan: &Plan) -> f64 {
    let (summary, _) = try_run(plan).unwrap();
    assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
    summary.results.unwrap().fluid_efficiency.unwrap()
}

/// Carter's leak-off with constant diffusion into rock beside the crack: the band of a crack is no reservoir.
#[test]
fn half_of_the_fluid_leaks_off_by_carters_law() {
    // The fluid reaches 1.75 spacings deep.
    let block = "geometry.size=[\"1.6 m\", \"2.4 m\"]";
    let found = kept(&plan("kgd-leak-off", &["geometry.spacing=4 cm", block]));
    let exact = efficiency(2.5e-13, 1e-10, 2.0);
    assert!((0.50..0.52).contains(&exact), "{exact}");
    assert!((found / exact - 1.0).abs() < 0.05, "{found} for {exact}");
}

/// Rock that lets nothing in drinks nothing, however much its pores would hold.
#[test]
fn what_rock_stores_does_not_matter_where_nothing_leaks() {
    for storage in ["1e-12", "1e-10", "1e-9"] {
        let storage = format!("materials.rock.storage={storage}");
        let permeability = "materials.rock.permeability=1e-30";
        let tight = ["geometry.spacing=10 cm", permeability, &storage];
        let found = kept(&plan("kgd-leak-off", &tight));
        assert!(found > 0.99, "{storage}: {found}");
    }
}

/// Passes that lead astray leave no fluid in rock that is sound where they end.
#[test]
fn fluid_of_a_crack_is_where_rock_is_broken() {
    let plan = plan("kgd-leak-off", &["geometry.spacing=10 cm"]);
    let (_, state) = try_run(&plan).unwrap();
    let model = model::<2>(&plan);
    let model = model.at(state.coefficients.as_ref());
    let response = model.response(&state.view()).unwrap();
    let cracks = model.cracks().unwrap();
    let wet: Vec<usize> = (0..model.cloud.len())
        .filter(|point| cracks.is_wet(*point))
        .collect();
    // Two rows of half a crack of ten points, at the least.
    assert!(wet.len() >= 10, "{wet:?}");
    for point in wet {
        let damage = response.damage[point];
        assert!(damage >= 0.01, "{point}: {damage}");
    }
}

/// A crack from side to side whose fluid leaves through the rock above it, in which lies a barrier one cell thick
/// and a million times tighter.
const BARRIER: &str = r#"title = "A crack beside a barrier one cell thick"
[geometry]
type = "lattice"
size = ["0.5 m", "2 m"]
spacing = "5 cm"

[fluid]
viscosity = "1 mPa s"

[materials.rock]
youngs_modulus = "20 GPa"
poissons_ratio = 0.2
fracture_energy = "1e9 J/m^2"
permeability = "1e-14 m^2"
storage = "1e-12 1/Pa"
biot_coefficient = 0

[materials.barrier]
youngs_modulus = "20 GPa"
poissons_ratio = 0.2
fracture_energy = "1e9 J/m^2"
permeability = "1e-20 m^2"
storage = "1e-12 1/Pa"
biot_coefficient = 0
region = { type = "box", min = ["0 m", "1 m"], max = ["0.5 m", "1.05 m"] }

[mechanics]
[mechanics.boundary.left]
roller = true
[mechanics.boundary.right]
roller = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.top]
roller = true

[flow]
[flow.boundary.top]
pressure = 0

[coupling]
undrained_start = false

[damage]

[fracture_flow]

[cracks.main]
kind = "damaged"
points = [["0 m", "0 m"], ["0.5 m", "0 m"]]
injection = { rate = "2e-13 m^2/s", at = ["0 m", "0 m"] }

[scheme]
name = "monolithic"

[time]
end = "1e9 s"

[output]
vtu = false
"#;

/// Of rock in series the barrier holds q h/κ, whatever the families of the crack reach across: 500 Pa for
/// 1e-13 m/s through 5 cm of 1e-17 m²/(Pa s), and 0.02 Pa the rock. The same with rock that conducts so along layers.
#[test]
fn a_crack_leaks_through_a_barrier_of_one_cell_as_through_layers_in_series() {
    let along = "materials.barrier.permeability={k1=\"1e-17 m^2\", k2=\"1e-20 m^2\", angle=0}";
    for barrier in ["materials.barrier.permeability=1e-20", along] {
        let (summary, state) = try_run(&plan_of(BARRIER, &[barrier])).unwrap();
        let crack = state.pressure[0];
        assert!((crack / 500.02 - 1.0).abs() < 1e-4, "{barrier}: {crack}");
        assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
    }
}
