//! Cracks on lattices that are turned against them: what a crack takes and where it goes are no matter of the lattice,
//! and forces, pressures and openings are those of a sharp crack.

use std::fmt::Write as _;

use perifrac::output::History;
use perifrac::plan::Plan;
use perifrac::run::{Interrupt, Summary, Writer, run};
use perifrac::schemes::State;

use crate::support::{model, plan};

/// Edge of the square, m.
const EDGE: f64 = 1e-3;
/// G_c times the ligament times the thickness, J.
const LIGAMENT: f64 = 2700.0 * 0.5e-3 * 1e-3;

/// The part of a convex polygon in which `a·x ≤ b`.
fn clipped(polygon: &[[f64; 2]], a: [f64; 2], b: f64) -> Vec<[f64; 2]> {
    let off = |p: &[f64; 2]| a[0] * p[0] + a[1] * p[1] - b;
    let mut left = Vec::new();
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (from, to) = (off(p), off(q));
        if from <= 0.0 {
            left.push(*p);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            let share = from / (from - to);
            left.push([0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis])));
        }
    }
    left
}

/// Area and centroid of a polygon.
fn area(polygon: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let (mut twice, mut first) = (0.0, [0.0, 0.0]);
    for (i, p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let cross = p[0] * q[1] - q[0] * p[1];
        twice += cross;
        (0..2).for_each(|axis| first[axis] += cross * (p[axis] + q[axis]) / 3.0);
    }
    (0.5 * twice, first.map(|first| first / twice))
}

/// A lattice in a block, turned by `degrees` about the middle and moved by `shift` spacings along its own axes; what
/// sides cut off goes to the nearest cell.
fn turned(size: [f64; 2], spacing: f64, degrees: f64, shift: [f64; 2]) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let place = |x: f64, y: f64| {
        let (x, y) = (spacing * (x + shift[0]), spacing * (y + shift[1]));
        [
            0.5 * size[0] + cos * x - sin * y,
            0.5 * size[1] + sin * x + cos * y,
        ]
    };
    let (mut cells, mut rests) = (Vec::new(), Vec::new());
    let reach = (size[0].max(size[1]) / spacing) as i64;
    for (i, j) in (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |j| (i, j))) {
        let (x, y) = (i as f64, j as f64);
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        let mut polygon: Vec<[f64; 2]> = corners.map(|(a, b)| place(x + a, y + b)).to_vec();
        for (a, b) in [
            ([-1.0, 0.0], 0.0),
            ([0.0, -1.0], 0.0),
            ([1.0, 0.0], size[0]),
            ([0.0, 1.0], size[1]),
        ] {
            polygon = clipped(&polygon, a, b);
        }
        if polygon.len() > 2 {
            let (area, centroid) = area(&polygon);
            let all = spacing * spacing;
            match area {
                area if area > 0.35 * all => cells.push((area, centroid)),
                area if area > 1e-9 * all => rests.push((area, centroid)),
                _ => {}
            }
        }
    }
    for (area, at) in rests {
        let away = |cell: &(f64, [f64; 2])| (cell.1[0] - at[0]).hypot(cell.1[1] - at[1]);
        let nearest = cells.iter_mut().min_by(|a, b| away(a).total_cmp(&away(b)));
        let cell = nearest.unwrap();
        let both = cell.0 + area;
        cell.1 = [0, 1].map(|axis| (cell.0 * cell.1[axis] + area * at[axis]) / both);
        cell.0 = both;
    }
    let mut table = "x,y,volume\n".to_owned();
    for (area, [x, y]) in cells {
        writeln!(table, "{x},{y},{area}").unwrap();
    }
    table
}

/// Runs a case on such a square; gives force (kN) over displacement (m) along `axis`, too.
fn ran(
    case: &str,
    axis: &str,
    (across, degrees, shift): (usize, f64, [f64; 2]),
) -> (Plan, Summary, State, Vec<[f64; 2]>) {
    let folder = tempfile::tempdir().unwrap();
    let points = folder.path().join("points.csv");
    let spacing = EDGE / across as f64;
    std::fs::write(&points, turned([EDGE, EDGE], spacing, degrees, shift)).unwrap();
    let cloud = format!(
        "geometry={{type=\"file\", path={points:?}, thickness=\"1 mm\", \
         bounds={{min=[0, 0], max=[\"1 mm\", \"1 mm\"]}}}}"
    );
    let plan = plan(
        case,
        &[&cloud, "output.plots=false", "solver.name=faer-llt"],
    );
    let mut writer = Writer::create(&folder.path().join("out"), "").unwrap();
    let ran = run(&plan, Some(&mut writer), &mut (), &Interrupt::default());
    let (summary, state) = ran.unwrap_or_else(|error| panic!("{degrees}°: {error}"));
    let table = History::read(folder.path().join("out/history.csv")).unwrap();
    let motion = table.column(&format!("motion_top_{axis}_m")).unwrap();
    let force = table.column(&format!("force_top_{axis}_N")).unwrap();
    let curve = motion.iter().zip(force).map(|(u, f)| [*u, 1e-3 * f]);
    let curve = curve.collect();
    (plan, summary, state, curve)
}

/// Places that are broken beyond 0.9, m.
fn broken(plan: &Plan, state: &State) -> Vec<[f64; 2]> {
    let model = model::<2>(plan);
    let damage = model.response(&state.view()).unwrap().damage;
    let pairs = model.cloud.position.iter().zip(damage);
    pairs
        .filter_map(|(x, d)| (d > 0.9).then_some([x[0], x[1]]))
        .collect()
}

/// Straight line y = a + b x through places: b.
fn slope(places: &[[f64; 2]]) -> f64 {
    let mean = |axis: usize| places.iter().map(|p| p[axis]).sum::<f64>() / places.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let along: f64 = places.iter().map(|p| (p[0] - x).powi(2)).sum();
    places.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / along
}

#[test]
fn a_square_pulled_apart_takes_g_c_and_breaks_straight_on_lattices_of_any_direction() {
    let mut peaks = Vec::new();
    for (degrees, shift) in [
        (0.0, [0.5, 0.5]),
        (15.0, [0.5, 0.5]),
        (30.0, [0.5, 0.5]),
        (45.0, [0.5, 0.27]),
    ] {
        let (plan, summary, state, _) = ran("notched-tension", "y", (30, degrees, shift));
        let results = summary.results.unwrap();
        let taken = results.dissipated_energy / LIGAMENT;
        assert!((0.95..1.05).contains(&taken), "{degrees}°: {taken}");
        let mut places = broken(&plan, &state);
        places.retain(|p| p[0] > 0.52 * EDGE);
        let turn = slope(&places).atan().to_degrees();
        assert!(turn.abs() < 3.0, "{degrees}°: {turn}°");
        assert!(summary.steps < 40 && summary.counters.newton_iterations < 140);
        peaks.push(results.peak_force.unwrap());
    }
    let most = peaks.iter().copied().fold(0.0, f64::max);
    assert!(peaks.iter().all(|peak| *peak > 0.98 * most), "{peaks:?}");
}

/// Displacement of the top (µm), force (kN) and tip (mm) of a sharp crack that follows the largest hoop stress and
/// has G = G_c, from `benches/references/notched_square.py`. It begins to grow at 9.03 µm and 0.415 kN.
const SHARP: [(f64, f64, [f64; 2]); 5] = [
    (9.486, 0.3418, [0.5501, 0.3589]),
    (9.852, 0.3209, [0.5757, 0.3046]),
    (10.382, 0.3053, [0.6035, 0.2515]),
    (11.122, 0.2959, [0.6336, 0.1996]),
    (12.140, 0.2937, [0.6664, 0.1493]),
];

/// With 40² points the force lies 5 to 9 % below that of a sharp crack while it grows and the largest one 17 %, for want
/// of a process zone; with 100² it is within 2 % from 9.5 to 10.7 µm, and 12 %.
#[test]
fn a_sheared_square_follows_the_sharp_crack() {
    let (plan, summary, state, curve) = ran("notched-shear", "x", (40, 0.0, [0.5, 0.5]));
    let stiffness = summary.results.unwrap().initial_stiffness.unwrap();
    assert!((stiffness / 45.9 - 1.0).abs() < 0.03, "{stiffness}");
    for (u, force, _) in SHARP {
        let after = curve.iter().position(|[x, _]| *x > 1e-6 * u).unwrap();
        let ([x, f], [to, g]) = (curve[after - 1], curve[after]);
        let found = f + (g - f) * (1e-6 * u - x) / (to - x);
        assert!((found / force - 1.0).abs() < 0.09, "{u} µm: {found} kN");
    }
    let places = broken(&plan, &state);
    for (_, _, [x, y]) in SHARP {
        let near = places
            .iter()
            .filter(|p| (p[1] - 1e-3 * y).abs() < 0.026 * EDGE);
        let near: Vec<f64> = near.filter(|p| p[0] > 0.45 * EDGE).map(|p| p[0]).collect();
        let middle = near.iter().sum::<f64>() / near.len() as f64;
        assert!(
            (1e3 * middle - x).abs() < 0.06,
            "{middle} for {x} mm at {y} mm"
        );
    }
}

/// A lattice at 45° to the notch has a point at its tip that just parts in a strongly bent field: hourglass energy alone
/// broke it, it closed and was whole again, and no pass found a balance between.
#[test]
fn points_that_close_again_next_to_a_tip_leave_a_balance() {
    for (across, shift) in [(20, [0.3, 0.1]), (20, [0.5, 0.27])] {
        let (_, summary, _, _) = ran("notched-shear", "x", (across, 45.0, shift));
        let results = summary.results.unwrap();
        let taken = results.dissipated_energy / LIGAMENT;
        assert!((0.95..1.1).contains(&taken), "{shift:?}: {taken}");
        let peak = results.peak_force.unwrap();
        assert!((0.3..0.35).contains(&peak), "{shift:?}: {peak}");
        assert!(summary.balance.momentum.unwrap() < 1.1e-4);
        assert!(summary.steps < 50 && summary.counters.newton_iterations < 200);
    }
}

/// Half of the block of `kgd-toughness` with the crack through its inside, Δx = 10 cm, half length 10 Δx at the end; exact by
/// Garagash and Detournay as in the notes of the case. On the lattice that is not turned it is 3.2, −6.2 and −5.1 %.
#[test]
fn a_pumped_crack_is_as_long_and_wide_on_lattices_of_any_direction() {
    let (modulus, rate, time) = (20e9_f64 / 0.96, 1e-4, 2.5);
    let toughness = (100.0 * modulus).sqrt();
    let root = std::f64::consts::PI.sqrt();
    let length = (modulus * rate * time / (2.0 * root * toughness)).powf(2.0 / 3.0);
    let pressure = toughness / (root * length.sqrt());
    let opening = 4.0 * pressure * length / modulus;
    for (degrees, shift) in [(22.5, [0.5, 0.5]), (45.0, [0.5, 0.27])] {
        let folder = tempfile::tempdir().unwrap();
        let points = folder.path().join("points.csv");
        std::fs::write(&points, turned([2.0, 10.0], 0.1, degrees, shift)).unwrap();
        let cloud = format!(
            "geometry={{type=\"file\", path={points:?}, bounds={{min=[0, 0], max=[2, 10]}}}}"
        );
        let crack = "cracks.main={kind=\"damaged\", points=[[0, 5], [0.5, 5]], \
                     injection={rate=\"1e-4 m^2/s\", at=[0, 5]}}";
        let plan = plan("kgd-toughness", &[&cloud, crack, "output.plots=false"]);
        let mut writer = Writer::create(&folder.path().join("out"), "").unwrap();
        let ran = run(&plan, Some(&mut writer), &mut (), &Interrupt::default());
        let (summary, _) = ran.unwrap_or_else(|error| panic!("{degrees}°: {error}"));
        let table = History::read(folder.path().join("out/history.csv")).unwrap();
        let last = |name: &str| *table.column(name).unwrap().last().unwrap();
        let found = last("crack_pressure_main_Pa");
        let long = (rate * time * modulus / (2.0 * root * root * found)).sqrt();
        let off = [
            long / length - 1.0,
            found / pressure - 1.0,
            last("opening_main_m") / opening - 1.0,
        ];
        let right = off[0].abs() < 0.03 && off[1].abs() < 0.05 && off[2].abs() < 0.07;
        assert!(right, "{degrees}°: {off:?}");
        assert!(summary.balance.mass < 1e-7, "{}", summary.balance.mass);
        assert!(summary.steps < 60 && summary.counters.coupling_iterations < 500);
    }
}
