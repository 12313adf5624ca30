//! Scenes in stages: one run after the other, each in a folder of its own, with one history.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::output::CheckpointError;
use crate::plan::StartPlan;
use crate::run::{Checkpoint, StagedFolder, Summary};
use crate::scene::load_str;

use super::common::{Asked, Planned};
use super::exit::{Failure, print, say};
use super::processes::Processes;
use super::resume::{go_on, resolved};
use super::run::{Desk, How};

/// The file that lists the stages of a folder.
const LIST: &str = "stages.json";

/// A stage as the list has it.
#[derive(Debug, Serialize, Deserialize)]
struct Listed {
    name: String,
    case: String,
    base: PathBuf,
    scene: String,
}

/// Whether a folder is that of a scene in stages.
pub(super) fn is_staged(folder: &Path) -> bool {
    folder.join(LIST).is_file()
}

/// The folder that `perifrac resume` is given to go on in that of a run: that of all stages, where the run is
/// one of them.
pub(super) fn way_on(folder: &Path) -> &Path {
    let whole = folder.parent().unwrap_or(Path::new(""));
    let stages = listed(whole).unwrap_or_default();
    let mut folders = stages.iter().enumerate();
    let is_stage =
        folders.any(|(number, stage)| folder.ends_with(stage_folder(number, &stage.name)));
    if is_stage { whole } else { folder }
}

/// Name of the folder of a stage.
fn stage_folder(number: usize, name: &str) -> String {
    format!("{:02}-{name}", number + 1)
}

/// The stages of a folder.
fn listed(folder: &Path) -> Result<Vec<Listed>, Failure> {
    let path = folder.join(LIST);
    let unreadable = |reason: String| Failure::Usage(format!("{}: {reason}", path.display()));
    let text = std::fs::read_to_string(&path).map_err(|error| unreadable(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))
}

/// Runs all stages into a folder.
///
/// # Errors
/// [`Failure`] of the first stage that fails.
pub(super) fn run(stages: Vec<(String, Planned)>, how: &How, folder: &Path) -> Result<(), Failure> {
    let desk = Desk::new(how)?;
    let leads = Processes::started().leads();
    let hold = match leads {
        true => Some(StagedFolder::create(folder, &list(&stages))?),
        false => None,
    };
    all(desk, stages, how, (folder, hold))
}

/// Goes on with the stages of a folder.
///
/// # Errors
/// As [`run`].
pub(super) fn resume(folder: &Path, how: &How) -> Result<(), Failure> {
    let mut stages = Vec::new();
    for (number, stage) in listed(folder)?.into_iter().enumerate() {
        let loaded = load_str(&stage.name, &stage.scene, &stage.base, &[])?;
        let planned = Planned::resolve(loaded, &stage.case, number > 0)?;
        stages.push((stage.name, planned));
    }
    let asked = Asked::Stages(stages);
    how.prepare(&asked)?;
    let Asked::Stages(stages) = asked else {
        return Ok(());
    };
    let desk = Desk::new(how)?.resume();
    let hold = match Processes::started().leads() {
        true => Some(StagedFolder::go_on(folder)?),
        false => None,
    };
    all(desk, stages, how, (folder, hold))
}

/// The list of the stages, with their scenes.
fn list(stages: &[(String, Planned)]) -> String {
    let here = |base: &Path| {
        let base = if base.as_os_str().is_empty() {
            Path::new(".")
        } else {
            base
        };
        base.canonicalize().unwrap_or_else(|_| base.to_owned())
    };
    let listed = |(name, planned): &(String, Planned)| Listed {
        name: name.clone(),
        case: planned.plan.case.clone(),
        base: here(&planned.loaded.base_dir),
        scene: planned.loaded.resolved_toml(),
    };
    let all: Vec<Listed> = stages.iter().map(listed).collect();
    serde_json::to_string_pretty(&all).unwrap_or_default()
}

/// Runs what is left of the stages, and joins their files.
fn all(
    mut desk: Desk<'_>,
    stages: Vec<(String, Planned)>,
    how: &How,
    (folder, hold): (&Path, Option<StagedFolder>),
) -> Result<(), Failure> {
    let (mut summaries, mut folders) = (Vec::new(), Vec::new());
    for (number, (name, mut planned)) in stages.into_iter().enumerate() {
        let own = folder.join(stage_folder(number, &name));
        if let (Some(before), Some(start)) = (folders.last(), &planned.plan.start) {
            planned.plan.start = Some(StartPlan {
                from: PathBuf::clone(before),
                ..start.clone()
            });
        }
        folders.push(own.clone());
        let summary = one(&mut desk, &planned, &own)?;
        if let (Some(hold), true) = (&hold, Processes::started().leads()) {
            hold.join(&folders)?;
            tell(how, &name, &summary);
        }
        summaries.push(summary);
    }
    let (Some(hold), Some(last)) = (hold, summaries.last()) else {
        return Ok(());
    };
    let mut whole = json!(last);
    whole["stages"] = json!(summaries);
    whole["columns"] = json!(hold.columns()?);
    hold.summary(&whole)?;
    match (how.is_json(), how.is_quiet()) {
        (true, _) => print(&whole.to_string()),
        (false, true) => Ok(()),
        (false, false) => print(&format!("results in {}", folder.display())),
    }
}

/// Runs a stage, goes on with it, or takes its summary where it is done.
fn one(desk: &mut Desk<'_>, planned: &Planned, folder: &Path) -> Result<Summary, Failure> {
    let kept = match desk.resumes() {
        true => begun(folder)?,
        false => None,
    };
    let path = folder.join("summary.json");
    if kept.as_ref().is_some_and(|kept| kept.header.finished)
        && let Some(summary) = read(&path)
    {
        return Ok(summary);
    }
    match kept {
        Some(checkpoint) => {
            let resolved = resolved(folder)?;
            checkpoint.check_scene(&resolved)?;
            checkpoint.check_processes(Processes::started().size)?;
            go_on(desk, planned, folder, &resolved, checkpoint)
        }
        None => {
            let writer = desk.writer(folder, planned)?;
            desk.carry_out(planned, writer, None)
        }
    }
}

/// Where a stage stands; nothing if it has not begun. One that is damaged must not begin anew unasked.
fn begun(folder: &Path) -> Result<Option<Checkpoint>, Failure> {
    match Checkpoint::newest(folder) {
        Ok(checkpoint) => Ok(Some(checkpoint)),
        Err(CheckpointError::Absent { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

fn read(path: &Path) -> Option<Summary> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

fn tell(how: &How, name: &str, summary: &Summary) {
    if !how.is_quiet() && !how.is_json() {
        say(&format!(
            "stage {name}: t = {} s, {} steps, {:.2} s",
            summary.t_end, summary.steps, summary.wall_s
        ));
    }
}
