//! Wells that stand anywhere between points, against the exact pressure of point sources in a sealed box.

use std::f64::consts::PI;

use crate::support::{model, plan_of, try_run};

/// Two wells in a sealed unit square, at rates that cancel.
const BOX: &str = r#"
title = "Two wells in a box"
geometry = { type = "lattice", size = ["1 m", "1 m"], points = [40, 40] }
fluid.viscosity = "1 Pa s"
materials.rock = { permeability = "1 m^2", storage = "1 1/Pa" }
flow = {}
time = { mode = "steady" }
[wells.one]
at = ["0.3137 m", "0.2871 m"]
rate = "1 m^2/s"
[wells.other]
at = ["0.7219 m", "0.6633 m"]
rate = "-1 m^2/s"
"#;

const WELLS: [[f64; 2]; 2] = [[0.3137, 0.2871], [0.7219, 0.6633]];

/// Pressure of a source of unit rate at (a, b) in the sealed unit square, less that of the same rate taken out
/// everywhere, but for a constant: a cosine series in one direction, summed in the other (Carslaw and Jaeger,
/// sec. 14.13), in which the terms decay with the distance.
fn green([x, y]: [f64; 2], [a, b]: [f64; 2]) -> f64 {
    if (y - b).abs() < (x - a).abs() {
        return green([y, x], [b, a]);
    }
    let (low, high) = (y.min(b), y.max(b));
    let series = (1..400).map(|m| {
        let k = PI * f64::from(m);
        let waves = [high - low, high + low, 2.0 - high - low, 2.0 - high + low];
        let decay: f64 = waves.iter().map(|gap| (-k * gap).exp()).sum();
        (k * x).cos() * (k * a).cos() * decay / (k * (1.0 - (-2.0 * k).exp()))
    });
    series.sum::<f64>() + 0.5 * (y * y + b * b) - high + 1.0 / 3.0
}

/// Largest error of the pressure further than 0.15 from both wells, over Q μ/2πk.
fn error(points: usize) -> f64 {
    let plan = plan_of(BOX, &[&format!("geometry.points=[{points}, {points}]")]);
    let (_, state) = try_run(&plan).unwrap();
    let model = model::<2>(&plan);
    let far = |x: [f64; 2]| {
        WELLS
            .iter()
            .all(|w| (x[0] - w[0]).hypot(x[1] - w[1]) > 0.15)
    };
    let places = model.cloud.position.iter().map(|x| [x[0], x[1]]);
    let pairs = places.zip(&state.pressure).filter(|(x, _)| far(*x));
    let off: Vec<f64> = pairs
        .map(|(x, p)| p - (green(x, WELLS[0]) - green(x, WELLS[1])))
        .collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let largest = off.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max);
    2.0 * PI * largest
}

/// Weights that are only normalised leave 6.3e-4 at 80 points across, those of a point source 2.0e-5 *(prototype)*. Here
/// they leave 6.7e-4, 3.2e-5 and 9.9e-6.
#[test]
fn wells_between_points_are_point_sources() {
    let errors = [20, 40, 80].map(error);
    assert!(errors[2] < 2e-5, "{errors:?}");
    assert!(
        errors[0] / errors[1] > 3.0 && errors[1] / errors[2] > 3.0,
        "{errors:?}"
    );
}
