//! Flow through a layered block, run as a whole: a scene as text, and its final pressures.
//!
//! `cargo run --release --example flow`

use perifrac::prelude::*;

/// Water is pressed through two layers in a row; the second lets a quarter as much through.
const SCENE: &str = r#"
title = "Two layers in a row"
geometry = { type = "lattice", size = ["1 m", "0.5 m"], points = [40, 20] }
fluid.viscosity = "1 mPa s"
materials.coarse = { permeability = "4e-12 m^2", storage = "1e-9 1/Pa" }
[materials.fine]
permeability = "1e-12 m^2"
storage = "1e-9 1/Pa"
region = { type = "box", min = ["0.5 m", 0], max = ["1 m", "0.5 m"] }
[flow]
boundary.left.pressure = "1 bar"
boundary.right.pressure = 0
[time]
end = "10 s"
"#;

type Failure = Box<dyn std::error::Error>;

/// Flow out on the right at the end, and what Darcy's law says of layers in series, m³/s.
pub fn outflow() -> Result<[f64; 2], Failure> {
    let plan = Setup::text(SCENE).plan()?;
    let (summary, state) = run(&plan, None, &mut (), &Interrupt::default())?;
    let cloud = Model::<2>::of(&plan)?.cloud;
    println!("{} steps, to t = {} s", summary.steps, state.time);
    for (x, p) in cloud
        .position
        .iter()
        .zip(&state.pressure)
        .take(40)
        .step_by(8)
    {
        println!("x = {:.3} m: {:8.0} Pa", x[0], p);
    }
    let resistance = 1e-3 * (0.5 / 4e-12 + 0.5 / 1e-12) / 0.5;
    let right = summary.outflow.get("right").copied();
    Ok([right.unwrap_or(f64::NAN), 1e5 / resistance])
}

fn main() -> Result<(), Failure> {
    let [found, exact] = outflow()?;
    println!("outflow {found:.5e} m^3/s, Darcy's law {exact:.5e} m^3/s");
    Ok(())
}
