//! Clouds from meshes of Gmsh: a plate with a hole, and a block in space.

use std::path::Path;

use perifrac::plan::resolve;
use perifrac::scene;

use crate::support::{model, plan_of, try_run};

/// A quarter of a plate of 2 m with a hole of radius 0.1 m, pulled upwards.
const PLATE: &str = r#"title = "plate"
[geometry]
type = "mesh"
path = "tests/meshes/hole.msh"
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.25
[mechanics.boundary]
left = { roller = true }
bottom = { roller = true }
top = { traction = [0, 1] }
[time]
mode = "steady"
"#;

/// A cube whose lower half is another rock than the upper one.
const BLOCK: &str = r#"title = "block"
[geometry]
type = "mesh"
path = "tests/meshes/block.msh"
[materials.soft]
youngs_modulus = 1
poissons_ratio = 0
[materials.stiff]
youngs_modulus = 3
poissons_ratio = 0
[mechanics.boundary]
left = { roller = true }
bottom = { roller = true }
front = { roller = true }
back = { traction = [0, 0, 1] }
[time]
mode = "steady"
"#;

/// The same quarter, with fluid held at its outer sides and drained at the hole.
const DRAINED: &str = r#"title = "drained"
[geometry]
type = "mesh"
path = "tests/meshes/hole.msh"
[fluid]
viscosity = 1
[materials.rock]
permeability = 1
[flow]
regions = [{ region = { type = "set", name = "hole" }, pressure = 0 }]
[flow.boundary]
right = { pressure = 1 }
top = { pressure = 1 }
[time]
mode = "steady"
"#;

/// σ_yy and Kirsch's value for an endless plate at every point within three radii of the middle.
fn beside_the_hole(mesh: &str) -> Vec<([f64; 2], f64, f64)> {
    let plan = plan_of(PLATE, &[&format!("geometry.path=\"tests/meshes/{mesh}\"")]);
    let (_, state) = try_run(&plan).unwrap();
    let model = model::<2>(&plan);
    let solid = model.solid.unwrap();
    let slopes = solid.slopes(&state.displacement, &state.walls);
    let mut found = Vec::new();
    for (i, (slope, x)) in slopes.iter().zip(&model.cloud.position).enumerate() {
        let lame = solid.elastic.lame[i];
        let stress = lame.lambda * slope.trace() + 2.0 * lame.mu * slope[(1, 1)];
        let (radius, angle) = (x.norm(), x[0].atan2(x[1]));
        let share = (0.1 / radius).powi(2);
        // Kirsch (1898); angles are counted from the load.
        let [twice, four] = [2.0, 4.0].map(|times: f64| (times * angle).cos());
        let exact = 1.0 - share * (1.5 * twice + four) + 1.5 * share * share * four;
        if radius < 0.3 {
            found.push(([x[0], x[1]], stress, exact));
        }
    }
    found
}

fn largest(points: &[([f64; 2], f64, f64)]) -> f64 {
    points
        .iter()
        .map(|(_, stress, _)| *stress)
        .fold(0.0, f64::max)
}

/// Root mean square of the difference from Kirsch, in units of the load.
fn error(points: &[([f64; 2], f64, f64)]) -> f64 {
    let squares = points
        .iter()
        .map(|(_, stress, exact)| (stress - exact).powi(2));
    (squares.sum::<f64>() / points.len() as f64).sqrt()
}

/// A finite plate has 1 % more than Kirsch (Howland: 3.03 at a tenth of the width). Points are inside the edge, and families are
/// as wide as the cells, so that the largest stress is below 3 and grows towards it.
#[test]
fn stress_at_a_hole_of_a_mesh_approaches_kirsch() {
    let [coarse, fine] = ["hole-coarse.msh", "hole.msh"].map(beside_the_hole);
    let [low, high] = [&coarse, &fine].map(|points| largest(points));
    assert!(2.2 < low && low < high && high < 3.03, "{low} {high}");
    let [wide, near] = [&coarse, &fine].map(|points| error(points));
    assert!(near < 0.8 * wide && near < 0.05, "{wide} {near}");
}

/// By hand: a column of E = 1 under one of E = 3, half a metre each, under a unit traction becomes longer by 1/2 + 1/6.
#[test]
fn a_block_of_two_rocks_has_them_by_the_groups_of_its_mesh() {
    let plan = plan_of(BLOCK, &[]);
    let model = model::<3>(&plan);
    for (material, x) in model.material.iter().zip(&model.cloud.position) {
        assert_eq!(usize::from(*material), usize::from(x[2] > 0.5), "{x}");
    }
    let volume: f64 = model.cloud.volume.iter().sum();
    assert!((volume - 1.0).abs() < 1e-12);
    let (_, state) = try_run(&plan).unwrap();
    let up = |i: usize| state.displacement[3 * i + 2];
    let roof = (0..model.cloud.len())
        .max_by(|a, b| up(*a).total_cmp(&up(*b)))
        .unwrap();
    // From its place the point would go up by what lies above it less.
    let exact = 0.5 + (model.cloud.position[roof][2] - 0.5) / 3.0;
    assert!(
        (up(roof) / exact - 1.0).abs() < 0.05,
        "{} {exact}",
        up(roof)
    );
}

/// A tube in a square block, for a length of 1: S = 2π / ln(1.08 w / D) (Incropera et al., table of shape factors), of which
/// the quarter has a quarter. The layer of cells that is held stands a little outside the rim.
#[test]
fn a_group_of_edges_holds_the_pressure_at_a_hole() {
    let plan = plan_of(DRAINED, &[]);
    let model = model::<2>(&plan);
    let (summary, state) = try_run(&plan).unwrap();
    let held = |i: &usize| state.pressure[*i].abs() < 1e-12;
    let held: Vec<usize> = (0..model.cloud.len()).filter(held).collect();
    assert!(held.len() > 5 && held.iter().all(|i| model.cloud.position[*i].norm() < 0.11));
    let exact = 0.5 * std::f64::consts::PI / (1.08_f64 * 10.0).ln();
    let drained = -summary.balance.fixed;
    assert!((drained / exact - 1.0).abs() < 0.05, "{drained} {exact}");
}

#[test]
fn groups_that_do_not_fit_the_materials_or_regions_are_told_by_name() {
    let refused = |change: &[&str], parts: &[&str]| {
        let overrides: Vec<String> = change.iter().map(|own| (*own).to_owned()).collect();
        let loaded = scene::load_str("block", BLOCK, Path::new(""), &overrides);
        let message = match loaded {
            Err(errors) => errors.to_string(),
            Ok(loaded) => resolve(&loaded, "block").unwrap_err().to_string(),
        };
        for part in parts {
            assert!(message.contains(part), "{part} in {message}");
        }
    };
    let load = "mechanics.loads.push={side=\"back\", traction=[0, 0, 1], region={type=\"set\", name=\"roof\"}}";
    let free = "mechanics.boundary.back={free=true}";
    refused(&[free, load], &["no part of a side", "half-plane"]);
    let regions = "initial={regions=[{region={type=\"set\", name=\"rof\"}, stress={zz=1}}]}";
    refused(&[regions], &["no group `rof`", "did you mean `roof`"]);
    let roof = "materials.roof={youngs_modulus=1, poissons_ratio=0}";
    refused(&[roof], &["in the groups", "`roof`", "rename one"]);
    let lattice = "geometry={type=\"lattice\", size=[1, 1, 1], points=[4, 4, 4]}";
    refused(&[lattice, free, load], &["only a mesh has sets"]);
}
