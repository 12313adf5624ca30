//! `perifrac run`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::output::OutputError;
use crate::run::{RunError, Summary, Writer, run as run_plan};

use super::common::{Planned, SceneArgs};
use super::exit::{Failure, print};
use super::progress::Console;

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder for the results [default: out/CASE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    /// Print nothing but errors and, with --json, the summary
    #[arg(long, short)]
    quiet: bool,
}

/// Runs a scene.
pub fn run(args: &Args) -> Result<(), Failure> {
    let planned = args.scene.plan()?;
    set_threads(args.threads)?;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from("out").join(&planned.plan.case));
    check_folder(&folder)?;
    let mut writer = Writer::create(&folder, &planned.loaded.resolved_toml())?;
    let interrupt = Arc::new(AtomicBool::new(false));
    let flag = interrupt.clone();
    // Without a handler the run is simply ended at once, as before.
    let _ = ctrlc::set_handler(move || interrupted(&flag));
    let mut console = Console::new(args.quiet);
    let result = match planned.plan.dimension {
        2 => run_plan::<2>(&planned.plan, Some(&mut writer), &mut console, &interrupt),
        _ => run_plan::<3>(&planned.plan, Some(&mut writer), &mut console, &interrupt),
    };
    console.finish();
    let (summary, _) = result.map_err(|error| failure(&planned, error))?;
    if args.json {
        let text = serde_json::to_string(&summary).unwrap_or_default();
        return print(&text);
    }
    if args.quiet {
        return Ok(());
    }
    print(&format!(
        "{}results in {}",
        describe(&summary),
        writer.folder().display()
    ))
}

/// The first interruption ends the run after its step; the second, should a step take long, at once.
fn interrupted(flag: &AtomicBool) {
    if flag.swap(true, Ordering::Relaxed) {
        std::process::exit(130);
    }
}

/// Refuses a folder whose place, or the way to it, is taken by a file.
fn check_folder(folder: &Path) -> Result<(), Failure> {
    match folder.ancestors().find(|path| path.is_file()) {
        None => Ok(()),
        Some(file) => Err(OutputError::Unsupported {
            path: file.to_owned(),
            what: "the place for results".to_owned(),
            found: "a file".to_owned(),
            allowed: "a folder; choose another one with --out",
        }
        .into()),
    }
}

fn failure(planned: &Planned, error: RunError) -> Failure {
    match error {
        RunError::Model(error) => planned.locate(&error),
        other => other.into(),
    }
}

fn set_threads(threads: Option<usize>) -> Result<(), Failure> {
    let Some(threads) = threads else {
        return Ok(());
    };
    if threads == 0 {
        return Err(Failure::Usage("--threads must be at least 1".to_owned()));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global();
    pool.map_err(|error| Failure::Usage(format!("--threads {threads}: {error}")))
}

fn describe(summary: &Summary) -> String {
    let mut text = format!(
        "{}: {} points, {} by {}, {} steps ({} rejected), {:.2} s\n",
        summary.case,
        summary.points,
        summary.scheme,
        summary.solver.as_deref().unwrap_or("no solver"),
        summary.steps,
        summary.rejected,
        summary.wall_s
    );
    for (field, error) in &summary.errors {
        text += &format!(
            "  error of {field}: {:.2e} (root mean square), {:.2e} (largest), relative to the range\n",
            error.l2, error.max
        );
    }
    text += &format!(
        "  mass balance: {:.1e} of the turnover\n",
        summary.balance.mass
    );
    text
}
