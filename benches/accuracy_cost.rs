//! Seconds against error of whole five-spot runs, printed as tables.
//!
//! Errors are those of the pressure against the exact solution, relative to its range: the lattice
//! sum of wells in the steady state, less its decaying modes before.

mod support;

use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use perifrac::model::build_cloud;
use perifrac::plan::{PermeabilityPlan, Plan, exact_pressure};
use perifrac::reference::{ErrorNorms, ExactPressure, Exclusion};
use perifrac::run::{FieldError, Summary, run};
use perifrac::schemes::State;

use support::{median, plan, quick};

fn main() -> Result<()> {
    steady()?;
    transient()
}

/// Solver specifications compared in the steady state.
const SOLVERS: [&str; 2] = ["faer-llt", "faer-cg:preconditioner=jacobi"];

fn steady() -> Result<()> {
    println!("## Steady five-spot\n");
    println!(
        "| points | solver | total s | set-up s | solve s | iterations | rms error | max error |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let grids: &[usize] = if quick() { &[20] } else { &[50, 100, 200, 400] };
    for &cells in grids {
        for solver in SOLVERS {
            let overrides = [grid(cells), "time.mode=steady".to_owned(), choice(solver)];
            let runs = repeat(&named(&overrides)?, if cells > 200 { 1 } else { 3 })?;
            let (total, solve) = (wall(&runs), phase(&runs, "solve"));
            let iterations = runs[0].0.counters.solver.iterations;
            let FieldError { l2, max, .. } = error(&runs[0].0)?;
            println!(
                "| {cells}² | {solver} | {total:.3} | {:.3} | {solve:.3} | {iterations} | {l2:.1e} | {max:.1e} |",
                total - solve
            );
        }
    }
    println!();
    Ok(())
}

/// End of the transient runs, s: a tenth of the case's own, where the field still moves.
const END: &str = "time.end=0.02";

fn transient() -> Result<()> {
    let cells = if quick() { 20 } else { 100 };
    println!("## Transient five-spot, {cells}² points, to 0.02 s\n");
    println!("| scheme | total s | steps | rejected | factorisations | rms error | max error |");
    println!("|---|---|---|---|---|---|---|");
    let schemes: [(&str, &[&str]); 6] = [
        ("explicit, 0.9 of the limit", &["scheme.name=explicit"]),
        ("implicit, tolerance 1e-2", &["time.tolerance=1e-2"]),
        ("implicit, tolerance 1e-3", &["time.tolerance=1e-3"]),
        ("implicit, tolerance 1e-4", &["time.tolerance=1e-4"]),
        ("implicit, tolerance 1e-5", &["time.tolerance=1e-5"]),
        ("implicit, tolerance 1e-6", &["time.tolerance=1e-6"]),
    ];
    for (name, own) in schemes {
        let mut overrides = vec![grid(cells), END.to_owned(), "output.times=[]".to_owned()];
        overrides.extend(own.iter().map(|text| (*text).to_owned()));
        let plan = named(&overrides)?;
        let runs = repeat(&plan, 3)?;
        let (
            Summary {
                steps, rejected, ..
            },
            state,
        ) = &runs[0];
        let norms = transient_error(&plan, state)?;
        println!(
            "| {name} | {:.3} | {steps} | {rejected} | {} | {:.1e} | {:.1e} |",
            wall(&runs),
            runs[0].0.counters.solver.factorisations,
            norms.l2_relative,
            norms.max_relative,
        );
    }
    Ok(())
}

fn transient_error(plan: &Plan, state: &State) -> Result<ErrorNorms> {
    let exact = Transient::new(plan)?;
    let (cloud, _) = build_cloud::<2>(plan)?;
    let positions = cloud.position.iter().map(|x| x.as_slice());
    Ok(ErrorNorms::against(
        &exact,
        state.time,
        positions,
        &cloud.volume,
        &state.pressure,
    )?)
}

/// The five-spot on the way to its steady state, from a pressure of zero, on the unit square.
///
/// The square is sealed, so its modes are products of cosines; those with m + n odd are driven and
/// decay as exp(−κ (m² + n²) π² t / s). What is left of them is taken off the steady state.
struct Transient {
    steady: Box<dyn ExactPressure>,
    /// Rate that enters the square over the mobility, Pa.
    rate: f64,
    /// κ/s, m²/s.
    diffusivity: f64,
}

/// Modes per axis; the last one is below rounding from 1 ms on.
const MODES: usize = 60;

impl Transient {
    fn new(plan: &Plan) -> Result<Self> {
        let steady = exact_pressure(plan).map_err(anyhow::Error::msg)?;
        let material = plan
            .materials
            .first()
            .context("the five-spot has one material")?;
        let Some(PermeabilityPlan::Uniform(permeability)) = material.permeability else {
            anyhow::bail!("the five-spot has one permeability");
        };
        let mobility = permeability / plan.fluid.viscosity;
        let well = plan
            .wells
            .first()
            .context("the five-spot has an injector")?;
        Ok(Transient {
            steady: steady.context("the five-spot has an exact solution")?,
            rate: 0.25 * well.rate.at(0.0).abs() / mobility,
            diffusivity: mobility / material.storage,
        })
    }

    /// What the modes of one order along x still lack at (x, y).
    fn lacking(&self, m: usize, position: &[f64], time: f64) -> f64 {
        let driven = (0..MODES).filter(|n| (m + n) % 2 == 1);
        let share = |n: usize| {
            let square = PI * PI * (m * m + n * n) as f64;
            // The mean square of a cosine is a half, that of the constant one.
            let norm = if m == 0 || n == 0 { 0.5 } else { 0.25 };
            let size = 2.0 * self.rate / (norm * square);
            size * (-self.diffusivity * square * time).exp() * cosine(n, position[1])
        };
        driven.map(share).sum::<f64>() * cosine(m, position[0])
    }
}

fn cosine(order: usize, x: f64) -> f64 {
    (PI * order as f64 * x).cos()
}

impl ExactPressure for Transient {
    fn name(&self) -> &'static str {
        "five-spot, transient"
    }

    fn pressure(&self, position: &[f64], time: f64) -> f64 {
        let lacking: f64 = (0..MODES).map(|m| self.lacking(m, position, time)).sum();
        self.steady.pressure(position, time) - lacking
    }

    fn excluded(&self) -> Vec<Exclusion> {
        self.steady.excluded()
    }
}

fn grid(cells: usize) -> String {
    format!("geometry.points=[{cells}, {cells}]")
}

fn choice(solver: &str) -> String {
    format!("solver.name=\"{solver}\"")
}

fn named(overrides: &[String]) -> Result<Plan> {
    plan(
        "five-spot",
        &overrides.iter().map(String::as_str).collect::<Vec<&str>>(),
    )
}

fn repeat(plan: &Plan, count: usize) -> Result<Vec<(Summary, State)>> {
    let interrupt = AtomicBool::new(false);
    (0..count)
        .map(|_| Ok(run::<2>(plan, None, &mut (), &interrupt)?))
        .collect()
}

fn wall(runs: &[(Summary, State)]) -> f64 {
    median(&runs.iter().map(|(run, _)| run.wall_s).collect::<Vec<f64>>())
}

fn phase(runs: &[(Summary, State)], name: &str) -> f64 {
    median(
        &runs
            .iter()
            .map(|(run, _)| run.timers.seconds(name))
            .collect::<Vec<f64>>(),
    )
}

fn error(run: &Summary) -> Result<FieldError> {
    run.errors
        .get("pressure")
        .copied()
        .context("the five-spot has an exact solution")
}
