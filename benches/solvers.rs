//! Every backend on every kind of linear system: set-up and solve seconds, iterations, residual, memory.
//!
//! Each cell of the table is a process of its own, so that its peak memory is its own and a backend
//! that fails or takes too long costs only its row. Without arguments all tables are made;
//! `-- table`, `-- growth`, `-- crack` and `-- largest` choose, and further words keep the cells whose
//! description contains all of them, as in `-- table elasticity amg`.

mod support;
#[path = "support/systems.rs"]
mod systems;

use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use perifrac_solvers::{LinearSolver, SolverCounters, SolverSpec, multiply, norm2};
use serde::{Deserialize, Serialize};

use support::{memory, quick};
use systems::{LinearSystem, Physics, Rock};

/// Relative residual that iterative backends are asked for.
const TOLERANCE: &str = "1e-10";
/// Seconds after which a cell is given up.
const PATIENCE: u64 = 180;
/// Memory of the largest problems, bytes.
const ROOM: u64 = 20 << 30;

const ROCKS: [Rock; 4] = [
    Rock::Intact,
    Rock::Crack(1e-6),
    Rock::Crack(1e-9),
    Rock::Contrast(1e8),
];

/// Backends for positive definite systems.
const DEFINITE: [&str; 15] = [
    "auto",
    "faer-llt",
    "faer-llt:ordering=amd",
    "faer-cg:preconditioner=amg",
    "faer-cg:preconditioner=f32",
    "faer-cg:preconditioner=ic0",
    "faer-cg:preconditioner=block-jacobi",
    "minres:preconditioner=amg",
    "bicgstab:preconditioner=amg",
    "gmres:preconditioner=amg",
    "petsc",
    "petsc:-ksp_type preonly -pc_type cholesky -pc_factor_mat_solver_type mumps",
    "petsc:-ksp_type cg -pc_type gamg",
    "petsc:-ksp_type cg -pc_type hypre",
    "petsc:-ksp_type cg -pc_type icc",
];

/// Backends for displacement and pressure in one matrix.
const MONOLITHIC: [&str; 10] = [
    "auto",
    "faer-ldlt",
    "fgmres:preconditioner=schur",
    "fgmres:preconditioner=schur,inner=4",
    "fgmres:preconditioner=fixed-stress,inner=4",
    "gmres:preconditioner=f32",
    "minres:preconditioner=block-jacobi",
    "petsc",
    "petsc:-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps",
    "petsc:-ksp_type fgmres -pc_type fieldsplit -pc_fieldsplit_type schur \
     -pc_fieldsplit_schur_fact_type upper -pc_fieldsplit_schur_precondition selfp \
     -fieldsplit_u_pc_type gamg -fieldsplit_u_ksp_type preonly \
     -fieldsplit_p_pc_type hypre -fieldsplit_p_ksp_type preonly",
];

/// One system with one backend.
#[derive(Debug, Clone)]
struct Cell {
    physics: Physics,
    rock: Rock,
    cells: usize,
    solver: String,
    steps: usize,
}

/// What a cell's process prints.
#[derive(Debug, Serialize, Deserialize)]
struct Figures {
    backend: String,
    unknowns: usize,
    build_s: f64,
    setup_s: f64,
    solve_s: f64,
    iterations: usize,
    residual: f64,
    scaled_residual: f64,
    factor_mb: f64,
    peak_mb: f64,
    /// Seconds of refresh and solve after each growth of the crack, and iterations of the solve.
    steps: Vec<(f64, f64, usize)>,
    rebuilds: u64,
}

fn main() -> Result<()> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    words.retain(|word| word != "--bench");
    if words.first().is_some_and(|word| word == "--cell") {
        return child(&words[1..]);
    }
    let table = ["table", "growth", "crack", "largest"]
        .into_iter()
        .find(|name| words.first().is_some_and(|word| word == name));
    let filter = if table.is_some() {
        &words[1..]
    } else {
        &words[..]
    };
    let wanted = |name: &str| table.is_none_or(|table| table == name);
    println!(
        "Residual asked for: {TOLERANCE}. {} threads.",
        rayon::current_num_threads()
    );
    if wanted("table") {
        every_backend(filter)?;
    }
    if wanted("growth") {
        growth(filter)?;
    }
    if wanted("crack") {
        growing_crack(filter)?;
    }
    if table == Some("largest") {
        largest(filter)?;
    }
    Ok(())
}

/// All backends on all systems.
fn every_backend(filter: &[String]) -> Result<()> {
    let small = quick();
    let size = |cells: usize| if small { 16 } else { cells };
    let systems = [
        (Physics::Flow, size(200)),
        (Physics::Flow, size(400)),
        (Physics::Elasticity, size(200)),
        (Physics::Monolithic, size(100)),
        (Physics::Monolithic, size(200)),
    ];
    for (physics, cells) in systems {
        let backends: &[&str] = match physics {
            Physics::Monolithic => &MONOLITHIC,
            _ => &DEFINITE,
        };
        let mut rows = Vec::new();
        for rock in ROCKS {
            // Thousands of iterations on the smaller system tell enough.
            let hopeless = |solver: &&&str| solver.starts_with("minres:preconditioner=block");
            for solver in backends.iter().filter(|own| cells <= 100 || !hopeless(own)) {
                rows.push(Cell::new(physics, rock, cells, solver));
            }
        }
        print_rows(&format!("{} {cells}²", physics.name()), rows, filter)?;
    }
    Ok(())
}

/// Iterations of the multilevel method as the cloud is refined.
fn growth(filter: &[String]) -> Result<()> {
    let sizes: &[usize] = if quick() {
        &[16]
    } else {
        &[100, 200, 400, 800]
    };
    let mut rows = Vec::new();
    for physics in [Physics::Bond, Physics::Flow, Physics::TwoHops] {
        for &cells in sizes {
            rows.push(Cell::new(
                physics,
                Rock::Intact,
                cells,
                "faer-cg:preconditioner=amg",
            ));
        }
    }
    for &cells in sizes.iter().filter(|&&cells| cells <= 400) {
        let solver = "faer-cg:preconditioner=amg";
        rows.push(Cell::new(Physics::Elasticity, Rock::Intact, cells, solver));
    }
    print_rows("multilevel, refined clouds", rows, filter)
}

/// A crack that grows by 20 points a step.
fn growing_crack(filter: &[String]) -> Result<()> {
    let cells = if quick() { 40 } else { 200 };
    println!("\n## elasticity {cells}², a crack that grows by 20 points a step\n");
    println!("| backend | first set-up s | refresh s | solve s | both s | iterations | rebuilds |");
    println!("|---|---|---|---|---|---|---|");
    for solver in [
        "faer-llt",
        "faer-cg:preconditioner=amg",
        "faer-cg:preconditioner=f32",
        "faer-cg:preconditioner=stale",
        "petsc:-ksp_type cg -pc_type gamg",
    ] {
        let mut cell = Cell::new(Physics::Elasticity, Rock::Crack(1e-6), cells, solver);
        cell.steps = 8;
        if !cell.matches(filter) {
            continue;
        }
        match cell.run() {
            Ok(figures) => {
                let steps = figures.steps.len() as f64;
                let mean = |part: &dyn Fn(&(f64, f64, usize)) -> f64| {
                    figures.steps.iter().map(part).sum::<f64>() / steps
                };
                let (refresh, solve) = (mean(&|s| s.0), mean(&|s| s.1));
                println!(
                    "| `{solver}` | {:.2} | {refresh:.2} | {solve:.2} | {:.2} | {:?} | {} |",
                    figures.setup_s,
                    refresh + solve,
                    figures.steps.iter().map(|s| s.2).collect::<Vec<_>>(),
                    figures.rebuilds
                );
            }
            Err(error) => println!("| `{solver}` | {error} | | | | | |"),
        }
    }
    Ok(())
}

/// Larger and larger problems until memory or patience runs out.
fn largest(filter: &[String]) -> Result<()> {
    let sizes = [250, 350, 500, 700, 1000, 1400, 2000, 2800];
    for physics in [Physics::Flow, Physics::Elasticity] {
        for solver in [
            "faer-llt",
            "faer-cg:preconditioner=f32",
            "faer-cg:preconditioner=amg",
            "petsc:-ksp_type cg -pc_type gamg",
            "petsc:-ksp_type preonly -pc_type cholesky -pc_factor_mat_solver_type mumps",
        ] {
            let title = format!("{}, {solver}", physics.name());
            let cells = sizes.map(|size| Cell::new(physics, Rock::Intact, size, solver));
            if !cells[0].matches(filter) {
                continue;
            }
            print_heading(&title);
            let mut last: Option<(f64, f64)> = None;
            for cell in cells {
                let found = cell.run();
                print_row(&cell, &found);
                let Ok(figures) = found else { break };
                let (points, total) = (
                    (cell.cells as f64).powi(2),
                    figures.setup_s + figures.solve_s,
                );
                if let Some((fewer, quicker)) = last {
                    let exponent = (total / quicker).ln() / (points / fewer).ln();
                    println!("| | growth exponent {exponent:.2} | | | | | | |");
                }
                last = Some((points, total));
            }
        }
    }
    Ok(())
}

fn print_heading(title: &str) {
    println!("\n## {title}\n");
    println!(
        "| rock | backend | set-up s | solve s | iterations | true residual | factor MB | peak MB |"
    );
    println!("|---|---|---|---|---|---|---|---|");
}

fn print_rows(title: &str, cells: Vec<Cell>, filter: &[String]) -> Result<()> {
    let cells: Vec<Cell> = cells
        .into_iter()
        .filter(|cell| cell.matches(filter))
        .collect();
    if cells.is_empty() {
        return Ok(());
    }
    print_heading(title);
    for cell in cells {
        print_row(&cell, &cell.run());
    }
    Ok(())
}

fn print_row(cell: &Cell, found: &Result<Figures>) {
    let what = format!(
        "{} {}², {}",
        cell.physics.name(),
        cell.cells,
        cell.rock.name()
    );
    match found {
        Ok(found) => println!(
            "| {what} | `{}` | {:.2} | {:.2} | {} | {:.1e} | {:.0} | {:.0} |",
            found.backend,
            found.setup_s,
            found.solve_s,
            found.iterations,
            found.residual,
            found.factor_mb,
            found.peak_mb
        ),
        Err(error) => {
            let reason = error.to_string().replace(['\n', '|'], " ");
            println!("| {what} | `{}` | {reason} | | | | | |", cell.solver);
        }
    }
}

impl Cell {
    fn new(physics: Physics, rock: Rock, cells: usize, solver: &str) -> Self {
        Cell {
            physics,
            rock,
            cells,
            solver: solver.to_owned(),
            steps: 0,
        }
    }

    fn matches(&self, words: &[String]) -> bool {
        let text = format!(
            "{} {} {} {}",
            self.physics.name(),
            self.rock.name(),
            self.cells,
            self.solver
        );
        words.iter().all(|word| text.contains(word.as_str()))
    }

    /// Runs the cell in a process of its own.
    fn run(&self) -> Result<Figures> {
        let mut process = Command::new(std::env::current_exe()?)
            .arg("--cell")
            .args([
                self.physics.name(),
                &self.rock.text(),
                &self.cells.to_string(),
            ])
            .args([&self.solver, &self.steps.to_string()])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let start = Instant::now();
        while process.try_wait()?.is_none() {
            let late = start.elapsed() > Duration::from_secs(PATIENCE);
            if late || resident(process.id()).is_some_and(|bytes| bytes > ROOM) {
                process.kill()?;
                process.wait()?;
                let room = ROOM >> 30;
                bail!(
                    "{}",
                    if late {
                        format!("more than {PATIENCE} s")
                    } else {
                        format!("more than {room} GiB")
                    }
                );
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let mut text = String::new();
        process
            .stdout
            .take()
            .context("output")?
            .read_to_string(&mut text)?;
        let line = text.lines().find(|line| line.starts_with('{'));
        if let Some(line) = line {
            return Ok(serde_json::from_str(line)?);
        }
        let mut error = String::new();
        process
            .stderr
            .take()
            .context("errors")?
            .read_to_string(&mut error)?;
        Err(anyhow!("{}", error.lines().next().unwrap_or("no message")))
    }
}

/// Bytes that a process holds now, where the system tells.
fn resident(process: u32) -> Option<u64> {
    memory(&format!("/proc/{process}/status"), "VmRSS:")
}

/// The process of one cell.
fn child(words: &[String]) -> Result<()> {
    let [physics, rock, cells, solver, steps] = words else {
        bail!("a cell has five words");
    };
    let (physics, rock) = (Physics::parse(physics)?, Rock::parse(rock)?);
    let steps = steps.parse()?;
    let build = Instant::now();
    let mut system = LinearSystem::new(physics, rock, cells.parse()?, steps > 0)?;
    let build_s = build.elapsed().as_secs_f64();
    let rhs = system.rhs();
    let mut solver = with_tolerance(solver).parse::<SolverSpec>()?.build()?;
    let start = Instant::now();
    solver.analyse(&system.problem())?;
    solver.refresh(system.matrix.view())?;
    let setup_s = start.elapsed().as_secs_f64();
    let mut x = vec![0.0; rhs.len()];
    let start = Instant::now();
    let report = solver.solve(system.matrix.view(), &rhs, &mut x)?;
    let solve_s = start.elapsed().as_secs_f64();
    let mut product = vec![0.0; rhs.len()];
    multiply(system.matrix.view(), &x, &mut product);
    let left: Vec<f64> = rhs.iter().zip(&product).map(|(b, p)| b - p).collect();
    let before = solver.counters().clone();
    let mut figures = Figures {
        backend: solver.name().to_owned(),
        unknowns: rhs.len(),
        build_s,
        setup_s,
        solve_s,
        iterations: report.iterations,
        residual: norm2(&left) / norm2(&rhs),
        scaled_residual: report.scaled_residual,
        factor_mb: before.factor_bytes as f64 / 1e6,
        peak_mb: 0.0,
        steps: Vec::new(),
        rebuilds: 0,
    };
    grow(&mut system, &mut *solver, &mut x, steps, &mut figures)?;
    if words[3].contains(':') || figures.backend != words[3] {
        figures.backend = format!("{}{}", words[3], chosen(&words[3], &figures.backend));
    }
    figures.rebuilds = work(solver.counters()) - work(&before);
    figures.peak_mb = memory("/proc/self/status", "VmHWM:").unwrap_or(0) as f64 / 1e6;
    println!("{}", serde_json::to_string(&figures)?);
    perifrac_solvers::petsc_finish();
    Ok(())
}

fn work(counters: &SolverCounters) -> u64 {
    counters.factorisations
}

/// What `auto` has chosen.
fn chosen(asked: &str, backend: &str) -> String {
    match asked {
        "auto" => format!(" ({backend})"),
        _ => String::new(),
    }
}

/// Adds the tolerance to backends that iterate.
fn with_tolerance(solver: &str) -> String {
    match solver.split_once(':') {
        Some(("petsc", flags)) if !flags.contains("preonly") => {
            format!("petsc:{flags} -ksp_rtol {TOLERANCE}")
        }
        Some((name, options)) if name.contains("cg") || name.contains("res") => {
            format!("{name}:{options},tolerance={TOLERANCE}")
        }
        _ => solver.to_owned(),
    }
}

/// Grows the crack step by step and solves after each.
fn grow(
    system: &mut LinearSystem,
    solver: &mut dyn LinearSolver,
    x: &mut [f64],
    steps: usize,
    figures: &mut Figures,
) -> Result<()> {
    for step in 0..steps {
        system.grow(step)?;
        // The load stays; the solution of the step before is the guess.
        let rhs = system.load();
        let start = Instant::now();
        solver.refresh(system.matrix.view())?;
        let refresh = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let report = solver.solve(system.matrix.view(), &rhs, x)?;
        figures
            .steps
            .push((refresh, start.elapsed().as_secs_f64(), report.iterations));
    }
    Ok(())
}
