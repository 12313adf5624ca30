//! The figures that the README quotes, from one run, so that ratios compare like with like.

mod support;

use std::hint::black_box;

use anyhow::Result;
use perifrac::model::Model;
use perifrac::plan::Plan;
use perifrac::run::Summary;
use perifrac_solvers::multiply;

use support::{
    Marcher, OPERATORS, Triad, flow, median, model, plan, quick, refill, rough_pressure, seconds,
    seconds_each, step_bytes, summary,
};

fn main() -> Result<()> {
    println!("{} threads\n", rayon::current_num_threads());
    steady()?;
    let mut triad = Triad::new();
    let mut rows = Vec::new();
    for operator in &OPERATORS {
        rows.push((
            operator.name,
            loops(operator.dimension, &operator.plan(quick())?, &mut triad)?,
        ));
    }
    // The matrix of 200 × 200 points fits into large caches; this one does not.
    let cells = if quick() {
        "geometry.points=[20, 20]"
    } else {
        "geometry.points=[600, 600]"
    };
    let large = loops(2, &plan("five-spot", &[cells])?, &mut triad)?;
    rows.push(("2-D 600x600, correspondence, one hop", large));
    print_loops(&rows);
    Ok(())
}

/// Whole steady runs, from the text of the scene to the error norms.
fn steady() -> Result<()> {
    let cells = if quick() {
        "geometry.points=[20, 20]"
    } else {
        "geometry.points=[200, 200]"
    };
    let overrides = [cells, "time.mode=steady"];
    let mut runs: Vec<(f64, Summary)> = Vec::new();
    for _ in 0..if quick() { 1 } else { 5 } {
        let mut outcome = None;
        let total =
            seconds(|| outcome = Some(plan("five-spot", &overrides).and_then(|p| summary(&p))));
        if let Some(run) = outcome.transpose()? {
            runs.push((total, run));
        }
    }
    println!("## Five-spot, steady, {} points\n", runs[0].1.points);
    println!("| phase | median s |\n|---|---|");
    let middle = |part: &dyn Fn(&(f64, Summary)) -> f64| {
        median(&runs.iter().map(part).collect::<Vec<f64>>())
    };
    println!("| end to end | {:.3} |", middle(&|run| run.0));
    for (phase, _) in runs[0].1.timers.iter() {
        println!(
            "| {phase} | {:.3} |",
            middle(&|run| run.1.timers.seconds(&phase))
        );
    }
    println!(
        "| cloud to assembly | {:.3} |",
        middle(&|run| before_solve(&run.1))
    );
    print_bytes(&runs[0].1);
    Ok(())
}

/// Everything that makes the matrix, s.
fn before_solve(run: &Summary) -> f64 {
    run.timers
        .iter()
        .filter(|(phase, _)| *phase != "solve")
        .map(|(_, seconds)| seconds)
        .sum()
}

fn print_bytes(run: &Summary) {
    let each = |bytes: usize| bytes as f64 / run.points as f64;
    println!("\n| memory | bytes per point |\n|---|---|");
    for (holder, &bytes) in &run.counters.bytes {
        println!("| {holder} | {:.0} |", each(bytes));
    }
    println!("| model | {:.0} |", each(run.counters.bytes.values().sum()));
    println!(
        "| factor | {:.0} |",
        each(run.counters.solver.factor_bytes as usize)
    );
    let errors = run
        .errors
        .get("pressure")
        .map_or(f64::NAN, |error| error.max);
    println!("\nlargest error of the pressure relative to its range: {errors:.1e}\n");
}

/// Medians of one operator's loops; those of the triad are taken in turn with them.
struct Loops {
    points: usize,
    nonzeros: usize,
    matrix_bytes: usize,
    model_bytes: usize,
    refill: f64,
    product: f64,
    step: f64,
    step_bytes: u64,
    triad: f64,
    view: f64,
}

fn loops(dimension: usize, plan: &Plan, triad: &mut Triad) -> Result<Loops> {
    match dimension {
        2 => measure(model::<2>(plan)?, triad),
        _ => measure(model::<3>(plan)?, triad),
    }
}

const REPETITIONS: usize = 21;
/// Calls per sample of the short loops.
const CALLS: usize = 8;

fn measure<const D: usize>(mut model: Model<D>, triad: &mut Triad) -> Result<Loops> {
    let points = flow(&model)?.points();
    let pressure = rough_pressure(points);
    let mut result = vec![0.0; points];
    let mut marcher = Marcher::new(&model)?;
    let mut samples: [Vec<f64>; 5] = Default::default();
    for _ in 0..if quick() { 1 } else { REPETITIONS } {
        let refilled = seconds_each(2, || refill(&mut model));
        let flow = flow(&model)?;
        let view = seconds(|| {
            black_box(flow.matrix());
        });
        let matrix = flow.matrix();
        multiply(matrix, &pressure, &mut result);
        let product = seconds_each(CALLS, || {
            multiply(matrix, black_box(&pressure), &mut result)
        });
        let mut outcome = marcher.step(&mut model);
        let step = seconds_each(CALLS, || outcome = marcher.step(&mut model));
        outcome?;
        let triad = seconds_each(2, || triad.run());
        for (all, one) in samples
            .iter_mut()
            .zip([refilled, view, product, step, triad])
        {
            all.push(one);
        }
    }
    let [refill, view, product, step, triad] = samples.map(|all| median(&all));
    let flow = flow(&model)?;
    let step_bytes = step_bytes(flow);
    let (nonzeros, matrix_bytes) = (
        flow.pattern.nonzeros(),
        flow.pattern.bytes() + 8 * flow.conductance.len(),
    );
    let model_bytes = flow.bytes().iter().map(|(_, bytes)| bytes).sum();
    Ok(Loops {
        points,
        nonzeros,
        matrix_bytes,
        model_bytes,
        refill,
        product,
        step,
        step_bytes,
        triad,
        view,
    })
}

fn print_loops(rows: &[(&str, Loops)]) {
    println!("## Refill and product\n");
    println!(
        "| operator | nonzeros per point | refill ms | product ms | refill / product | view ms | model bytes per point |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, row) in rows {
        println!(
            "| {name} | {:.1} | {:.2} | {:.3} | {:.1} | {:.2} | {:.0} |",
            row.nonzeros as f64 / row.points as f64,
            1e3 * row.refill,
            1e3 * row.product,
            row.refill / row.product,
            1e3 * row.view,
            row.model_bytes as f64 / row.points as f64,
        );
    }
    println!("\n## Forward Euler against the triad\n");
    println!("| operator | matrix MB | step ms | step GB/s | triad GB/s | share |");
    println!("|---|---|---|---|---|---|");
    for (name, row) in rows {
        let step = row.step_bytes as f64 / row.step / 1e9;
        let triad = Triad::bytes() as f64 / row.triad / 1e9;
        println!(
            "| {name} | {:.1} | {:.3} | {step:.1} | {triad:.1} | {:.0} % |",
            row.matrix_bytes as f64 / 1e6,
            1e3 * row.step,
            100.0 * step / triad,
        );
    }
}
