//! An effect of the program itself: rain that seeps into the rock near the top and swings with time.
//!
//! `cargo run --release --example own_effect`

use std::f64::consts::PI;

use perifrac::prelude::*;

const SCENE: &str = r#"
title = "Rain on a closed box"
geometry = { type = "lattice", size = ["2 m", "1 m"], points = [40, 20] }
fluid.viscosity = "1 mPa s"
materials.soil = { permeability = "1e-12 m^2", storage = "1e-7 1/Pa" }
[flow]
initial_pressure = "1 bar"
[time]
end = "100 s"
step = "50 ms"
"#;

/// Storage of all the soil, m²/Pa: 2 m² of it.
const STORAGE: f64 = 2.0 * 1e-7;
/// Rain in one period, m², and that period, s.
const RAIN: (f64, f64) = (2e-3, 50.0);

type Failure = Box<dyn std::error::Error>;

/// Rain that comes and goes: rate r(t) = R/T (1 − cos 2πt/T), spread over some points.
struct Rain {
    /// Points it falls on, and the share of each.
    share: Vec<(usize, f64)>,
}

impl Rain {
    /// Falls on the points that are higher than `height` (m), by their volumes.
    fn above(height: f64, points: &Points<'_>) -> Self {
        let high = |point: &usize| points.position[point * points.dimension + 1] > height;
        let wet: Vec<usize> = (0..points.volume.len()).filter(high).collect();
        let whole: f64 = wet.iter().map(|point| points.volume[*point]).sum();
        let share = |point| (point, points.volume[point] / whole);
        Rain {
            share: wet.into_iter().map(share).collect(),
        }
    }

    /// Rate of all the rain at `time` (s), m²/s.
    fn rate(time: f64) -> f64 {
        let (amount, period) = RAIN;
        amount / period * (1.0 - (2.0 * PI * time / period).cos())
    }
}

impl Effect for Rain {
    fn name(&self) -> &'static str {
        "rain"
    }

    fn add_rate(&self, time: f64, rate: &mut [f64]) {
        for (point, share) in &self.share {
            rate[*point] += share * Self::rate(time);
        }
    }

    fn injection(&self, time: f64) -> f64 {
        Self::rate(time)
    }

    fn is_constant(&self) -> bool {
        false
    }

    fn bytes(&self) -> usize {
        self.share.len() * size_of::<(usize, f64)>()
    }
}

/// Rise of the mean pressure, Pa, what the rain and the storage say it is, and fluid that got lost over all
/// that fell.
pub fn rise() -> Result<[f64; 3], Failure> {
    let rain = OwnEffect::on_flow(|points| Rain::above(0.9, points));
    let plan = Setup::text(SCENE).effect(rain).plan()?;
    let (summary, state) = run(&plan, None, &mut (), &Interrupt::default())?;
    println!(
        "the rain was asked {} times",
        summary.counters.evaluations("rain")
    );
    let mean = state.pressure.iter().sum::<f64>() / state.pressure.len() as f64;
    let periods = plan.time.end / RAIN.1;
    Ok([mean - 1e5, periods * RAIN.0 / STORAGE, summary.balance.mass])
}

fn main() -> Result<(), Failure> {
    let [found, exact, lost] = rise()?;
    println!("mean pressure rises by {found:.1} Pa, the rain makes {exact:.1} Pa");
    println!("fluid lost or made over all that fell: {lost:.1e}");
    Ok(())
}
