//! The folder of a run.

use std::path::{Path, PathBuf};
use std::time::Duration;

use perifrac::prelude::{Checkpoint, CheckpointRule, Settings, Writer};

use crate::errors::Fault;

/// Folder, checkpoint to go on from, seconds between two checkpoints, and whether there is one at every output.
pub(crate) type Files = (PathBuf, Option<PathBuf>, Option<f64>, bool);

/// Opens the folder of a run and the checkpoint that it goes on from.
pub(crate) fn open(
    files: Option<Files>,
    resolved: &str,
) -> Result<(Option<Writer>, Option<Checkpoint>, Settings), Fault> {
    let Some((folder, from, every, at_outputs)) = files else {
        return Ok((None, None, Settings::default()));
    };
    let every = every.map(Duration::try_from_secs_f64).transpose();
    let every =
        every.map_err(|error| Fault::new("UsageError", format!("checkpoint_every: {error}")))?;
    let settings = Settings {
        checkpoints: every.map(|every| CheckpointRule { every, at_outputs }),
        ..Settings::default()
    };
    let unfit = |error| Fault::new("CheckpointError", error);
    let checkpoint = from.map(|path| Checkpoint::open(&path)).transpose();
    let checkpoint = checkpoint.map_err(unfit)?;
    let writer = match &checkpoint {
        None => Writer::create(&folder, resolved),
        Some(checkpoint) => {
            let path = folder.join("resolved.toml");
            let before = std::fs::read_to_string(&path);
            let before = before.map_err(|error| unfit_file(&path, &error))?;
            checkpoint.check_scene(&before).map_err(unfit)?;
            checkpoint.check_processes(1).map_err(unfit)?;
            Writer::go_on(&folder, &before)
        }
    };
    let writer = writer.map_err(|error| Fault::new("OutputError", error))?;
    Ok((Some(writer), checkpoint, settings))
}

fn unfit_file(path: &Path, error: &std::io::Error) -> Fault {
    Fault::new("CheckpointError", format!("{}: {error}", path.display()))
}
