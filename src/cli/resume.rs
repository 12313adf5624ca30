//! `perifrac resume`.

use std::path::{Path, PathBuf};

use crate::output::OutputError;
use crate::run::{Checkpoint, Summary};
use crate::scene::load_str;

use super::common::{Asked, Planned};
use super::exit::{Failure, print, warn};
use super::processes::Processes;
use super::run::{Desk, How};
use super::stages;

/// Arguments of `resume`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of the run
    #[arg(value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    folder: PathBuf,
    /// Checkpoint to go on from [default: the newest in the folder]
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    from: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

/// Goes on with a run to the same results, to the last bit, that it would have had without the stop.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if stages::is_staged(&args.folder) {
        if let Some(path) = &args.from {
            return Err(Failure::Usage(format!(
                "--from {}: {} has several stages; go on with the one that the checkpoint is of by `perifrac \
                 resume` of its own folder, and then with those after it without --from",
                path.display(),
                args.folder.display()
            )));
        }
        return stages::resume(&args.folder, &args.how);
    }
    let checkpoint = match &args.from {
        Some(path) => Checkpoint::read(path)?,
        None => Checkpoint::newest(&args.folder)?,
    };
    let resolved = resolved(&args.folder)?;
    checkpoint.check_scene(&resolved)?;
    checkpoint.check_processes(Processes::started().size)?;
    if checkpoint.header.finished && args.folder.join("summary.json").is_file() {
        return told_finished(args, &checkpoint);
    }
    let planned = planned(&checkpoint)?;
    let asked = Asked::One(Box::new(planned));
    args.how.prepare(&asked)?;
    let mut desk = Desk::new(&args.how)?;
    for (_, planned) in asked.all() {
        let summary = go_on(
            &mut desk,
            planned,
            &args.folder,
            &resolved,
            checkpoint.clone(),
        )?;
        desk.tell(&summary, &args.folder)?;
    }
    Ok(())
}

/// Goes on in a folder from a checkpoint of its own.
///
/// # Errors
/// [`Failure`] of the run.
pub(super) fn go_on(
    desk: &mut Desk<'_>,
    planned: &Planned,
    folder: &Path,
    resolved: &str,
    checkpoint: Checkpoint,
) -> Result<Summary, Failure> {
    if checkpoint.is_of_another_build() && Processes::started().leads() && !desk.is_quiet() {
        warn(&format!(
            "{} was written by another build of this version: results may differ by rounding",
            checkpoint.path.display()
        ));
    }
    let writer = desk.resumed_writer(folder, resolved)?;
    desk.carry_out(planned, writer, Some(checkpoint))
}

/// The scene that a run in the folder had.
pub(super) fn resolved(folder: &Path) -> Result<String, OutputError> {
    let path = folder.join("resolved.toml");
    std::fs::read_to_string(&path).map_err(|e| OutputError::from_io(&path, "read the scene", e))
}

/// The plan of the scene in a checkpoint.
pub(super) fn planned(checkpoint: &Checkpoint) -> Result<Planned, Failure> {
    let name = checkpoint.path.display().to_string();
    let record = &checkpoint.record;
    let loaded = load_str(&name, &record.scene, &record.base, &[])?;
    Ok(Planned::resolve(loaded, &checkpoint.header.case, false)?)
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
