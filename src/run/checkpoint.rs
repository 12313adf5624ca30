//! What a run keeps of itself to go on from, and when.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::fracture::Results;
use super::rejections::Rejections;
use super::scale::Scale;
use super::summary::Name;
use super::writer::WriterRecord;
use super::{FieldError, Settings};
use crate::geometry::Cloud;
use crate::output::checkpoint::{self, Header};
use crate::output::{CheckpointError, OutputError};
use crate::plan::Plan;
use crate::report::BalanceRecord;
use crate::schemes::{SchemeCounters, State, StepControl};

/// Version of this program.
const OWN: &str = env!("CARGO_PKG_VERSION");

/// Everything from which a run goes on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The scene, resolved.
    pub scene: String,
    /// Folder that its paths are relative to.
    pub base: PathBuf,
    /// The fields, and what the scheme carries over.
    pub state: State,
    pub(super) course: Course,
    pub(super) files: WriterRecord,
}

/// Where a run stands beside its state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Course {
    /// Time that the run began with, s.
    pub start: f64,
    /// Pressure that it began with, Pa; empty unless it was taken over.
    pub reference: Vec<f64>,
    pub scale: Scale,
    pub control: StepControl,
    /// Stops behind.
    pub passed: usize,
    pub balance: BalanceRecord,
    pub start_volume: [f64; 2],
    pub steps: u64,
    pub rejections: Rejections,
    pub last_output: Option<f64>,
    pub errors: Vec<(f64, BTreeMap<Name, FieldError>)>,
    /// As JSON: what is absent there has no place in postcard.
    pub results: String,
    pub broken_at: Vec<f64>,
    pub drawn: f64,
    pub pressed: Option<f64>,
    pub unsettled: f64,
    pub effort: SchemeCounters,
    pub evaluations: BTreeMap<String, u64>,
    pub refills: u64,
    pub warnings: Vec<String>,
    pub wall_s: f64,
    /// Seconds per phase.
    pub timers: BTreeMap<String, f64>,
}

impl Course {
    pub(super) fn results(&self) -> Results {
        serde_json::from_str(&self.results).unwrap_or_default()
    }
}

/// A checkpoint that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// The file.
    pub path: PathBuf,
    /// What it says of itself.
    pub header: Header,
    /// What it holds.
    pub record: Record,
}

impl Checkpoint {
    /// Reads a checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError`] if it is damaged or of another version.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let (header, content) = checkpoint::read(path, OWN)?;
        let record = postcard::from_bytes(&content).map_err(|error| CheckpointError::Damaged {
            path: path.to_owned(),
            reason: error.to_string(),
            before: None,
        })?;
        Ok(Checkpoint {
            path: path.to_owned(),
            header,
            record,
        })
    }

    /// Reads the newest checkpoint in the folder of a run.
    ///
    /// # Errors
    /// [`CheckpointError::Absent`] without one, else as [`Checkpoint::read`].
    pub fn newest(folder: &Path) -> Result<Self, CheckpointError> {
        match checkpoint::list(folder).first() {
            Some(path) => Self::read(path),
            None => Err(CheckpointError::Absent {
                folder: folder.to_owned(),
            }),
        }
    }

    /// Reads a checkpoint, or the newest one in the folder of a run.
    ///
    /// # Errors
    /// As [`Checkpoint::newest`].
    pub fn open(path: &Path) -> Result<Self, CheckpointError> {
        match path.is_dir() {
            true => Self::newest(path),
            false => Self::read(path),
        }
    }

    /// Whether another build of the same version wrote it, which may round otherwise.
    pub fn is_of_another_build(&self) -> bool {
        self.header.build != checkpoint::build()
    }

    pub(super) fn misfit(&self, reason: String) -> CheckpointError {
        CheckpointError::Misfit {
            path: self.path.clone(),
            reason,
        }
    }

    /// Refuses a checkpoint that other processes wrote than the `processes` of now.
    ///
    /// # Errors
    /// [`CheckpointError::Misfit`].
    pub fn check_processes(&self, processes: usize) -> Result<(), CheckpointError> {
        let wanted = self.header.processes;
        if wanted == processes {
            return Ok(());
        }
        let how = match wanted {
            1 => "start it without mpirun".to_owned(),
            _ => format!("start it with mpirun -n {wanted}"),
        };
        Err(self.misfit(format!(
            "{wanted} processes wrote it, and now there are {processes}; {how}"
        )))
    }

    /// Refuses a checkpoint in whose folder another scene was run since.
    ///
    /// # Errors
    /// [`CheckpointError::Misfit`].
    pub fn check_scene(&self, resolved: &str) -> Result<(), CheckpointError> {
        match checkpoint::checksum(resolved.as_bytes()) == self.header.scene {
            true => Ok(()),
            false => Err(self.misfit(
                "resolved.toml beside it is another scene; put the file back, or start the run anew"
                    .to_owned(),
            )),
        }
    }

    /// Refuses a checkpoint of a plane in space, and the other way round.
    ///
    /// # Errors
    /// [`CheckpointError::Misfit`].
    pub(super) fn check_dimension(&self, dimension: usize) -> Result<(), CheckpointError> {
        match self.header.dimension == dimension {
            true => Ok(()),
            false => Err(self.misfit(format!(
                "its points have {} coordinates, and now they have {dimension}",
                self.header.dimension
            ))),
        }
    }

    /// Refuses a checkpoint of other points.
    ///
    /// # Errors
    /// [`CheckpointError::Misfit`].
    pub fn check_cloud<const D: usize>(&self, cloud: &Cloud<D>) -> Result<(), CheckpointError> {
        if self.header.cloud == cloud_sum(cloud) {
            return Ok(());
        }
        let (then, now) = (self.header.points, cloud.len());
        Err(self.misfit(match then == now {
            true => "its points lie elsewhere: a file that the scene names has changed".to_owned(),
            false => format!("it has {then} points, and now there are {now}"),
        }))
    }

    /// Refuses a checkpoint of a run with effects that are not `known` now: those of a program, which no
    /// scene holds.
    ///
    /// # Errors
    /// [`CheckpointError::Misfit`].
    pub fn check_effects(
        &self,
        known: &BTreeMap<&'static str, u64>,
    ) -> Result<(), CheckpointError> {
        let mut all = self.record.course.evaluations.keys();
        match all.find(|name| !known.contains_key(name.as_str())) {
            None => Ok(()),
            Some(name) => Err(self.misfit(format!(
                "its run has the effect \"{name}\", and this one has not; go on from it in the program that \
                 hands the effect in"
            ))),
        }
    }
}

/// Checksum of the positions and volumes of a cloud.
pub(super) fn cloud_sum<const D: usize>(cloud: &Cloud<D>) -> u32 {
    let numbers = cloud.position.iter().flat_map(|x| x.iter());
    let numbers = numbers.chain(&cloud.volume);
    let bytes: Vec<u8> = numbers.flat_map(|value| value.to_le_bytes()).collect();
    checkpoint::checksum(&bytes)
}

/// The last state that a run has told, to be written by whoever ends the program while a step cannot be left.
#[derive(Debug, Clone, Default)]
pub struct Snapshot(Arc<Mutex<Told>>);

#[derive(Debug, Default)]
struct Told {
    /// Whether anything was told yet.
    ever: bool,
    /// What is not written yet.
    pending: Option<Pending>,
}

#[derive(Debug)]
struct Pending {
    path: PathBuf,
    header: Header,
    content: Vec<u8>,
}

impl Snapshot {
    /// Writes the state that was told last; gives its time in seconds and its file, or nothing where there is
    /// none that is not written yet.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be written.
    pub fn save(&self) -> Result<Option<(f64, PathBuf)>, OutputError> {
        let Some(pending) = self.lock().pending.take() else {
            return Ok(None);
        };
        checkpoint::write(&pending.path, &pending.header, &pending.content)?;
        Ok(Some((pending.header.time, pending.path)))
    }

    /// Whether no state was ever told: the run has not begun, or keeps no checkpoints.
    pub fn is_empty(&self) -> bool {
        !self.lock().ever
    }

    fn tell(&self, pending: Option<Pending>) {
        *self.lock() = Told {
            ever: true,
            pending,
        };
    }

    fn lock(&self) -> MutexGuard<'_, Told> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writes the checkpoints of a run.
#[derive(Debug)]
pub(super) struct Saver {
    folder: PathBuf,
    every: Duration,
    at_outputs: bool,
    build: u32,
    saved: Instant,
    snapshot: Snapshot,
    told: Instant,
    /// Time that telling took.
    cost: Duration,
}

/// Checkpoints that are kept.
const KEPT: usize = 2;
/// Share of the run that telling of the state may take, and the shortest time between two.
const TELLING: u32 = 20;
const SELDOM: Duration = Duration::from_millis(200);

impl Saver {
    /// What writes into a folder as the settings ask; nothing where they ask for no checkpoints.
    pub(super) fn new(folder: &Path, settings: &Settings, snapshot: &Snapshot) -> Option<Self> {
        let rule = settings.checkpoints?;
        Some(Saver {
            folder: folder.to_owned(),
            every: rule.every,
            at_outputs: rule.at_outputs,
            build: checkpoint::build(),
            saved: Instant::now(),
            snapshot: snapshot.clone(),
            told: Instant::now(),
            cost: Duration::ZERO,
        })
    }

    /// Whether a checkpoint is due after a step.
    pub(super) fn is_due(&self, output: bool) -> bool {
        self.saved.elapsed() >= self.every || output && self.at_outputs
    }

    /// Whether the state is to be told, in case the next step cannot be left.
    pub(super) fn is_to_tell(&self) -> bool {
        self.told.elapsed() >= SELDOM.max(TELLING * self.cost)
    }

    /// Tells of a state, which took since `begun` to put together.
    pub(super) fn tell<const D: usize>(
        &mut self,
        at: &RunIdentity<'_, D>,
        record: &Record,
        begun: Instant,
    ) {
        let pending = self.pack(at, record);
        self.snapshot.tell(pending.ok());
        (self.told, self.cost) = (Instant::now(), begun.elapsed());
    }

    /// Writes a checkpoint and removes those beyond the last two.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be written; older ones stay.
    pub(super) fn save<const D: usize>(
        &mut self,
        at: &RunIdentity<'_, D>,
        record: &Record,
    ) -> Result<PathBuf, OutputError> {
        self.saved = Instant::now();
        self.snapshot.tell(None);
        let Pending {
            path,
            header,
            content,
        } = self.pack(at, record)?;
        checkpoint::write(&path, &header, &content)?;
        for old in checkpoint::list(&self.folder).into_iter().skip(KEPT) {
            let removed = std::fs::remove_file(&old);
            removed.map_err(|e| OutputError::from_io(&old, "remove an old checkpoint", e))?;
        }
        Ok(path)
    }

    fn pack<const D: usize>(
        &self,
        at: &RunIdentity<'_, D>,
        record: &Record,
    ) -> Result<Pending, OutputError> {
        let (state, steps) = (&record.state, record.course.steps);
        let path = checkpoint::path(&self.folder, steps);
        let content = postcard::to_stdvec(record).map_err(|error| {
            let source = std::io::Error::other(error);
            OutputError::from_io(&path, "pack the state", source)
        })?;
        let header = Header {
            version: OWN.to_owned(),
            build: self.build,
            case: at.plan.case.clone(),
            scene: checkpoint::checksum(record.scene.as_bytes()),
            cloud: cloud_sum(at.cloud),
            points: at.cloud.len(),
            dimension: D,
            processes: at.processes,
            time: state.time,
            steps,
            finished: state.time >= at.plan.time.end,
            length: content.len() as u64,
            sum: checkpoint::checksum(&content),
        };
        Ok(Pending {
            path,
            header,
            content,
        })
    }
}

/// What a checkpoint says of the run that it belongs to.
pub(super) struct RunIdentity<'a, const D: usize> {
    pub plan: &'a Plan,
    pub cloud: &'a Cloud<D>,
    pub processes: usize,
}
