//! Whole runs under `mpirun`, with one process and with two in turn: seconds, and the peak memory of
//! the largest process.
//!
//! Words after `--` keep the rows whose description contains all of them, as in `-- steady hypre`.

mod support;

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use support::{median, memory, quick};

/// Runs of each number of processes.
const RUNS: usize = 5;

const SOLVERS: [&str; 4] = [
    "petsc",
    "petsc:-pc_type hypre",
    "petsc:-pc_type gamg -pc_gamg_threshold -1",
    "petsc:-ksp_type preonly -pc_type cholesky -pc_factor_mat_solver_type mumps",
];

/// Name, points per side, and overrides of `five-spot`.
type Scene = (&'static str, &'static str, &'static [&'static str]);

const SCENES: [Scene; 3] = [
    ("steady, one hop", "800", &["time.mode=steady"]),
    (
        "steady, two hops",
        "800",
        &["time.mode=steady", "flow.hourglass=0.5"],
    ),
    (
        "ten steps, one hop",
        "800",
        &["time.end=0.02", "time.step=0.002", "output.times=[]"],
    ),
];

fn main() -> Result<()> {
    let filter: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let version = Command::new("mpirun").arg("--version").output();
    if version.is_err() {
        println!("no mpirun: nothing is measured");
        return Ok(());
    }
    println!(
        "| five-spot | solver | 1 process s | 2 processes s | ratio (least, most) | 1 process MB | each of 2 MB | ratio |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, cells, overrides) in SCENES {
        for solver in SOLVERS {
            let title = format!("{name} {solver}");
            if filter.iter().all(|word| title.contains(word.as_str())) {
                let cells = if quick() { "30" } else { cells };
                row(name, cells, overrides, solver)?;
            }
        }
    }
    Ok(())
}

/// Runs one and two processes in turn, so that a load on the machine hits both alike.
fn row(name: &str, cells: &str, overrides: &[&str], solver: &str) -> Result<()> {
    let runs = if quick() { 1 } else { RUNS };
    let (mut seconds, mut bytes) = ([vec![], vec![]], [0, 0]);
    for _ in 0..runs {
        for processes in [1, 2] {
            let (wall, peak) = timed(processes, cells, overrides, solver)?;
            seconds[processes - 1].push(wall);
            bytes[processes - 1] = peak.max(bytes[processes - 1]);
        }
    }
    let pairs = seconds[0].iter().zip(&seconds[1]);
    let mut ratios: Vec<f64> = pairs.map(|(one, two)| one / two).collect();
    ratios.sort_by(f64::total_cmp);
    let [one, two] = bytes.map(|bytes| bytes as f64 / 1e6);
    println!(
        "| {name} {cells}² | `{solver}` | {:.1} | {:.1} | {:.2} ({:.2}, {:.2}) | {one:.0} | {two:.0} | {:.2} |",
        median(&seconds[0]),
        median(&seconds[1]),
        median(&ratios),
        ratios[0],
        ratios[ratios.len() - 1],
        two / one
    );
    Ok(())
}

/// Seconds of a whole run, and the most memory that one of its processes held.
fn timed(processes: usize, cells: &str, overrides: &[&str], solver: &str) -> Result<(f64, u64)> {
    let folder = std::env::temp_dir().join(format!("perifrac-processes-{}", std::process::id()));
    let points = format!("geometry.points=[{cells}, {cells}]");
    let mut command = Command::new("mpirun");
    command
        .args(["-n", &processes.to_string(), env!("CARGO_BIN_EXE_perifrac")])
        .args(["run", "five-spot", "--quiet", "--solver", solver, "--out"])
        .arg(&folder)
        .args(["--set", &points, "--set", "output.plots=false"])
        .args(["--set", "output.vtu=false"]);
    for text in overrides {
        command.args(["--set", text]);
    }
    let start = Instant::now();
    let mut run = command.stdout(Stdio::null()).spawn().context("mpirun")?;
    let peak = watch(&mut run)?;
    let wall = start.elapsed().as_secs_f64();
    ensure!(run.wait()?.success(), "the run failed: {command:?}");
    std::fs::remove_dir_all(&folder)?;
    Ok((wall, peak))
}

/// Waits for the end; the high-water mark of the largest process below `run`, bytes.
fn watch(run: &mut Child) -> Result<u64> {
    let mut peak = 0;
    while run.try_wait()?.is_none() {
        for process in children(run.id()) {
            let own = memory(&format!("/proc/{process}/status"), "VmHWM:");
            peak = peak.max(own.unwrap_or(0));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Ok(peak)
}

/// Processes that `parent` has started.
fn children(parent: u32) -> Vec<u32> {
    let path = format!("/proc/{parent}/task/{parent}/children");
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect()
}
