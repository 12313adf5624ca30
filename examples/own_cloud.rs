//! Points and permeabilities of the program itself, as slices: steady flow through a rectangle whose rock
//! lets more through from left to right.
//!
//! `cargo run --release --example own_cloud`

use perifrac::prelude::*;

/// All but the points.
const SCENE: &str = r#"
title = "A cloud from the program"
[geometry]
bounds = { min = [0, 0], max = ["1 m", "0.5 m"] }
[fluid]
viscosity = "1 mPa s"
[materials.rock]
permeability = "1e-12 m^2"    # in place of which each point has its own
storage = "1e-9 1/Pa"
[flow]
boundary.left.pressure = "1 bar"
boundary.right.pressure = 0
[time]
mode = "steady"
"#;

type Failure = Box<dyn std::error::Error>;

/// Permeability at x (m), m²: e times as much from one end to the other.
fn permeability(x: f64) -> f64 {
    1e-12 * x.exp()
}

/// Cell centres, m, cell areas, m², and permeabilities, m², of columns that get wider to the right.
fn points(columns: usize, rows: usize) -> Result<PointTable, TableError> {
    let edge = |k: usize| {
        let share = k as f64 / columns as f64;
        share * (0.8 + 0.2 * share)
    };
    let height = 0.5 / rows as f64;
    let (mut position, mut area, mut own) = (Vec::new(), Vec::new(), Vec::new());
    for column in 0..columns {
        let (left, right) = (edge(column), edge(column + 1));
        let x = 0.5 * (left + right);
        for row in 0..rows {
            position.extend([x, (row as f64 + 0.5) * height]);
            area.push((right - left) * height);
            own.push(permeability(x));
        }
    }
    PointTable::new(2, &position, &area)?.with_permeability(&own)
}

/// Flow through the rectangle, m³/s, and largest error of the pressure over its range.
pub fn flow(columns: usize) -> Result<(f64, f64), Failure> {
    let plan = Setup::text(SCENE)
        .points(points(columns, columns / 2)?)
        .plan()?;
    let (summary, state) = run(&plan, None, &mut (), &Interrupt::default())?;
    let model = Model::<2>::of(&plan)?;
    let exact = |x: f64| 1e5 * ((-x).exp() - (-1_f64).exp()) / (1.0 - (-1_f64).exp());
    let pairs = model.cloud.position.iter().zip(&state.pressure);
    let worst = pairs.map(|(x, p)| (p - exact(x[0])).abs() / 1e5);
    let right = summary.outflow.get("right").copied();
    Ok((right.unwrap_or(f64::NAN), worst.fold(0.0, f64::max)))
}

/// Darcy's law through a permeability that grows like eˣ, m³/s.
pub fn exact_flow() -> f64 {
    1e5 * 1e-12 / 1e-3 * 0.5 / (1.0 - (-1_f64).exp())
}

fn main() -> Result<(), Failure> {
    for columns in [10, 20, 40] {
        let (found, worst) = flow(columns)?;
        println!(
            "{columns:3} columns: outflow {found:.5e} m^3/s, error {:+.2e}; pressure within {worst:.2e}",
            found / exact_flow() - 1.0
        );
    }
    println!("exact:       outflow {:.5e} m^3/s", exact_flow());
    Ok(())
}
