//! A notched plate is pulled apart; the program watches its crack and stops the run at a length.
//!
//! `cargo run --release --example crack_callback`

use perifrac::prelude::*;

/// Half a millimetre of notch in a plate of one, pulled at the top.
const SCENE: &str = r#"
title = "Notched plate"
geometry = { type = "lattice", size = ["1 mm", "1 mm"], points = [30, 30], thickness = "1 mm" }
horizon.length_scale_ratio = 0.5
materials.steel = { youngs_modulus = "210 GPa", poissons_ratio = 0.3, fracture_energy = "2700 J/m^2" }
[mechanics.boundary]
bottom.clamped = true
top.displacement = [0, { time = ["0 s", "6000 s"], value = [0, "6e-3 mm"] }]
[damage]
model = "paper"
length_scale = "0.1333333 mm"
tolerance = 1e-4
[cracks.notch]
points = [["0 mm", "0.5 mm"], ["0.5 mm", "0.5 mm"]]
[time]
end = "6000 s"
first_step = "300 s"
max_step = "300 s"
"#;

type Failure = Box<dyn std::error::Error>;

/// Prints how the crack grows, and stops the run when it is long enough.
struct Watch {
    /// Length so far, m.
    length: f64,
    /// Length at which it is enough, m.
    longest: f64,
    interrupt: Interrupt,
}

impl Observer for Watch {
    fn step(&mut self, progress: &Progress) {
        let length = progress.crack_length.unwrap_or(0.0);
        if length > self.length {
            let (time, grown) = (progress.time, length - self.length);
            println!(
                "t = {time:6.1} s: {:.3} mm, {:.3} mm more",
                1e3 * length,
                1e3 * grown
            );
        }
        self.length = length;
        if length >= self.longest {
            self.interrupt.raise();
        }
    }
}

/// Runs until the crack is `longest` (m) and gives its length, m, and the time, s.
pub fn grown_to(longest: f64) -> Result<(f64, f64), Failure> {
    let plan = Setup::text(SCENE).plan()?;
    let interrupt = Interrupt::default();
    let mut watch = Watch {
        length: 0.0,
        longest,
        interrupt: interrupt.clone(),
    };
    match run(&plan, None, &mut watch, &interrupt) {
        Err(RunError::Interrupted { time }) => Ok((watch.length, time)),
        Ok((summary, _)) => Ok((watch.length, summary.t_end)),
        Err(error) => Err(error.into()),
    }
}

fn main() -> Result<(), Failure> {
    let (length, time) = grown_to(0.7e-3)?;
    println!("stopped at t = {time:.1} s with {:.3} mm", 1e3 * length);
    Ok(())
}
