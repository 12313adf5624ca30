//! The mechanical operator: oracle, symmetry, momentum, uniform stresses, waves.

use perifrac::geometry::{Matrix, Vector};
use perifrac::model::{Fields, Model, SolidModel};
use perifrac::plan::Plan;

use crate::support::{model, plan_of, run_text, try_run};

const LATTICE: &str = r#"geometry={type="lattice", size=[2, 1], points=[20, 10]}"#;
const BLOCKS: &str = r#"geometry={type="blocks", size=[2, 1], spacing=0.1, refine=[{levels=2, region={type="box", min=[0, 0], max=[0.6, 1]}}]}"#;
const TENSOR: &str = r#"geometry={type="graded", axes=[[{length=2, spacing=[0.03, 0.12]}], [{length=1, spacing=[0.1, 0.05]}]]}"#;
const JITTERED: &str =
    r#"geometry={type="lattice", size=[2, 1], points=[20, 10], jitter=0.2, seed=5}"#;
const SOLID: &str = r#"geometry={type="blocks", size=[1, 0.5, 0.5], spacing=0.125, refine=[{levels=1, region={type="box", min=[0, 0, 0], max=[0.3, 0.3, 0.5]}}]}"#;

/// A body in two halves of different stiffness, held on three sides and free on the fourth.
const HELD: &str = r#"
title = "held"
[geometry]
type = "lattice"
size = [2, 1]
points = [20, 10]
[materials.soft]
youngs_modulus = 1e8
poissons_ratio = 0.3
[materials.stiff]
youngs_modulus = 1e9
poissons_ratio = 0.2
region = { type = "half-plane", point = [1, 0], normal = [1, 0] }
[mechanics.boundary.left]
clamped = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.right]
displacement = [1e-3, 2e-3]
[time]
mode = "steady"
"#;

/// A body that nothing holds.
const LOOSE: &str = r#"
title = "loose"
[geometry]
type = "lattice"
size = [2, 1]
points = [20, 10]
[materials.rock]
youngs_modulus = 2.5
poissons_ratio = 0.25
density = 1
[mechanics]
mode = "dynamic"
[scheme]
name = "explicit"
[time]
end = 0.1
"#;

fn noise(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| ((i * 7919 + 13) % 1009) as f64 / 504.5 - 1.0)
        .collect()
}

fn solid<const D: usize>(plan: &Plan) -> std::sync::Arc<SolidModel<D>> {
    model(plan).solid.unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

fn assert_oracle<const D: usize>(name: &str, solid: &SolidModel<D>) {
    let displacement = noise(solid.unknowns());
    let oracle = solid.elastic.force(&displacement);
    let mut product = vec![0.0; displacement.len()];
    solid.subtract_internal(&displacement, &vec![0.0; solid.walls.len()], &mut product);
    let difference: Vec<f64> = product.iter().zip(&oracle).map(|(p, o)| p + o).collect();
    assert!(largest(&difference) < 1e-12 * largest(&oracle), "{name}");
    assert!(
        perifrac_solvers::is_symmetric(solid.matrix(), 1e-12),
        "{name}"
    );
    assert!(
        perifrac_solvers::dot(&oracle, &displacement) > 0.0,
        "{name}"
    );
}

#[test]
fn the_assembled_stiffness_is_the_matrix_free_force_and_symmetric() {
    for geometry in [LATTICE, BLOCKS, TENSOR, JITTERED] {
        assert_oracle(geometry, &solid::<2>(&plan_of(HELD, &[geometry])));
    }
    let space = [
        SOLID,
        "mechanics.boundary.right.displacement=[1e-3, 0, 2e-3]",
        r#"materials.stiff.region={type="half-plane", point=[0.5, 0, 0], normal=[1, 0, 0]}"#,
    ];
    assert_oracle("space", &solid::<3>(&plan_of(HELD, &space)));
}

/// Theory, section 3: the dual sum is the transpose of the family sum, so forces cancel.
#[test]
fn internal_forces_add_up_to_nothing_for_any_displacement_and_any_horizons() {
    for geometry in [LATTICE, BLOCKS, TENSOR, JITTERED] {
        let solid = solid::<2>(&plan_of(LOOSE, &[geometry]));
        let force = solid.elastic.force(&noise(solid.unknowns()));
        for axis in 0..2 {
            let sum: f64 = force.iter().skip(axis).step_by(2).sum();
            let scale: f64 = force.iter().skip(axis).step_by(2).map(|f| f.abs()).sum();
            assert!(
                sum.abs() < 1e-14 * scale,
                "{geometry}: {sum:.1e} of {scale:.1e}"
            );
        }
    }
}

/// Residual forces of the uniform stress in equilibrium with tractions on all sides of a loose body,
/// relative to the traction on a cell of the coarsest spacing.
fn unbalanced(geometry: &str, gradient: &str, stress: [f64; 3]) -> f64 {
    let [xx, yy, xy] = stress;
    let sides = [
        format!("mechanics.boundary.left={{traction=[{}, {}]}}", -xx, -xy),
        format!("mechanics.boundary.right={{traction=[{xx}, {xy}]}}"),
        format!("mechanics.boundary.bottom={{traction=[{}, {}]}}", -xy, -yy),
        format!("mechanics.boundary.top={{traction=[{xy}, {yy}]}}"),
        format!("mechanics.gradient={gradient}"),
    ];
    let overrides: Vec<&str> = std::iter::once(geometry)
        .chain(sides.iter().map(String::as_str))
        .collect();
    let model: Model<2> = model(&plan_of(LOOSE, &overrides));
    let solid = model.solid.as_ref().unwrap();
    let lame = solid.elastic.lame[0];
    // Strain of the stress: ε = (σ − λ tr ε I)/2μ.
    let trace = (xx + yy) / (2.0 * (lame.lambda + lame.mu));
    let normal = |s: f64| (s - lame.lambda * trace) / (2.0 * lame.mu);
    let shear = xy / (2.0 * lame.mu);
    let strain = Matrix::<2>::new(normal(xx), shear, shear, normal(yy));
    let displacement: Vec<f64> = model
        .cloud
        .position
        .iter()
        .flat_map(|x| (strain * x).data.0[0])
        .collect();
    let at = Fields {
        displacement: &displacement,
        ..Fields::default()
    };
    let (force, _) = model.unbalanced(0.0, &at);
    largest(&force) / 0.1
}

#[test]
fn uniform_normal_and_shear_stresses_balance_their_tractions_on_any_cloud() {
    for stress in [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.3, -0.7, 0.4],
    ] {
        assert!(unbalanced(LATTICE, "plain", stress) < 1e-13);
        for geometry in [BLOCKS, TENSOR, JITTERED] {
            let consistent = unbalanced(geometry, "divergence-consistent", stress);
            let plain = unbalanced(geometry, "plain", stress);
            println!("{stress:?} {geometry}: consistent {consistent:.1e}, plain {plain:.1e}");
            assert!(
                consistent < 1e-11,
                "{geometry} {stress:?}: {consistent:.1e}"
            );
        }
    }
    // Ghost forces of the plain gradient, which the correction removes.
    assert!(unbalanced(BLOCKS, "plain", [0.0, 0.0, 1.0]) > 1e-3);
}

/// Stretched bar: clamped end, rollers, traction (the drained patch test).
const BAR: &str = r#"
title = "bar"
[geometry]
type = "lattice"
size = [2, 1]
points = [20, 10]
[materials.rock]
youngs_modulus = 1e8
poissons_ratio = 0.3
[mechanics.boundary.left]
traction = [1e4, 0]
[mechanics.boundary.right]
clamped = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.top]
roller = true
[time]
mode = "steady"
"#;

/// Largest error of the displacement relative to its largest value; exact: u = (L − x) t/(λ+2μ).
fn bar_error(overrides: &[&str]) -> f64 {
    let plan = plan_of(BAR, overrides);
    let (_, state) = try_run(&plan).unwrap();
    let cloud = model::<2>(&plan).cloud;
    let modulus = 1e8 * 0.7 / (1.3 * 0.4);
    let exact = |x: &Vector<2>| Vector::<2>::new((2.0 - x[0]) * 1e4 / modulus, 0.0);
    let error: Vec<f64> = cloud
        .position
        .iter()
        .zip(state.displacement.chunks(2))
        .flat_map(|(x, u)| [u[0] - exact(x)[0], u[1]])
        .collect();
    largest(&error) / (2.0 * 1e4 / modulus)
}

#[test]
fn drained_patch_test_is_exact_with_the_consistent_gradient() {
    assert!(bar_error(&[LATTICE]) < 1e-10);
    for (geometry, least) in [(BLOCKS, 1e-4), (TENSOR, 1e-3), (JITTERED, 1e-4)] {
        let consistent = bar_error(&[geometry]);
        let plain = bar_error(&[geometry, "mechanics.gradient=plain"]);
        println!("{geometry}: consistent {consistent:.1e}, plain {plain:.1e}");
        assert!(consistent < 1e-8, "{geometry}: {consistent:.1e}");
        assert!(plain > least, "the plain gradient fails it: {plain:.1e}");
    }
}

#[test]
fn relaxation_finds_what_the_direct_solve_finds() {
    let direct = run_text(BAR, &[]).1;
    let relaxed = run_text(
        BAR,
        &[
            "time={end=1, step=1}",
            "scheme={name='explicit', solid='adr', adr_tolerance=1e-9}",
        ],
    );
    assert!(relaxed.0.counters.relaxation_iterations > 10);
    assert_eq!(relaxed.0.counters.solver.factorisations, 0);
    let error: Vec<f64> = direct
        .displacement
        .iter()
        .zip(&relaxed.1.displacement)
        .map(|(d, r)| d - r)
        .collect();
    assert!(largest(&error) < 1e-6 * largest(&direct.displacement));
}

#[test]
fn relaxation_gives_the_same_bits_for_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let scheme = "scheme={name='explicit', solid='adr'}";
            run_text(BAR, &[BLOCKS, scheme, "time={end=1, step=1}"]).1
        })
    };
    let one = run(1);
    assert!(largest(&one.displacement) > 0.0);
    for threads in [2, 3, 7] {
        assert_eq!(one, run(threads), "{threads} threads");
    }
}

/// Weight of a column on its base: u_y = −(ρ g/M)(H y − y²/2), exact at the points up to O(Δx²).
#[test]
fn a_column_under_its_own_weight_settles_as_the_parabola() {
    let text = r#"
title = "weight"
[geometry]
type = "lattice"
size = [0.5, 2]
points = [10, 40]
[materials.rock]
youngs_modulus = 1e8
poissons_ratio = 0.25
density = 2000
[gravity]
acceleration = [0, -10]
[mechanics.boundary.bottom]
clamped = true
[mechanics.boundary.left]
roller = true
[mechanics.boundary.right]
roller = true
[time]
mode = "steady"
"#;
    let plan = plan_of(text, &[]);
    let (summary, state) = try_run(&plan).unwrap();
    assert!(summary.counters.evaluations("weight") > 0);
    let modulus = 1e8 * 0.75 / (1.25 * 0.5);
    let settled = |y: f64| -2e4 / modulus * (2.0 * y - 0.5 * y * y);
    for (x, u) in model::<2>(&plan)
        .cloud
        .position
        .iter()
        .zip(state.displacement.chunks(2))
    {
        assert!(
            (u[1] - settled(x[1])).abs() < 2e-3 * settled(2.0).abs(),
            "{x}: {u:?}"
        );
    }
}

/// A stress step runs along a bar with the speed √((λ+2μ)/ρ).
#[test]
fn a_pressure_wave_travels_with_its_speed() {
    let text = r#"
title = "wave"
[geometry]
type = "lattice"
size = [10, 0.5]
points = [200, 10]
[materials.rock]
youngs_modulus = 2.5
poissons_ratio = 0.25
density = 3
[mechanics]
mode = "dynamic"
[mechanics.boundary.left]
traction = [1, 0]
[mechanics.boundary.right]
clamped = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.top]
roller = true
[scheme]
name = "explicit"
[time]
end = 6
[output]
"#;
    // λ + 2μ = 3, ρ = 3: the speed is 1, the velocity behind the front t/(ρ c) = 1/3.
    let front = |end: &str| {
        let plan = plan_of(text, &[end]);
        let (summary, state) = try_run(&plan).unwrap();
        assert!(summary.limit.unwrap().reason.contains("waves"));
        let position = model::<2>(&plan).cloud.position.clone();
        let lowest = || {
            let row = position.iter().zip(state.velocity.chunks(2));
            row.filter(|(x, _)| x[1] < 0.05)
        };
        let momentum: f64 = lowest().map(|(_, v)| 3.0 * 0.05 * v[0]).sum();
        assert!(
            (momentum - summary.t_end).abs() < 5e-3 * summary.t_end,
            "{momentum}"
        );
        lowest()
            .filter(|(_, v)| v[0] > 1.0 / 6.0)
            .map(|(x, _)| x[0])
            .fold(0.0, f64::max)
    };
    let (near, far) = (front("time.end=3"), front("time.end=8"));
    println!("front at {near} and {far}");
    assert!(
        ((far - near) / 5.0 - 1.0).abs() < 0.015,
        "speed {}",
        (far - near) / 5.0
    );
}

#[test]
fn what_a_mechanics_scene_does_not_name_is_not_there() {
    let (summary, state) = run_text(BAR, &[]);
    assert!(state.pressure.is_empty() && state.velocity.is_empty() && state.walls.is_empty());
    let field_bytes: Vec<_> = summary.counters.field_bytes.keys().collect();
    assert_eq!(field_bytes, ["displacement"]);
    let evaluations: Vec<_> = summary.counters.evaluations.keys().collect();
    assert_eq!(evaluations, ["traction"]);
    assert!(summary.pressure_range.is_none() && summary.coupling.is_none());
    assert_eq!(summary.counters.solver.factorisations, 0, "no flow matrix");
    assert_eq!(
        summary.counters.mechanics.as_ref().unwrap().factorisations,
        1
    );
    assert_eq!(summary.counters.newton_iterations, 1);
    assert!(
        !summary.counters.bytes.contains_key("matrix"),
        "{:?}",
        summary.counters.bytes
    );
    let (flow, _) = crate::support::run_case("two-layer", &["geometry.points=[16, 4]"]);
    assert!(
        flow.counters
            .bytes
            .keys()
            .all(|name| !name.contains("solid"))
    );
    assert_eq!(flow.counters.stiffness_refills, 0);
}
