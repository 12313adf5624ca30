//! Moduli that vary within families: layers and inclusions against exact solutions.
//!
//! Displacements are prescribed, exactly, on a frame of six points around n × n free ones, and K u = 0 is solved for
//! these. Layers at any angle have continuous tractions and a continuous strain along them. The circular inclusion in
//! uniaxial tension is Kolosov's and Muskhelishvili's.

use nalgebra::Complex;
use perifrac::geometry::{Matrix, Vector};
use perifrac::model::SolidModel;
use perifrac_solvers::{dot, multiply, norm2};

use crate::support::{largest_difference, model, plan, plan_of, run_case, try_run};

const FRAME: usize = 6;
const RATIO: f64 = 0.25;
const RADIUS: f64 = 0.25;

/// Layers with tractions (1, 0.5) across and a strain of 0.7 along them, or a circle in tension along x.
enum Problem {
    Layers { angle: f64 },
    Circle,
}

/// Lamé's constants.
struct Lame {
    lambda: f64,
    mu: f64,
}

fn lame(modulus: f64) -> Lame {
    Lame {
        lambda: modulus * RATIO / ((1.0 + RATIO) * (1.0 - 2.0 * RATIO)),
        mu: 0.5 * modulus / (1.0 + RATIO),
    }
}

impl Problem {
    /// Modulus of what lies behind the interface, that of the rest being 1.
    fn scene(&self, n: usize, modulus: f64, extra: &str) -> String {
        let points = n + 2 * FRAME;
        let size = points as f64 / n as f64;
        let middle = 0.5 * size;
        let region = match self {
            Problem::Layers { angle } => {
                let normal = [angle.cos(), angle.sin()];
                format!(
                    r#"{{ type = "half-plane", point = [{middle}, {middle}], normal = {normal:?} }}"#
                )
            }
            Problem::Circle => {
                format!(r#"{{ type = "ball", centre = [{middle}, {middle}], radius = 0.25 }}"#)
            }
        };
        format!(
            r#"title = "frame"
geometry = {{ type = "lattice", size = [{size}, {size}], points = [{points}, {points}] }}
materials.rest = {{ youngs_modulus = 1, poissons_ratio = {RATIO} }}
materials.own = {{ youngs_modulus = {modulus}, poissons_ratio = {RATIO}, region = {region} }}
time.mode = "steady"
[mechanics]
{extra}
boundary.left.clamped = true
"#
        )
    }

    /// Exact displacement and stress at x, counted from the middle.
    fn exact(&self, x: &Vector<2>, modulus: f64) -> (Vector<2>, Matrix<2>) {
        match self {
            Problem::Layers { angle } => layers(x, *angle, modulus),
            Problem::Circle => circle(x, modulus),
        }
    }
}

fn layers(x: &Vector<2>, angle: f64, modulus: f64) -> (Vector<2>, Matrix<2>) {
    let (pull, shear, along) = (1.0, 0.5, 0.7);
    let normal = Vector::<2>::new(angle.cos(), angle.sin());
    let tangent = Vector::<2>::new(-angle.sin(), angle.cos());
    let (n, t) = (x.dot(&normal), x.dot(&tangent));
    let Lame { lambda, mu } = lame(if n < 0.0 { modulus } else { 1.0 });
    let stiff = lambda + 2.0 * mu;
    let displacement =
        normal * ((pull - lambda * along) / stiff * n) + tangent * (shear / mu * n + along * t);
    let flank = lambda / stiff * pull + (stiff - lambda * lambda / stiff) * along;
    let mixed = normal * tangent.transpose() * shear;
    let stress = normal * normal.transpose() * pull
        + mixed
        + mixed.transpose()
        + tangent * tangent.transpose() * flank;
    (displacement, stress)
}

/// Unit tension along y far away, as an all-round one and one of y against x; K, φ and ψ of Kolosov and Muskhelishvili.
fn circle(x: &Vector<2>, modulus: f64) -> (Vector<2>, Matrix<2>) {
    let (own, rest) = (lame(modulus), lame(1.0));
    let kappa = 3.0 - 4.0 * RATIO;
    let (bulk, bulk_rest) = (own.lambda + own.mu, rest.lambda + rest.mu);
    let (square, s) = (RADIUS * RADIUS, 0.5);
    let far = s / (2.0 * bulk_rest);
    let source = far * (bulk_rest - bulk) / (bulk + rest.mu) * square;
    let alpha = square * s * (own.mu - rest.mu) / (kappa * own.mu + rest.mu);
    let gamma = s + alpha / square;
    let z = Complex::new(x[0], x[1]);
    let inside = z.norm() < RADIUS;
    let (round, pure) = match inside {
        true => (
            z * (far + source / square),
            -(z * gamma).conj() / (2.0 * own.mu),
        ),
        false => {
            let psi = z * s + (alpha * square) / z.powu(3);
            let pure = kappa * alpha / z + z * (alpha / z.powu(2)).conj() - psi.conj();
            (z * (far + source / z.norm_sqr()), pure / (2.0 * rest.mu))
        }
    };
    let (sum, difference, radial, hoop) = match inside {
        true => {
            let all = 2.0 * bulk * (far + source / square);
            (0.0, Complex::from(2.0 * gamma), all, all)
        }
        false => {
            let psi = s - 3.0 * alpha * square / z.powu(4);
            let difference = (z.conj() * (2.0 * alpha) / z.powu(3) + psi) * 2.0;
            let (all, turn) = (2.0 * bulk_rest * far, 2.0 * rest.mu * source / z.norm_sqr());
            (
                (-4.0 * alpha / z.powu(2)).re,
                difference,
                all - turn,
                all + turn,
            )
        }
    };
    let twice = (z / z.norm()).powu(2);
    let (mean, half) = (0.5 * (radial + hoop + sum), 0.5 * (radial - hoop));
    let (xx, xy) = (
        half * twice.re - 0.5 * difference.re,
        half * twice.im + 0.5 * difference.im,
    );
    let displacement = round + pure;
    (
        Vector::<2>::new(displacement.re, displacement.im),
        Matrix::<2>::new(mean + xx, xy, xy, mean - xx),
    )
}

/// Largest error of the displacement over its largest deviation from the mean, and the error of the stress, norm
/// over norm, on the n × n points.
fn errors(problem: &Problem, n: usize, modulus: f64, extra: &str) -> [f64; 2] {
    let scene = problem.scene(n, modulus, extra);
    let solid = model::<2>(&plan_of(&scene, &[])).solid.unwrap();
    let cloud = &solid.elastic.around.cloud;
    let middle = Vector::repeat(0.5 * (n + 2 * FRAME) as f64 / n as f64);
    let exact: Vec<(Vector<2>, Matrix<2>)> = (cloud.position.iter())
        .map(|x| problem.exact(&(x - middle), modulus))
        .collect();
    let free: Vec<bool> = (cloud.position.iter())
        .map(|x| (x - middle).amax() < 0.5)
        .collect();
    assert_eq!(free.iter().filter(|free| **free).count(), n * n);
    let displacement = solve(&solid, &exact, &free);
    let mean: Vector<2> = exact.iter().map(|(u, _)| u).sum::<Vector<2>>() / exact.len() as f64;
    let scale = exact
        .iter()
        .map(|(u, _)| (u - mean).amax())
        .fold(0.0, f64::max);
    let (mut moved, mut missed, mut all) = (0.0_f64, 0.0, 0.0);
    for (point, (u, stress)) in exact.iter().enumerate().filter(|(point, _)| free[*point]) {
        let own = Vector::<2>::new(displacement[2 * point], displacement[2 * point + 1]);
        moved = moved.max((own - u).amax());
        let slope = (solid.elastic).gradient_of(point, |bond| {
            solid.elastic.difference(&displacement, point, bond)
        });
        let (found, _) = solid
            .elastic
            .stress_at(point, &((slope + slope.transpose()) * 0.5));
        missed += (found - stress).norm_squared();
        all += stress.norm_squared();
    }
    [moved / scale, (missed / all).sqrt()]
}

/// Displacements with the exact ones where points are not free, by conjugate gradients.
fn solve(solid: &SolidModel<2>, exact: &[(Vector<2>, Matrix<2>)], free: &[bool]) -> Vec<f64> {
    let mut u: Vec<f64> = exact.iter().flat_map(|(u, _)| [u[0], u[1]]).collect();
    u.iter_mut()
        .zip(free.iter().flat_map(|free| [free, free]))
        .for_each(|(u, free)| {
            if *free {
                *u = 0.0;
            }
        });
    let product = |x: &[f64]| {
        let mut y = vec![0.0; x.len()];
        multiply(solid.matrix(), x, &mut y);
        y.iter_mut()
            .zip(free.iter().flat_map(|free| [free, free]))
            .for_each(|(y, free)| {
                if !*free {
                    *y = 0.0;
                }
            });
        y
    };
    let mut r: Vec<f64> = product(&u).iter().map(|f| -f).collect();
    let mut p = r.clone();
    let (start, mut square) = (norm2(&r), dot(&r, &r));
    for _ in 0..40_000 {
        let q = product(&p);
        let step = square / dot(&p, &q);
        for (k, (p, q)) in p.iter().zip(&q).enumerate() {
            u[k] += step * p;
            r[k] -= step * q;
        }
        let next = dot(&r, &r);
        if next.sqrt() < 1e-14 * start {
            return u;
        }
        p.iter_mut()
            .zip(&r)
            .for_each(|(p, r)| *p = r + next / square * *p);
        square = next;
    }
    panic!("{} of {start}", square.sqrt());
}

const ALIGNED: Problem = Problem::Layers { angle: 0.0 };

/// Tractions across, shear and a strain along layers at once, to rounding and at every contrast.
#[test]
fn layers_along_the_rows_of_a_lattice_are_exact() {
    for modulus in [1e-4, 0.1, 10.0, 1e4] {
        for error in errors(&ALIGNED, 12, modulus, "") {
            // Of iterations: 3e-11 at 1e-4.
            assert!(error < 1e-9, "{modulus}: {error:.1e}");
        }
    }
    // With the moduli of points, a tenth of the stress is wrong.
    let [_, stress] = errors(&ALIGNED, 12, 0.1, "interfaces = \"pointwise\"");
    assert!(stress > 0.1, "{stress}");
}

/// Layers that cross the lattice at 30°: a prototype has 2.3e-3 and 1.7e-3 of the stress, the moduli of points
/// 8.1e-2 and 4.8e-2.
#[test]
fn layers_at_thirty_degrees_are_true_to_a_quarter_of_a_percent() {
    let problem = Problem::Layers {
        angle: std::f64::consts::FRAC_PI_6,
    };
    let [coarse, fine] = [20, 40].map(|n| errors(&problem, n, 10.0, ""));
    assert!(
        coarse[1] < 2.5e-3 && fine[1] < 1.8e-3,
        "{coarse:?} {fine:?}"
    );
    assert!(coarse[0] < 5e-4 && fine[0] < 3.2e-4, "{coarse:?} {fine:?}");
}

/// A circle ten times stiffer, a hundred times, and ten times softer than the plane. Prototypes have 0.057, 0.052
/// and 0.034 of the stress at 40 points across; the moduli of points 0.24, 0.53 and 0.062.
#[test]
fn a_circular_inclusion_converges_at_first_order() {
    for (modulus, displacement, stress) in [
        (10.0, 0.01, 0.058),
        (100.0, 0.004, 0.052),
        (0.1, 0.04, 0.036),
    ] {
        let [coarse, fine] = [20, 40].map(|n| errors(&Problem::Circle, n, modulus, ""));
        assert!(fine[0] < displacement, "{modulus}: {coarse:?} {fine:?}");
        assert!(fine[1] < stress, "{modulus}: {coarse:?} {fine:?}");
        assert!(fine[1] < 0.56 * coarse[1], "{modulus}: {coarse:?} {fine:?}");
    }
}

/// Stress along x of three layers in series in space, the middle one a cell thick and tilted out of the rows or not.
#[test]
fn layers_in_series_in_space_carry_one_stress() {
    let scene = r#"title = "series"
geometry = { type = "lattice", size = [1, 0.4, 0.4], points = [20, 8, 8] }
materials.rest = { youngs_modulus = 1, poissons_ratio = 0.2 }
materials.hard = { youngs_modulus = 50, poissons_ratio = 0.3, region = { type = "half-plane", point = [0.51, 0, 0], normal = [-1, 0, 0] } }
materials.soft = { youngs_modulus = 1e-3, poissons_ratio = 0.1, region = { type = "box", min = [0.3, 0, 0], max = [0.35, 1, 1] } }
time.mode = "steady"
[mechanics.boundary]
left = { traction = [1, 0, 0] }
right = { roller = true }
bottom = { roller = true }
top = { roller = true }
front = { roller = true }
back = { roller = true }
"#;
    let (_, state) = try_run(&plan_of(scene, &[])).unwrap();
    let solid = model::<3>(&plan_of(scene, &[])).solid.unwrap();
    let elastic = &solid.elastic;
    for point in 0..elastic.points() {
        let difference = |bond| elastic.difference(&state.displacement, point, bond);
        let slope = elastic.gradient_of(point, difference);
        let (stress, _) = elastic.stress_at(point, &((slope + slope.transpose()) * 0.5));
        assert!((stress[(0, 0)] + 1.0).abs() < 1e-9, "{point}: {stress}");
    }
    // Three rows beside the thin one, one on each side of the other interface.
    assert_eq!(elastic.layered(), 5 * 8 * 8);
}

/// Points whose material a file names have no regions: bonds are followed through cells, and layers found from there.
#[test]
fn layers_told_per_point_are_exact_as_those_of_regions() {
    let plan = plan(
        "layers-stiffness",
        &["materials.soft.region.point=[\"0.5 m\", \"0 m\"]"],
    );
    let (_, state) = try_run(&plan).unwrap();
    let cloud = &model::<2>(&plan).cloud;
    let rows: String = (cloud.position.iter().zip(&cloud.volume))
        .map(|(x, volume)| {
            let rock = if x[0] < 0.5 { "stiff" } else { "soft" };
            format!("{},{},{},{rock}\n", x[0], x[1], volume)
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    std::fs::write(&file, format!("x,y,volume,material\n{rows}")).unwrap();
    let text = perifrac::cases::find("layers-stiffness").unwrap().scene;
    let region =
        r#"region = { type = "half-plane", point = ["0.507 m", "0 m"], normal = [-1, 0] }"#;
    assert!(text.contains(region));
    let text = text.replace(region, "");
    let bounds = "bounds={min=[0, 0], max=[1, 0.25]}";
    let geometry = format!("geometry={{type=\"file\", path={file:?}, {bounds}}}");
    let (_, found) = try_run(&plan_of(&text, &[&geometry])).unwrap();
    let difference = largest_difference(&state.displacement, &found.displacement);
    assert!(difference < 1e-12, "{difference:e}");
}

/// The end of the bundled column: σ (1 + ν)(1 − 2ν)/(1 − ν) Σ h/E, whatever the interface is to the cells.
#[test]
fn a_column_of_two_stiffnesses_shortens_as_springs_in_series() {
    for (at, soft) in [
        (0.5, 2e8),
        (0.507, 2e8),
        (0.49999, 2e8),
        (0.507, 2e2),
        (0.507, 2e18),
    ] {
        let point = format!("materials.soft.region.point=[\"{at} m\", \"0 m\"]");
        let modulus = format!("materials.soft.youngs_modulus={soft}");
        let (_, state) = run_case("layers-stiffness", &[&point, &modulus]);
        let exact = 1e6 * 0.9 * (at / 20e9 + (1.0 - at) / soft);
        let largest = state
            .displacement
            .iter()
            .fold(0.0, |m: f64, u| m.max(u.abs()));
        // From the middle of the first cell to its side.
        let found = largest + 1e6 * 0.9 * 0.0125 / 20e9;
        // What rounding leaves grows with the contrast: 8.5e-6 at 1e8.
        let bound = 1e-9 + 1e-12 * 20e9 / soft;
        let error = (found / exact - 1.0).abs();
        assert!(error < bound, "{at}, {soft}: {found} {exact}");
    }
}
