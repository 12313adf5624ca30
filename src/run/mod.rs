//! One run: build the model, step to the end, write what was asked for.

mod audit;
mod checkpoint;
mod columns;
mod crack_length;
mod error;
mod examine;
mod finish;
mod fracture;
mod job;
mod place;
mod quantities;
mod range;
mod rejections;
mod restart;
mod scale;
mod settings;
mod steady;
mod stops;
mod suction;
mod summary;
mod switching;
mod tables;
mod takeover;
mod time_loop;
mod view;
mod writer;

pub use checkpoint::{Checkpoint, Record, Snapshot};
pub use columns::openings;
pub use error::RunError;
pub use examine::{Examined, begin, examine};
pub use fracture::Results;
pub use job::{Job, Observer, Progress};
pub use place::locate;
#[cfg(feature = "study")]
pub(crate) use quantities::{Quantity, named};
pub use settings::{CheckpointRule, Settings};
pub use summary::{CouplingReport, FieldError, Name, Summary, TimedErrors, WellReport};
pub use tables::{COLUMNS, Column, WrittenColumn};
pub use time_loop::{run, run_job};
pub use view::{FieldValues, View};
pub use writer::{StagedFolder, Writer};

pub use perifrac_solvers::Interrupt;
