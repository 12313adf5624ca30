//! Forces of explicit runs, gathered from bonds, against the assembled stiffness and against families one by one.

use perifrac::model::{Model, SolidModel};
use perifrac_solvers::multiply;

use crate::support::{model, plan, plan_of, run_case, run_text};

/// A body at rest that relaxes; its scheme decides whether a matrix is held.
const BODY: &str = r#"
title = "body"
[geometry]
type = "lattice"
size = [1.2, 0.9]
points = [24, 18]
[materials.rock]
youngs_modulus = 1e9
poissons_ratio = 0.3
[mechanics.boundary.left]
clamped = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.right]
traction = [1e5, 2e4]
[scheme]
name = "implicit"
[time]
end = 1
"#;

const RELAXED: &str = "scheme.name=explicit";
const CUBE: &[&str] = &[
    "geometry.size=[0.8, 0.7, 0.9]",
    "geometry.points=[8, 7, 9]",
    "mechanics.boundary.right.traction=[1e5, 2e4, 0]",
];
const STIFFER: &str = r#"materials.stiff={youngs_modulus=7e9, poissons_ratio=0.2, region={type="half-plane", point=[0.5, 0, 0], normal=[1, 0, 0]}}"#;
const STIFFER_2D: &str = r#"materials.stiff={youngs_modulus=7e9, poissons_ratio=0.2, region={type="half-plane", point=[0.5, 0], normal=[1, 0]}}"#;

fn noise(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| ((i * 7919 + 13) % 1009) as f64 / 504.5 - 1.0)
        .collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

fn solid<const D: usize>(overrides: &[&str]) -> std::sync::Arc<SolidModel<D>> {
    let model: Model<D> = model(&plan_of(BODY, overrides));
    model.solid.unwrap()
}

/// Families that are those of one stencil, and how far forces are from the matrix and from single families.
fn compare<const D: usize>(overrides: &[&str]) -> usize {
    let free = solid::<D>(&[overrides, &[RELAXED]].concat());
    let held = solid::<D>(overrides);
    assert_eq!(
        (free.stiffness.nnz(), free.refills),
        (0, 0),
        "{overrides:?}"
    );
    assert_eq!(held.refills, 1);
    let displacement = noise(free.unknowns());
    let [mut forces, mut product] = [(); 2].map(|()| vec![f64::NAN; free.unknowns()]);
    free.multiply(&displacement, &mut forces);
    multiply(held.matrix(), &displacement, &mut product);
    let single = free.elastic.force(&displacement);
    for (name, oracle) in [("matrix", &product), ("families", &single)] {
        let off: Vec<f64> = forces.iter().zip(oracle).map(|(f, o)| f - o).collect();
        let off = largest(&off) / largest(oracle);
        assert!(off < 2e-13, "{overrides:?}: {off:.1e} off the {name}");
    }
    let force = free.force.as_ref().unwrap();
    assert_eq!(force.evaluations(), 1);
    force.repeated()
}

#[test]
fn forces_on_lattices_come_from_one_stencil_whatever_the_sides() {
    for sides in [
        &[][..],
        &[
            "mechanics.boundary.left={roller=true}",
            "mechanics.boundary.top={clamped=true}",
        ],
        &[
            "mechanics.boundary.bottom={free=true}",
            "mechanics.boundary.left={free=true}",
            "mechanics.boundary.top={displacement=[0, 1e-3]}",
        ],
        &["mechanics.hourglass=0.3"],
        &["horizon.ratio=3.015"],
        // As thin as two points: images of images.
        &[
            "geometry.size=[1.2, 0.1]",
            "geometry.points=[24, 2]",
            "mechanics.boundary.top={roller=true}",
        ],
        // A second modulus, whose springs differ.
        &[STIFFER_2D, "mechanics.interfaces=pointwise"],
    ] {
        let overrides = [&["geometry.points=[24, 18]"][..], sides].concat();
        let points: usize = solid::<2>(&overrides).elastic.points();
        assert_eq!(compare::<2>(&overrides), points, "{sides:?}");
    }
}

#[test]
fn forces_in_space_come_from_one_stencil() {
    for more in [
        &["horizon.ratio=3.015"][..],
        &[
            "horizon.ratio=2.01",
            "mechanics.boundary.front={roller=true}",
            "mechanics.boundary.top={clamped=true}",
        ],
    ] {
        assert_eq!(compare::<3>(&[CUBE, more].concat()), 8 * 7 * 9);
    }
    // Layers deviate, and what sees them.
    let layered = compare::<3>(&[CUBE, &["horizon.ratio=2.01", STIFFER]].concat());
    assert!((1..8 * 7 * 9).contains(&layered), "{layered}");
}

#[test]
fn families_that_cracks_cut_deviate_and_no_others() {
    let crack = r#"cracks.cut={points=[[0.4, 0.45], [0.8, 0.45]]}"#;
    let repeated = compare::<2>(&[crack]);
    let solid = solid::<2>(&[crack, RELAXED]);
    let severed = solid.elastic.around.families.severed.as_ref().unwrap();
    let mut owners: Vec<u32> = severed.iter().map(|bond| bond.owner).collect();
    owners.sort_unstable();
    owners.dedup();
    assert!(!owners.is_empty());
    assert_eq!(repeated, solid.elastic.points() - owners.len());
}

#[test]
fn forces_off_lattices_come_from_single_families() {
    for geometry in [
        r#"geometry={type="graded", axes=[[{length=1.2, spacing=[0.03, 0.12]}], [{length=0.9, spacing=[0.1, 0.05]}]]}"#,
        r#"geometry={type="lattice", size=[1.2, 0.9], points=[24, 18], jitter=0.2, seed=5}"#,
        r#"geometry={type="blocks", size=[1.2, 0.9], spacing=0.1, refine=[{levels=1, region={type="box", min=[0, 0], max=[0.6, 0.9]}}]}"#,
    ] {
        assert_eq!(compare::<2>(&[geometry]), 0, "{geometry}");
    }
}

#[test]
fn forces_have_the_same_bits_for_any_number_of_threads() {
    let crack = r#"cracks.cut={points=[[0.4, 0.45], [0.8, 0.45]]}"#;
    let solid = solid::<2>(&[crack, RELAXED, "geometry.points=[96, 72]"]);
    let displacement = noise(solid.unknowns());
    let forces = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let mut forces = vec![0.0; displacement.len()];
        let evaluate = || solid.multiply(&displacement, &mut forces);
        pool.build().unwrap().install(evaluate);
        forces.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let one = forces(1);
    for threads in [2, 3, 7] {
        assert_eq!(forces(threads), one, "{threads}");
    }
}

/// Relaxation, single families and the matrix find the same equilibrium.
#[test]
fn relaxation_without_a_matrix_finds_the_equilibrium_of_the_matrix() {
    let (_, solved) = run_text(BODY, &[]);
    for damping in ["global", "local"] {
        let damping = format!("scheme.adr_damping={damping}");
        let (summary, relaxed) = run_text(BODY, &[RELAXED, &damping, "scheme.adr_tolerance=1e-9"]);
        assert_eq!(summary.nonzeros, 0);
        let pairs = solved.displacement.iter().zip(&relaxed.displacement);
        let off: Vec<f64> = pairs.map(|(s, r)| s - r).collect();
        let off = largest(&off) / largest(&solved.displacement);
        assert!(off < 1e-6, "{damping}: {off:.1e}");
    }
}

/// Of 2,000 smooth modes one is slow: critical damping for it takes a multiple of its period, that of rough points
/// many times as much.
#[test]
fn global_damping_takes_a_fraction_of_the_iterations_of_the_printed_one() {
    let iterations = |damping: &str| {
        let damping = format!("scheme.adr_damping={damping}");
        let (summary, _) = run_text(BODY, &[RELAXED, &damping]);
        summary.counters.relaxation_iterations
    };
    let [global, local] = ["global", "local"].map(iterations);
    assert!(global > 0 && 3 * global < local, "{global} {local}");
}

/// One factor for the start and none for steps; without a matrix none at all.
#[test]
fn explicit_runs_assemble_for_their_start_only() {
    let small = [
        "geometry.spacing=0.5",
        "scheme.name=explicit",
        "time.end=2 s",
        "output.times=[]",
        "audit.lag=1",
    ];
    let run = |start: &str| run_case("terzaghi", &[&small[..], &[start]].concat());
    let (assembled, with) = run("scheme.start=assembled");
    let (relaxed, without) = run("scheme.start=relaxed");
    let factored = assembled.counters.mechanics.as_ref().unwrap();
    assert_eq!(factored.factorisations, 1);
    assert!(relaxed.counters.mechanics.is_none());
    assert!(relaxed.counters.relaxation_iterations > assembled.counters.relaxation_iterations);
    let held: Model<2> = model(&plan("terzaghi", &small));
    assert_eq!(held.solid.unwrap().refills, 0);
    let pairs = with.pressure.iter().zip(&without.pressure);
    let off: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
    assert!(
        largest(&off) < 1e-3 * largest(&with.pressure),
        "{}",
        largest(&off)
    );
}
