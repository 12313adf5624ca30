//! Points read from a file: free surfaces of holes and corners, and clouds without any.

use std::path::Path;

use perifrac::geometry::Cloud;
use perifrac::model::{Model, ModelError};
use perifrac::plan::{Plan, resolve};
use perifrac::report::Timers;
use perifrac::run::{RunError, Summary};
use perifrac::scene;
use perifrac::schemes::State;

use crate::support::{model, plan_of, try_run};

/// A quarter of a plate, pulled to the right.
const PULLED: &str = r#"title = "pulled"
geometry = { type = "file", path = "points.csv", bounds = { min = [0, 0], max = [6, 6] } }
[materials.rock]
youngs_modulus = 1
poissons_ratio = 0.25
[mechanics.boundary]
left = { roller = true }
bottom = { roller = true }
right = { traction = [1, 0] }
[time]
mode = "steady"
"#;

/// The same plate with a flow along it; the far velocity is 1.
const FLOODED: &str = r#"title = "flooded"
geometry = { type = "file", path = "points.csv", bounds = { min = [0, 0], max = [6, 6] } }
[fluid]
viscosity = 1
[materials.rock]
permeability = 1
[flow.boundary]
left = { pressure = 6 }
right = { pressure = 0 }
[time]
mode = "steady"
"#;

type Points = Vec<[f64; 3]>;

fn in_hole(x: f64, y: f64) -> bool {
    x * x + y * y < 1.0
}

/// Cell centres of a lattice over 6 × 6, shifted by up to `jitter` of the spacing.
fn lattice(across: usize, jitter: f64) -> Points {
    let edge = 6.0 / across as f64;
    let mut seed = 7_u64;
    let mut shift = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        jitter * edge * ((seed >> 33) as f64 / f64::from(1_u32 << 30) - 1.0)
    };
    let place = |k: usize| (k as f64 + 0.5) * edge;
    (0..across * across)
        .map(|k| {
            [
                place(k % across) + shift(),
                place(k / across) + shift(),
                edge * edge,
            ]
        })
        .collect()
}

/// 2:1 blocks: spacing 0.075 in the lower left, 0.15 elsewhere.
fn blocks() -> Points {
    let fine = |k: usize| (k as f64 + 0.5) * 0.075;
    let coarse = |k: usize| (k as f64 + 0.5) * 0.15;
    let inner = (0..32 * 32).map(|k| [fine(k % 32), fine(k / 32), 0.075 * 0.075]);
    let outer = (0..40 * 40).filter(|k| k % 40 >= 16 || k / 40 >= 16);
    let outer = outer.map(|k| [coarse(k % 40), coarse(k / 40), 0.15 * 0.15]);
    inner.chain(outer).collect()
}

/// Without what lies in the hole around the lower left corner.
fn holed(mut points: Points) -> Points {
    points.retain(|[x, y, _]| !in_hole(*x, *y));
    points
}

fn read(text: &str, points: &Points, overrides: &[&str]) -> Plan {
    let folder = tempfile::tempdir().unwrap();
    let mut csv = "x,y,volume\n".to_owned();
    for [x, y, volume] in points {
        csv += &format!("{x:.15e},{y:.15e},{volume:.15e}\n");
    }
    std::fs::write(folder.path().join("points.csv"), csv).unwrap();
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    let loaded = scene::load_str("test", text, Path::new(folder.path()), &overrides)
        .unwrap_or_else(|errors| panic!("{errors}"));
    resolve(&loaded, "test").unwrap_or_else(|errors| panic!("{errors}"))
}

fn ran(plan: &Plan) -> (Summary, State) {
    try_run(plan).unwrap_or_else(|error| panic!("{error}"))
}

/// The point above the hole.
fn crown(cloud: &Cloud<2>) -> usize {
    let above = |i: &usize| !in_hole(cloud.position[*i][0], cloud.position[*i][1]);
    let distance = |i: usize| {
        let x = cloud.position[i];
        x[0].powi(2) + (x[1] - 1.05).powi(2)
    };
    (0..cloud.len())
        .filter(above)
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
        .unwrap()
}

/// σ_xx per point.
fn stresses(plan: &Plan) -> (Summary, Vec<f64>, Cloud<2>) {
    let (summary, state) = ran(plan);
    let model = model::<2>(plan);
    let solid = model.solid.unwrap();
    let stress = solid
        .slopes(&state.displacement, &state.walls)
        .into_iter()
        .enumerate();
    let stress = stress.map(|(i, slope)| {
        let lame = solid.elastic.lame[i];
        lame.lambda * slope.trace() + 2.0 * lame.mu * slope[(0, 0)]
    });
    (summary, stress.collect(), (*model.cloud).clone())
}

/// v_x per point.
fn velocities(plan: &Plan) -> (Summary, Vec<f64>, Cloud<2>) {
    let (summary, state) = ran(plan);
    let model = model::<2>(plan);
    let flow = model.flow.unwrap();
    let velocity = flow.velocity(&state.pressure, 0.0);
    (
        summary,
        velocity.iter().map(|v| v[0]).collect(),
        (*model.cloud).clone(),
    )
}

/// Kirsch has 3 at the edge and 2.61 half a cell of 0.1 beyond it; the plate is finite.
#[test]
fn stress_concentrates_above_a_hole_whatever_the_cloud() {
    for (name, points, range) in [
        ("lattice", holed(lattice(60, 0.0)), 2.70..2.80),
        ("jittered", holed(lattice(60, 0.2)), 2.3..3.1),
        ("2:1 blocks", holed(blocks()), 2.2..2.9),
    ] {
        let (summary, stress, cloud) = stresses(&read(PULLED, &points, &[]));
        let above = stress[crown(&cloud)];
        let quality = summary.consistency.unwrap();
        println!("{name}: {above} {quality:?}");
        assert!(range.contains(&above), "{name}: {above}");
        assert!(
            quality.surface_points > 50 && quality.plain_families == 0,
            "{quality:?}"
        );
    }
}

/// A cylinder in a uniform flow doubles the velocity beside it: 1.91 half a cell away. Cells that end in steps
/// along the hole have 1.70 on the flat one at its crown.
#[test]
fn flow_speeds_up_beside_a_hole_whatever_the_cloud() {
    for (name, points, range) in [
        ("lattice", holed(lattice(60, 0.0)), 1.65..1.92),
        ("jittered", holed(lattice(60, 0.2)), 1.6..1.95),
        ("2:1 blocks", holed(blocks()), 1.6..1.95),
    ] {
        let (_, velocity, cloud) = velocities(&read(FLOODED, &points, &[]));
        let above = velocity[crown(&cloud)];
        println!("{name}: {above}");
        assert!(range.contains(&above), "{name}: {above}");
    }
}

#[test]
fn graded_clouds_from_files_keep_their_patch_test() {
    for (name, points) in [("blocks", blocks()), ("jittered", lattice(40, 0.2))] {
        let (summary, stress, _) = stresses(&read(PULLED, &points, &[]));
        let worst = stress.iter().map(|s| (s - 1.0).abs()).fold(0.0, f64::max);
        let quality = summary.consistency.unwrap();
        assert!(worst < 1e-10, "{name}: {worst:.1e} {quality:?}");
        assert_eq!(quality.surface_points, 0);
        let (_, velocity, _) = velocities(&read(FLOODED, &points, &[]));
        let worst = velocity.iter().map(|v| (v - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-10, "{name}: {worst:.1e}");
    }
}

/// A jittered bar under uniform stress: the plain gradient bends it by per cents, and says so.
#[test]
fn plain_gradients_on_uneven_clouds_say_how_far_uniform_fields_are_off() {
    let told = |text: &str, jitter: f64, section: &str| {
        let plain = format!("{section}.gradient=plain");
        let plan = read(text, &lattice(24, jitter), &[&plain]);
        let (summary, _) = ran(&plan);
        let says = |warning: &&String| warning.starts_with("the plain gradient is not consistent");
        summary.warnings.iter().find(says).cloned()
    };
    for (text, section) in [(PULLED, "mechanics"), (FLOODED, "flow")] {
        assert_eq!(told(text, 0.0, section), None, "{section}");
        let warning = told(text, 0.3, section).unwrap();
        let remedy = format!("{section}.gradient = \"divergence-consistent\"");
        assert!(warning.contains(&remedy), "{warning}");
    }
}

/// The corner of an L carries no load beyond it, and its faces let nothing through.
#[test]
fn an_l_is_the_same_with_both_gradients_on_a_lattice() {
    let mut points = lattice(40, 0.0);
    points.retain(|[x, y, _]| *x < 3.0 || *y < 3.0);
    let gradient = |name: &str| {
        let plan = read(PULLED, &points, &[&format!("mechanics.gradient={name}")]);
        stresses(&plan).1
    };
    let (plain, consistent) = (gradient("plain"), gradient("divergence-consistent"));
    let gap = crate::support::largest_difference(&plain, &consistent);
    assert!(gap < 1e-9, "{gap:.1e}");
    let highest = plain.iter().copied().fold(0.0, f64::max);
    assert!(
        highest > 1.5,
        "stress concentrates at the corner: {highest}"
    );
}

fn refused(plan: &Plan) -> String {
    match Model::<2>::build(plan, &mut Timers::default()) {
        Err(error @ (ModelError::Points { .. } | ModelError::Effect(_))) => error.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => match try_run(plan) {
            Err(RunError::Model(error)) => error.to_string(),
            _ => panic!("not refused"),
        },
    }
}

#[test]
fn bounds_and_volumes_that_do_not_fit_the_points_are_refused() {
    let points = lattice(20, 0.0);
    let bounds = |corners: &str| read(PULLED, &points, &[&format!("geometry.bounds={corners}")]);
    let wide = refused(&bounds("{min=[0, 0], max=[6.6, 6]}"));
    assert!(
        wide.contains("no point reaches side right at 6.6"),
        "{wide}"
    );
    let low = refused(&bounds("{min=[0, -1], max=[6, 6]}"));
    assert!(low.contains("no point reaches side bottom"), "{low}");
    for (scale, said) in [
        (1e-4, "do not fit the distances"),
        (1e4, "do not fit the distances"),
        (0.5, "less, although the points leave no part of them out"),
        (2.0, "more than there is room for"),
    ] {
        let scaled: Points = points.iter().map(|[x, y, v]| [*x, *y, v * scale]).collect();
        let text = refused(&read(PULLED, &scaled, &[]));
        assert!(text.contains(said), "{scale}: {text}");
        let meant = read(PULLED, &scaled, &["geometry.any_volume=true"]);
        let built = Model::<2>::build(&meant, &mut Timers::default());
        assert!(!matches!(built, Err(ModelError::Points { .. })), "{scale}");
    }
}

#[test]
fn a_flux_acts_on_the_part_of_a_side_that_points_touch() {
    for jitter in [0.0, 0.2] {
        let mut points = lattice(40, jitter);
        let whole = lattice(40, 0.0);
        let kept = |k: &usize| whole[*k][0] < 3.0 || whole[*k][1] < 3.0;
        points = (0..points.len()).filter(kept).map(|k| points[k]).collect();
        let sides = "flow.boundary={left={pressure=0}, right={flux=1}}";
        // The cell beside the void ends half an edge of 0.15 from its point, which has moved.
        let cells = if jitter > 0.0 { 0.3 * 0.15 } else { 1e-9 };
        for (operator, slack) in [("path", cells), ("correspondence", 1e-9)] {
            let operator = format!("flow.operator={operator}");
            let (summary, _) = ran(&read(FLOODED, &points, &[sides, &operator]));
            let out = summary.outflow["left"];
            assert!(
                (out - 3.0).abs() < slack,
                "half of the side, {jitter}, {operator}: {out}"
            );
        }
    }
}

#[test]
fn a_load_beside_a_void_is_refused_where_its_area_would_be_wrong() {
    let mut points = lattice(40, 0.0);
    points.retain(|[x, y, _]| (x - 3.0).powi(2) + (y - 1.2).powi(2) > 0.81);
    let set =
        ["mechanics.boundary={bottom={traction=[0, -1]}, top={roller=true}, left={roller=true}}"];
    let text = refused(&read(PULLED, &points, &set));
    assert!(text.contains("of side bottom"), "{text}");
}

#[test]
fn probes_in_a_void_are_refused() {
    let points = holed(lattice(60, 0.0));
    let plan = read(PULLED, &points, &["output.probes.centre.at=[0.3, 0.3]"]);
    let built = Model::<2>::build(&plan, &mut Timers::default());
    assert!(matches!(built, Err(ModelError::ProbeOffPoints { .. })));
    let beside = read(PULLED, &points, &["output.probes.crown.at=[0, 1]"]);
    assert!(Model::<2>::build(&beside, &mut Timers::default()).is_ok());
}

/// Not a file, but of the same kind: a refinement, a material or a pressure that no point gets.
#[test]
fn regions_that_no_point_belongs_to_are_refused() {
    let base = FLOODED.replace(
        r#"{ type = "file", path = "points.csv", bounds = { min = [0, 0], max = [6, 6] } }"#,
        r#"{ type = "blocks", size = [6, 6], spacing = 0.5 }"#,
    );
    let build = |set: &[&str]| Model::<2>::build(&plan_of(&base, set), &mut Timers::default());
    let inside = r#"{type="box", min=[1, 1], max=[2, 2]}"#;
    let outside = r#"{type="box", min=[7, 1], max=[8, 2]}"#;
    let refine = |region: &str| format!("geometry.refine=[{{levels=1, region={region}}}]");
    assert!(build(&[&refine(inside)]).is_ok());
    assert!(matches!(
        build(&[&refine(outside)]),
        Err(ModelError::Generate(_))
    ));
    let held = |regions: &str| build(&[&format!("flow.regions=[{regions}]")]);
    let one = |pressure: f64| format!("{{region={inside}, pressure={pressure}}}");
    assert!(held(&one(1.0)).is_ok());
    let twice = held(&format!("{}, {}", one(1.0), one(2.0)));
    assert!(matches!(
        twice,
        Err(ModelError::CoveredPressureRegion { number: 1 })
    ));
    let covered = [
        format!("materials.vein={{permeability=2, region={inside}}}"),
        format!("materials.dike={{permeability=3, region={inside}}}"),
    ];
    let sets: Vec<&str> = covered.iter().map(String::as_str).collect();
    assert!(matches!(
        build(&sets),
        Err(ModelError::CoveredRegion { .. })
    ));
}
