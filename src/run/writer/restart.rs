//! Going on with the files of a run that was stopped.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{CrackLines, Cracks, Hold, Profiles, WHOLE, Writer, has_fields};
use crate::model::Model;
use crate::output::{History, OutputError, Pvd, cut_vtkhdf};
use crate::plan::Plan;

/// Where the files of a run stand.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct WriterRecord {
    outputs: usize,
    seen: u64,
    stride: u64,
    profiles: usize,
    /// Part of the format of checkpoints, and empty: damage at the outputs stands in files.
    frames: Vec<(f64, Vec<f64>)>,
}

impl Writer {
    /// The writer of a run that goes on in its folder, which is locked; nothing is changed yet.
    ///
    /// # Errors
    /// [`OutputError`] for a folder that cannot be used.
    pub fn go_on(folder: &Path, resolved: &str) -> Result<Self, OutputError> {
        Ok(Writer {
            leads: true,
            hold: Hold::go_on(folder)?,
            ..Self::follow(folder, resolved)
        })
    }

    /// What a checkpoint keeps of the files.
    pub fn record(&self) -> WriterRecord {
        WriterRecord {
            outputs: self.outputs,
            seen: self.seen,
            stride: self.stride,
            profiles: self.profiles.as_ref().map_or(0, Profiles::seen),
            frames: Vec::new(),
        }
    }

    /// Whether this is the process that writes what there is once.
    pub fn leads(&self) -> bool {
        self.leads
    }

    /// Resolved scene of the run.
    pub fn resolved(&self) -> &str {
        &self.resolved
    }

    /// Brings all files back to where they stood at a checkpoint: rows after its `time` (s) go, and what was
    /// written after its last output will be written again.
    ///
    /// # Errors
    /// [`OutputError`] if a file is missing or is not that of the run.
    pub fn resume<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        record: &WriterRecord,
        (time, last_output): (f64, Option<f64>),
    ) -> Result<(), OutputError> {
        self.outputs = record.outputs;
        if !self.leads {
            return Ok(());
        }
        let until = last_output.unwrap_or(f64::NEG_INFINITY);
        self.resume_history::<D>(plan, record, time)?;
        if plan.output.vtu && record.outputs > 0 {
            self.pvd = Some(Pvd::resume(self.folder.join("fields.pvd"), until)?);
        }
        if plan.output.vtkhdf && record.outputs > 0 {
            cut_vtkhdf(self.folder.join(WHOLE), record.outputs)?;
        }
        if has_fields(plan) && record.outputs > 0 {
            let mut lines = CrackLines::new(plan, model);
            lines.resume(&self.folder, until)?;
            self.crack_lines = Some(lines);
        }
        let mut profiles = Profiles::new(&self.folder, plan);
        profiles.resume(plan, record.profiles, until)?;
        self.profiles = Some(profiles);
        let mut cracks = Cracks::new(&self.folder, plan);
        cracks.resume(plan, until)?;
        self.cracks = Some(cracks);
        Ok(())
    }

    fn resume_history<const D: usize>(
        &mut self,
        plan: &Plan,
        record: &WriterRecord,
        time: f64,
    ) -> Result<(), OutputError> {
        self.rows.columns = super::super::columns::names::<D>(plan);
        let path = self.folder.join("history.csv");
        self.history = Some(History::resume(&path, &self.rows.columns, time)?);
        self.rows = History::read(&path)?;
        (self.seen, self.stride) = (record.seen, record.stride.max(1));
        // A run that went on after the checkpoint may have left out rows since.
        let rows = self.rows.rows.len() as u64;
        while self.seen.div_ceil(self.stride) > rows && self.stride < self.seen {
            self.stride *= 2;
        }
        let expected = self.seen.div_ceil(self.stride);
        match rows == expected {
            true => Ok(()),
            false => Err(OutputError::Shape {
                path,
                what: format!("the history up to t = {time:e} s"),
                expected: expected as usize,
                found: rows as usize,
            }),
        }
    }
}
