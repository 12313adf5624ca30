//! Strength by the widths of families: c = G_c/W̄ at every point.

use crate::support::{model, plan_of};

/// A block of 24² points, δ = 2.3 Δx, clamped below, free elsewhere, with a cut from the left.
const BLOCK: &str = r#"title = "Block"
[geometry]
type = "lattice"
size = [1, 1]
points = [24, 24]
[horizon]
ratio = 2.3
[materials.rock]
youngs_modulus = "20 GPa"
poissons_ratio = 0.3
fracture_energy = "100 J/m^2"
[mechanics.boundary]
bottom.clamped = true
left.free = true
right.free = true
top.free = true
[cracks.cut]
points = [[0, 0.5], [0.4, 0.52]]
[damage]
model = "paper"
length_scale = "0.02 m"
residual_stiffness = 1e-6
normalise = "mean"
[time]
end = 1
step = 1
"#;

const FRACTURE_ENERGY: f64 = 100.0;

/// c_i 2δ_i/G_c of every point.
fn strengths(overrides: &[&str]) -> Vec<f64> {
    let solid = model::<2>(&plan_of(BLOCK, overrides)).solid.unwrap();
    let horizon = &solid.elastic.around.families.horizon;
    let toughness = &solid.damage.as_ref().unwrap().toughness;
    let both = toughness.iter().zip(horizon);
    both.map(|(c, delta)| c * 2.0 * delta / FRACTURE_ENERGY)
        .collect()
}

/// W̄/2δ of the square lattice for (1 − s)², ν = 0.3 and k = 1e-6, and its mean over lattices of 28² points jittered
/// by a quarter, from a separate program.
const WIDTHS: [(&str, f64, f64); 2] = [
    ("horizon.ratio=2.3", 0.877391, 0.808),
    ("horizon.ratio=3.05", 0.841112, 0.816),
];

/// Free sides, corners, and the faces of the cut have the strength of the inside.
#[test]
fn every_point_of_a_lattice_has_the_fracture_energy_over_the_mean_width_of_its_whole_family() {
    for (ratio, width, _) in WIDTHS {
        for strength in strengths(&[ratio]) {
            assert!((strength * width - 1.0).abs() < 1e-5, "{strength} {width}");
        }
    }
}

/// The mean width of the table is that over directions, so that c W(n) over directions is G_c on average.
#[test]
fn over_directions_a_jittered_point_takes_the_fracture_energy_on_average() {
    for (ratio, _, width) in WIDTHS {
        let overrides = [ratio, "geometry.jitter=0.25", "geometry.seed=4"];
        let solid = model::<2>(&plan_of(BLOCK, &overrides)).solid.unwrap();
        let toughness = &solid.damage.as_ref().unwrap().toughness;
        let widths = solid.widths.as_ref().unwrap();
        for (point, strength) in toughness.iter().enumerate() {
            let directions = widths.directions();
            let taken: f64 = (directions.iter())
                .map(|normal| strength * widths.width(point, normal))
                .sum();
            let mean = taken / directions.len() as f64;
            assert!((mean / FRACTURE_ENERGY - 1.0).abs() < 1e-12, "{mean}");
        }
        let all = strengths(&overrides);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        assert!((mean * width - 1.0).abs() < 0.01, "{mean} {width}");
        let deviation = all.iter().map(|strength| (strength / mean - 1.0).powi(2));
        let deviation = (deviation.sum::<f64>() / all.len() as f64).sqrt();
        assert!((0.01..0.1).contains(&deviation), "{deviation}");
    }
}
