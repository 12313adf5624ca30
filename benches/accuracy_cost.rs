//! Seconds against error of whole five-spot runs, printed as tables.
//!
//! Errors are those of the pressure against the exact solution, relative to its range: the lattice
//! sum of wells in the steady state, less its decaying modes before.

mod support;

use anyhow::{Context, Result};
use perifrac::plan::Plan;
use perifrac::run::{FieldError, Interrupt, Summary, run};
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
        let summary = &runs[0].0;
        let error = error(summary)?;
        println!(
            "| {name} | {:.3} | {} | {} | {} | {:.1e} | {:.1e} |",
            wall(&runs),
            summary.steps,
            summary.rejected,
            summary.counters.solver.factorisations,
            error.l2,
            error.max,
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

fn named(overrides: &[String]) -> Result<Plan> {
    plan(
        "five-spot",
        &overrides.iter().map(String::as_str).collect::<Vec<&str>>(),
    )
}

fn repeat(plan: &Plan, count: usize) -> Result<Vec<(Summary, State)>> {
    let interrupt = Interrupt::default();
    (0..count)
        .map(|_| Ok(run(plan, None, &mut (), &interrupt)?))
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
