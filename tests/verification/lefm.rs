//! Cracks that turn, against linear elastic fracture mechanics: displacement discontinuities (Crouch 1976, Solution of
//! plane elasticity problems by the displacement discontinuity method), one constant per piece of crack, in an
//! unbounded plane; tips grow where the hoop stress is largest (Erdogan and Sih 1963) once it is that of K_Ic.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use perifrac::model::Model;
use perifrac::output::History;
use perifrac::plan::Plan;
use perifrac::run::{Interrupt, Summary, Writer, run};
use perifrac::schemes::State;

use crate::support::{model, plan};

const SHEAR: f64 = 20e9 / 2.4;
const POISSON: f64 = 0.2;
const MODULUS: f64 = 20e9 / 0.96;
const RATE: f64 = 1e-4;
/// Length of a piece, m.
const PIECE: f64 = 0.02;

/// K_Ic = √(G_c E′), Pa √m.
fn toughness() -> f64 {
    (100.0 * MODULUS).sqrt()
}

/// A straight piece of crack.
#[derive(Clone, Copy)]
struct Piece {
    middle: [f64; 2],
    angle: f64,
    half: f64,
}

/// Pieces between the corners of a polyline.
fn pieces(corners: &[[f64; 2]]) -> Vec<Piece> {
    let piece = |pair: &[[f64; 2]]| {
        let [from, to] = [pair[0], pair[1]];
        let along = [to[0] - from[0], to[1] - from[1]];
        Piece {
            middle: [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])],
            angle: along[1].atan2(along[0]),
            half: 0.5 * along[0].hypot(along[1]),
        }
    };
    corners.windows(2).map(piece).collect()
}

/// Shear and normal stress on `on` for a unit shift of the faces of `of` along itself and across.
fn influence(on: &Piece, of: &Piece) -> [[f64; 2]; 2] {
    let (sin, cos) = of.angle.sin_cos();
    let away = [on.middle[0] - of.middle[0], on.middle[1] - of.middle[1]];
    let (x, y) = (away[0] * cos + away[1] * sin, away[1] * cos - away[0] * sin);
    let (low, high) = (x - of.half, x + of.half);
    let (near, far) = (low * low + y * y, high * high + y * y);
    let k = 2.0 * SHEAR / (4.0 * PI * (1.0 - POISSON));
    let f_xy = k * (y / near - y / far);
    let f_yy = -k * (low / near - high / far);
    let f_xyy = k * ((low * low - y * y) / near.powi(2) - (high * high - y * y) / far.powi(2));
    let f_yyy = 2.0 * k * y * (low / near.powi(2) - high / far.powi(2));
    let stresses = [
        [2.0 * f_xy + y * f_xyy, -y * f_xyy, f_yy + y * f_yyy],
        [f_yy + y * f_yyy, f_yy - y * f_yyy, -y * f_xyy],
    ];
    let (sin, cos) = (on.angle - of.angle).sin_cos();
    stresses.map(|[xx, yy, xy]| {
        let shear = (yy - xx) * sin * cos + xy * (cos * cos - sin * sin);
        let normal = xx * sin * sin - 2.0 * xy * sin * cos + yy * cos * cos;
        [shear, normal]
    })
}

/// Shifts of the faces, two a piece, that add `traction` (shear and normal); pieces that are `shut` only slide.
fn shifts(all: &[Piece], traction: &[[f64; 2]], shut: &[bool]) -> DVector<f64> {
    let entry = |row: usize, column: usize| {
        let [i, j] = [row / 2, column / 2];
        match shut[i] && row % 2 == 1 {
            true => f64::from(row == column),
            false => influence(&all[i], &all[j])[column % 2][row % 2],
        }
    };
    let wanted = |row: usize, _| match shut[row / 2] && row % 2 == 1 {
        true => 0.0,
        false => traction[row / 2][row % 2],
    };
    let size = 2 * all.len();
    let matrix = DMatrix::from_fn(size, size, entry);
    let solved = matrix.lu().solve(&DMatrix::from_fn(size, 1, wanted));
    solved.expect("regular").column(0).into_owned()
}

/// Stress intensity of the largest hoop stress at the tip of a piece, and how far the crack turns there.
fn tip(piece: &Piece, shift: [f64; 2]) -> (f64, f64) {
    // A constant piece at a tip opens 1/0.806 of the true opening (Olson 1991).
    let factor = 0.806 * MODULUS * PI.sqrt() / (4.0 * (2.0 * piece.half).sqrt());
    let (one, two) = ((-shift[1] * factor).max(0.0), -shift[0] * factor);
    let turn = match two.abs() < 1e-9 * one {
        true => 0.0,
        false => 2.0 * ((one - (one * one + 8.0 * two * two).sqrt()) / (4.0 * two)).atan(),
    };
    let half = (0.5 * turn).cos();
    (half * (one * half * half - 1.5 * two * turn.sin()), turn)
}

/// The next corner beyond the last one, for a crack that turns by `turn`.
fn next(corners: &[[f64; 2]], turn: f64) -> [f64; 2] {
    let [before, last] = [corners[corners.len() - 2], corners[corners.len() - 1]];
    let angle = (last[1] - before[1]).atan2(last[0] - before[0]) + turn;
    [last[0] + PIECE * angle.cos(), last[1] + PIECE * angle.sin()]
}

/// Pressure (Pa), opening in the middle (m) and tip of each of two cracks `apart` from each other, from 0.5 m of half
/// length on, that fluid fills at `RATE` until `end`.
fn side_by_side(apart: f64, end: f64) -> (f64, f64, [f64; 2]) {
    let mut corners: Vec<[f64; 2]> = (0..=25)
        .map(|i| [PIECE * f64::from(i), 0.5 * apart])
        .collect();
    loop {
        let wing = pieces(&corners);
        let mirrored = |sx: f64, sy: f64| {
            wing.iter().map(move |piece| Piece {
                middle: [sx * piece.middle[0], sy * piece.middle[1]],
                angle: sx * sy * piece.angle,
                ..*piece
            })
        };
        let all: Vec<Piece> = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
            .into_iter()
            .flat_map(|(sx, sy)| mirrored(sx, sy))
            .collect();
        let shift = shifts(&all, &vec![[0.0, -1.0]; all.len()], &vec![false; all.len()]);
        let last = wing.len() - 1;
        let (intensity, turn) = tip(&wing[last], [shift[2 * last], shift[2 * last + 1]]);
        let pressure = toughness() / intensity;
        let opened = wing.iter().enumerate();
        let area: f64 = opened.map(|(i, p)| -shift[2 * i + 1] * 2.0 * p.half).sum();
        if 2.0 * area * pressure >= RATE * end {
            return (pressure, -shift[1] * pressure, corners[last + 1]);
        }
        corners.push(next(&corners, turn));
    }
}

/// Compression along y (Pa) and tip, from the middle, at which each wing of a closed crack at 45° is `length` long.
fn wings(half: f64, length: f64) -> (f64, [f64; 2]) {
    let along = |i: i32| half * f64::from(i) / 14.0 / 2.0_f64.sqrt();
    let mut corners: Vec<[f64; 2]> = (-14..=14).map(|i| [along(i), along(i)]).collect();
    let mut load: f64 = 0.0;
    for grown in 0.. {
        let all = pieces(&corners);
        let traction = |piece: &Piece| {
            let (sin, cos) = piece.angle.sin_cos();
            [sin * cos, cos * cos]
        };
        let traction: Vec<[f64; 2]> = all.iter().map(traction).collect();
        let mut shut = vec![false; all.len()];
        shut[grown..grown + 28].fill(true);
        let mut shift = shifts(&all, &traction, &shut);
        // Faces of wings must not overlap either.
        while let Some(piece) = (0..all.len()).find(|i| !shut[*i] && shift[2 * i + 1] > 0.0) {
            shut[piece] = true;
            shift = shifts(&all, &traction, &shut);
        }
        let last = all.len() - 1;
        let (intensity, turn) = tip(&all[last], [shift[2 * last], shift[2 * last + 1]]);
        load = load.max(toughness() / intensity);
        if PIECE * grown as f64 >= length {
            return (load, corners[last + 1]);
        }
        let end = next(&corners, turn);
        corners.insert(0, [-end[0], -end[1]]);
        corners.push(end);
    }
    unreachable!("wings grow for ever")
}

/// Runs a plan; gives the column of the history that is named as well.
fn ran(plan: &Plan, column: &str) -> (Summary, State, f64) {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(folder.path(), "").unwrap();
    let ran = run(plan, Some(&mut writer), &mut (), &Interrupt::default());
    let (summary, state) = ran.unwrap_or_else(|error| panic!("{error}"));
    let table = History::read(folder.path().join("history.csv")).unwrap();
    let value = *table.column(column).unwrap().last().unwrap();
    (summary, state, value)
}

/// Middle of what is broken at least by half among the points for which `counts`.
fn middle(plan: &Plan, state: &State, counts: impl Fn(&[f64]) -> bool) -> [f64; 2] {
    let model: Model<2> = model(plan);
    let model = model.at(state.coefficients.as_ref());
    let damage = model.response(&state.view()).unwrap().damage;
    let at = |i: usize| model.cloud.position[i];
    let broken = (0..damage.len()).filter(|i| damage[*i] > 0.5 && counts(at(*i).as_slice()));
    let broken: Vec<usize> = broken.collect();
    let mean = |axis: usize| broken.iter().map(|i| at(*i)[axis]).sum::<f64>() / broken.len() as f64;
    [mean(0), mean(1)]
}

/// Δx = 10 cm, half lengths of 5 to 11 Δx: pressure and opening of both, and where new crack has gone.
#[test]
fn two_cracks_side_by_side_stiffen_each_other_and_turn_away() {
    let plan = plan("two-cracks", &["geometry.spacing=10 cm"]);
    let (summary, state, pressure) = ran(&plan, "crack_pressure_main_Pa");
    let (exact, _, [x, y]) = side_by_side(0.8, 2.5);
    // One crack alone: K_Ic/√(πl), 14 % less.
    assert!((exact / 0.948e6 - 1.0).abs() < 0.02, "{exact}");
    assert!(
        (pressure / exact - 1.0).abs() < 0.05,
        "{pressure} for {exact}"
    );
    let tip = middle(&plan, &state, |at| at[0] > 0.8);
    let expected = 0.4 + (y - 0.4) * (tip[0] - 0.5) / (x - 0.5);
    assert!((tip[1] - expected).abs() < 0.05, "{tip:?} for {expected}");
    assert!(summary.balance.mass < 1e-6, "{}", summary.balance.mass);
}

/// Length of the wings at the last load, and where they are; without friction, Δx = 5 cm.
#[test]
fn wings_of_a_closed_crack_turn_into_the_direction_of_compression() {
    let plan = plan("wing-cracks", &["geometry.spacing=5 cm"]);
    let (summary, state, force) = ran(&plan, "force_top_y_N");
    let half = 0.4 / 2.0_f64.sqrt();
    let length = 0.5 * (summary.results.unwrap().crack_length - 2.0 * half);
    let (load, tip) = wings(half, length);
    let found = -force / 2.0;
    assert!((0.2..0.4).contains(&length), "{length}");
    assert!(
        (found / load - 1.0).abs() < 0.1,
        "{found} for {load} at {length}"
    );
    // The upper wing, beyond half of its height.
    let above = 1.2 + 0.5 * (tip[1] - 0.2);
    let wing = middle(&plan, &state, |at| at[1] > above);
    assert!((wing[0] - 1.0 - tip[0]).abs() < 0.1, "{wing:?} for {tip:?}");
}
