//! Seconds against error of Terzaghi's consolidation, every scheme beside the others.
//!
//! Each run is a whole one as the user would start it: scene, points, matrices, 60 s of physical time,
//! VTU, pictures and tables. Errors are the largest relative L2 norms of pressure and displacement at
//! 15, 30 and 60 s against the exact solution.

mod support;

use std::time::Instant;

use anyhow::Result;
use perifrac::run::{Interrupt, Summary, Writer, run};
use perifrac::{cases, plan, scene};

use support::{median, quick};

/// Name, overrides, and whether it runs on the coarse clouds only.
type Entry = (&'static str, &'static [&'static str], bool);

const ENTRIES: [Entry; 9] = [
    ("monolithic TR-BDF2, 3 s", &["time.step=3"], false),
    ("monolithic TR-BDF2, 5 s", &["time.step=5"], false),
    (
        "monolithic TR-BDF2, adaptive 1e-3",
        &["time.tolerance=1e-3"],
        false,
    ),
    (
        "monolithic backward Euler, 1 s",
        &["time.step=1", "time.integrator=backward-euler"],
        false,
    ),
    (
        "staggered TR-BDF2, 3 s",
        &["scheme.name=staggered", "time.step=3"],
        false,
    ),
    (
        "staggered TR-BDF2, 3 s, β exact",
        &[
            "scheme.name=staggered",
            "time.step=3",
            "scheme.relaxation=0.5",
        ],
        false,
    ),
    (
        "semi-implicit TR-BDF2, 3 s, ADR",
        &[
            "scheme.name=semi-implicit",
            "time.step=3",
            "scheme.adr_smoothing=0.1",
        ],
        true,
    ),
    ("explicit, ADR as printed", &["scheme.name=explicit"], true),
    (
        "explicit, ADR smoothed 0.1",
        &["scheme.name=explicit", "scheme.adr_smoothing=0.1"],
        true,
    ),
];

fn main() -> Result<()> {
    let spacings: &[f64] = if quick() { &[0.5] } else { &[0.5, 0.25, 0.05] };
    println!(
        "| Δx m | scheme | wall s | steps | factorisations | relaxation its | error p | error u |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for &spacing in spacings {
        for (name, own, coarse_only) in ENTRIES {
            if coarse_only && spacing < 0.2 {
                continue;
            }
            let times = if coarse_only || quick() { 1 } else { 3 };
            let runs: Result<Vec<(f64, Summary)>> =
                (0..times).map(|_| whole_run(spacing, own)).collect();
            let runs = runs?;
            let seconds = median(
                &runs
                    .iter()
                    .map(|(seconds, _)| *seconds)
                    .collect::<Vec<f64>>(),
            );
            print_row(spacing, name, seconds, &runs[0].1);
        }
    }
    Ok(())
}

fn whole_run(spacing: f64, own: &[&str]) -> Result<(f64, Summary)> {
    let folder = tempfile::tempdir()?;
    let start = Instant::now();
    let case = cases::find("terzaghi").ok_or_else(|| anyhow::anyhow!("bundled"))?;
    let mut overrides = vec![format!("geometry.spacing={spacing}")];
    overrides.extend(own.iter().map(|text| (*text).to_owned()));
    let loaded = scene::load_str("terzaghi", case.scene, folder.path(), &overrides)
        .map_err(|errors| anyhow::anyhow!("{errors}"))?;
    let plan = plan::resolve(&loaded, "terzaghi").map_err(|errors| anyhow::anyhow!("{errors}"))?;
    let mut writer = Writer::create(&folder.path().join("out"), &loaded.resolved_toml())?;
    let interrupt = Interrupt::default();
    let (summary, _) = run(&plan, Some(&mut writer), &mut (), &interrupt)?;
    Ok((start.elapsed().as_secs_f64(), summary))
}

fn print_row(spacing: f64, name: &str, seconds: f64, summary: &Summary) {
    let worst = |field: &str| {
        let at = summary.errors_over_time.iter();
        at.filter_map(|at| at.errors.get(field))
            .map(|e| e.l2_over_norm)
            .fold(0.0, f64::max)
    };
    let counters = &summary.counters;
    let mechanics = counters
        .mechanics
        .as_ref()
        .map_or(0, |own| own.factorisations);
    println!(
        "| {spacing} | {name} | {seconds:.2} | {} | {} | {} | {:.1e} | {:.1e} |",
        summary.steps,
        counters.solver.factorisations + mechanics,
        counters.relaxation_iterations,
        worst("pressure"),
        worst("displacement")
    );
}
