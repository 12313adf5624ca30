//! Terzaghi's consolidation, stepped by hand and compared with its exact solution.
//!
//! `cargo run --release --example terzaghi_by_hand`

use perifrac::prelude::*;
use perifrac::reference::{Terzaghi, TerzaghiParameters};

/// A column that is loaded and drained at its left end.
const SCENE: &str = r#"
title = "Terzaghi consolidation"
geometry = { type = "lattice", size = ["15 m", "1 m"], spacing = "0.1 m" }
fluid.viscosity = "1 mPa s"
[materials.rock]
youngs_modulus = "100 MPa"
poissons_ratio = 0
biot_coefficient = 0.5
permeability = "1e-12 m^2"
storage = "1.65e-10 1/Pa"
[flow]
boundary.left.pressure = 0
[mechanics.boundary]
left.traction = ["10 kPa", 0]
right.clamped = true
bottom.roller = true
top.roller = true
[coupling]
[time]
end = "60 s"
[scheme]
name = "monolithic"
"#;

type Failure = Box<dyn std::error::Error>;

/// Error of the pressure at times (s), relative to its exact range.
pub fn errors(steps: usize) -> Result<Vec<(f64, f64)>, Failure> {
    let plan = Setup::text(SCENE).plan()?;
    let model = Model::<2>::of(&plan)?;
    let mut scheme = build_scheme(&plan, &model)?;
    let mut state = State::initial(&model);
    scheme.start(&model, &mut state)?;
    let mut trial = state.clone();
    let mut found = Vec::new();
    for step in 1..=steps {
        // Short steps first: the pressure at the drained end falls like the root of time.
        let next = plan.time.end * (step as f64 / steps as f64).powi(3);
        scheme.step(&model, &state, next - state.time, &mut trial)?;
        std::mem::swap(&mut state, &mut trial);
        let norms = ErrorNorms::against(
            &exact()?,
            state.time,
            model.cloud.position.iter().map(|x| x.as_slice()),
            &model.cloud.volume,
            &state.pressure,
        )?;
        if step.is_multiple_of(steps / 5) {
            println!(
                "t = {:6.2} s: error {:.2e} of the range",
                state.time, norms.l2_relative
            );
            found.push((state.time, norms.l2_relative));
        }
    }
    Ok(found)
}

fn exact() -> Result<Terzaghi, Failure> {
    Ok(Terzaghi::new(TerzaghiParameters {
        axis: 0,
        drained_end: 0.0,
        sealed_end: 15.0,
        load: 1e4,
        oedometer_modulus: 1e8,
        biot_coefficient: 0.5,
        storage: 1.65e-10,
        mobility: 1e-9,
    })?)
}

fn main() -> Result<(), Failure> {
    errors(100)?;
    Ok(())
}
