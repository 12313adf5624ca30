//! Seconds against error of whole five-spot runs, printed as tables.
//!
//! Errors are those of the pressure against the exact lattice sum of wells, relative to its range.

mod support;

use anyhow::{Context, Result};
use perifrac::run::{FieldError, Summary};

use support::{median, plan, quick, summary};

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
            let runs = repeat(&overrides, if cells > 200 { 1 } else { 3 })?;
            let (total, solve) = (wall(&runs), phase(&runs, "solve"));
            let iterations = runs[0].counters.solver.iterations;
            let FieldError { l2, max, .. } = error(&runs[0])?;
            println!(
                "| {cells}² | {solver} | {total:.3} | {:.3} | {solve:.3} | {iterations} | {l2:.1e} | {max:.1e} |",
                total - solve
            );
        }
    }
    println!();
    Ok(())
}

/// End of the transient runs, s: a fifth of the diffusion time, where the field still moves.
const END: &str = "time.end=0.02";

fn transient() -> Result<()> {
    let cells = if quick() { 20 } else { 100 };
    println!("## Transient five-spot, {cells}² points, to 0.02 s\n");
    println!("| scheme | total s | steps | rejected | factorisations | rms error | max error |");
    println!("|---|---|---|---|---|---|---|");
    let schemes: [(&str, &[&str]); 5] = [
        ("explicit, 0.9 of the limit", &["scheme.name=explicit"]),
        ("implicit, tolerance 1e-2", &["time.tolerance=1e-2"]),
        ("implicit, tolerance 1e-3", &["time.tolerance=1e-3"]),
        ("implicit, tolerance 1e-4", &["time.tolerance=1e-4"]),
        ("implicit, tolerance 1e-5", &["time.tolerance=1e-5"]),
    ];
    for (name, own) in schemes {
        let mut overrides = vec![grid(cells), END.to_owned(), "output.times=[]".to_owned()];
        overrides.extend(own.iter().map(|text| (*text).to_owned()));
        let runs = repeat(&overrides, 3)?;
        let Summary {
            steps, rejected, ..
        } = runs[0];
        let FieldError { l2, max, .. } = error(&runs[0])?;
        println!(
            "| {name} | {:.3} | {steps} | {rejected} | {} | {l2:.1e} | {max:.1e} |",
            wall(&runs),
            runs[0].counters.solver.factorisations
        );
    }
    Ok(())
}

fn grid(cells: usize) -> String {
    format!("geometry.points=[{cells}, {cells}]")
}

fn choice(solver: &str) -> String {
    format!("solver.name=\"{solver}\"")
}

fn repeat(overrides: &[String], count: usize) -> Result<Vec<Summary>> {
    let overrides: Vec<&str> = overrides.iter().map(String::as_str).collect();
    let plan = plan("five-spot", &overrides)?;
    (0..count).map(|_| summary(&plan)).collect()
}

fn wall(runs: &[Summary]) -> f64 {
    median(&runs.iter().map(|run| run.wall_s).collect::<Vec<f64>>())
}

fn phase(runs: &[Summary], name: &str) -> f64 {
    median(
        &runs
            .iter()
            .map(|run| run.timers.seconds(name))
            .collect::<Vec<f64>>(),
    )
}

fn error(run: &Summary) -> Result<FieldError> {
    run.errors
        .get("pressure")
        .copied()
        .context("the five-spot has an exact solution")
}
