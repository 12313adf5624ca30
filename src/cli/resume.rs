//! `perifrac resume`.

use std::path::{Path, PathBuf};

use crate::output::OutputError;
use crate::plan::resolve_for;
use crate::run::{Checkpoint, Writer};
use crate::scene::load_str;

use super::common::Planned;
use super::exit::{Failure, print, warn};
use super::processes::Processes;
use super::run::{How, carry_out};

/// Arguments of `resume`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the run
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Checkpoint to go on from [default: the newest in the folder]
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

/// Goes on with a run to the same results, to the last bit, that it would have had without the stop.
pub fn run(args: &Args) -> Result<(), Failure> {
    let processes = Processes::started();
    let checkpoint = match &args.from {
        Some(path) => Checkpoint::read(path)?,
        None => Checkpoint::newest(&args.folder)?,
    };
    let resolved = resolved(&args.folder)?;
    checkpoint.check_scene(&resolved)?;
    checkpoint.check_processes(processes.size)?;
    let planned = planned(&checkpoint, processes.size)?;
    if checkpoint.header.finished && args.folder.join("summary.json").is_file() {
        return told_finished(args, &checkpoint);
    }
    args.how.prepare(&planned)?;
    if checkpoint.is_of_another_build() && processes.leads() && !args.how.is_quiet() {
        warn(&format!(
            "{} was written by another build of this version: results may differ by rounding",
            checkpoint.path.display()
        ));
    }
    let team = processes.team()?;
    let writer = match processes.leads() {
        true => Writer::go_on(&args.folder, &resolved)?,
        false => Writer::follow(&args.folder, &resolved),
    };
    carry_out(&planned, &args.how, team.as_ref(), writer, Some(checkpoint))
}

/// The scene that a run in the folder had.
fn resolved(folder: &Path) -> Result<String, OutputError> {
    let path = folder.join("resolved.toml");
    std::fs::read_to_string(&path).map_err(|e| OutputError::from_io(&path, "read the scene", e))
}

/// The plan of the scene in a checkpoint.
fn planned(checkpoint: &Checkpoint, processes: usize) -> Result<Planned, Failure> {
    let name = checkpoint.path.display().to_string();
    let record = &checkpoint.record;
    let loaded = load_str(&name, &record.scene, &record.base, &[])?;
    let plan = resolve_for(&loaded, &checkpoint.header.case, processes)?;
    Ok(Planned { loaded, plan })
}

fn told_finished(args: &Args, checkpoint: &Checkpoint) -> Result<(), Failure> {
    if args.how.is_quiet() || !Processes::started().leads() {
        return Ok(());
    }
    print(&format!(
        "the run in {} reached its end, t = {:.6e} s, in {} steps: there is nothing left to do",
        args.folder.display(),
        checkpoint.header.time,
        checkpoint.header.steps
    ))
}
