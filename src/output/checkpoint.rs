//! Checkpoints: one self-contained file each, from which a run goes on.
//!
//! ```text
//! perifrac checkpoint 2 5310a2bc        format, CRC-32 of the next line
//! {"version":"0.1.0",…,"sum":2369}      what it is, one line of JSON, readable without perifrac
//! …                                     the content, as `length` bytes of postcard
//! ```
//!
//! Files are written beside and renamed, so that each is whole; the last two are kept. Postcard, the format of
//! the serde crate of that name, holds every number with all its bits and next to nothing else, so a checkpoint
//! is as large as the fields that it holds.

use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::Crc;
use serde::{Deserialize, Serialize};

use super::{OutputError, write_atomically};

/// Version of the layout.
const FORMAT: u32 = 6;
const MAGIC: &str = "perifrac checkpoint";
const START: &str = "checkpoint-";
const ENDING: &str = "pfc";

/// What a checkpoint says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the program.
    pub version: String,
    /// Checksum of the program file: another build may round otherwise.
    pub build: u32,
    /// Name of the case.
    pub case: String,
    /// Checksum of the resolved scene.
    pub scene: u32,
    /// Checksum of the points.
    pub cloud: u32,
    /// Number of points.
    pub points: usize,
    /// 2 or 3.
    pub dimension: usize,
    /// Processes that wrote it together.
    pub processes: usize,
    /// Time, s.
    pub time: f64,
    /// Accepted steps.
    pub steps: u64,
    /// Whether the run had reached its end.
    pub finished: bool,
    /// Bytes of the content.
    pub length: u64,
    /// Its CRC-32.
    pub sum: u32,
}

/// Why a run cannot go on from a checkpoint.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The folder has none.
    #[error(
        "{folder} has no checkpoint; name the folder of a run that was stopped, or start it with `perifrac run`"
    )]
    Absent {
        /// The folder.
        folder: PathBuf,
    },
    /// It is damaged.
    #[error("{path} is no whole checkpoint: {reason}{}", remedy(.before))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
        /// The one before, if there is one.
        before: Option<PathBuf>,
    },
    /// Another version wrote it.
    #[error(
        "{path} was written by perifrac {found}, and this is {own}: go on with that version, or start the run anew"
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Version that wrote it.
        found: String,
        /// This version.
        own: &'static str,
    },
    /// It belongs to another scene, other points or another number of processes.
    #[error("{path} does not fit: {reason}")]
    Misfit {
        /// The file.
        path: PathBuf,
        /// What differs, and what to do.
        reason: String,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

fn remedy(path: &Option<PathBuf>) -> String {
    match path {
        Some(path) => format!(
            "; the one before is {0}: go on from it with --from {0}",
            path.display()
        ),
        None => "; there is none before it, so start the run anew".to_owned(),
    }
}

/// CRC-32 of some bytes.
pub fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Checksum of the program that runs; 0 if it cannot be read.
pub fn build() -> u32 {
    // In parts: memory for the whole program takes longer than its checksum.
    let sum = || -> std::io::Result<u32> {
        let mut program = std::fs::File::open(std::env::current_exe()?)?;
        let (mut crc, mut part) = (Crc::new(), vec![0; 1 << 16]);
        loop {
            match program.read(&mut part)? {
                0 => return Ok(crc.sum()),
                length => crc.update(&part[..length]),
            }
        }
    };
    sum().unwrap_or(0)
}

/// Checkpoint of a number of steps in the folder of a run.
pub fn path(folder: &Path, steps: u64) -> PathBuf {
    folder.join(format!("{START}{steps:010}.{ENDING}"))
}

/// Checkpoints of a folder, the newest first.
pub fn list(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_one = |path: &PathBuf| {
        let name = path.file_stem().and_then(|name| name.to_str());
        let number = name.and_then(|name| name.strip_prefix(START));
        path.extension().is_some_and(|ending| ending == ENDING)
            && number.is_some_and(|number| number.parse::<u64>().is_ok())
    };
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_one).collect();
    found.sort_unstable();
    found.reverse();
    found
}

/// Writes a checkpoint whole or not at all.
///
/// # Errors
/// [`OutputError`] if it cannot be written; an older file stays.
pub fn write(path: &Path, header: &Header, content: &[u8]) -> Result<(), OutputError> {
    let line = serde_json::to_string(header).map_err(|source| OutputError::Json {
        path: path.to_owned(),
        source,
    })?;
    write_atomically(path, |file| {
        let sum = checksum(line.as_bytes());
        writeln!(file, "{MAGIC} {FORMAT} {sum:08x}\n{line}")?;
        file.write_all(content)
    })
}

/// Reads a checkpoint and checks that it is whole; `own` is the version of this program.
///
/// # Errors
/// [`CheckpointError::Damaged`], [`CheckpointError::Version`], or why it cannot be read.
pub fn read(path: &Path, own: &'static str) -> Result<(Header, Vec<u8>), CheckpointError> {
    let bytes = std::fs::read(path).map_err(|e| OutputError::from_io(path, "read it", e))?;
    let damaged = |reason: String| CheckpointError::Damaged {
        path: path.to_owned(),
        reason,
        before: older(path),
    };
    let mut lines = bytes.splitn(3, |byte| *byte == b'\n');
    let [first, line, content] = [(); 3].map(|()| lines.next().unwrap_or_default());
    let first = String::from_utf8_lossy(first);
    let Some(rest) = first.strip_prefix(MAGIC) else {
        return Err(damaged("it does not begin like one".to_owned()));
    };
    let mut words = rest.split_whitespace();
    let format = words.next().unwrap_or_default();
    if format != FORMAT.to_string() {
        return Err(CheckpointError::Version {
            path: path.to_owned(),
            found: format!("with layout {format}"),
            own,
        });
    }
    let sum = format!("{:08x}", checksum(line));
    if words.next() != Some(&sum) {
        return Err(damaged("its header was changed".to_owned()));
    }
    let header = serde_json::from_slice::<Header>(line);
    let header = header.map_err(|error| damaged(error.to_string()))?;
    if header.version != own {
        return Err(CheckpointError::Version {
            path: path.to_owned(),
            found: header.version,
            own,
        });
    }
    if content.len() as u64 != header.length {
        let (found, wanted) = (content.len(), header.length);
        return Err(damaged(format!("it has {found} of {wanted} bytes")));
    }
    if checksum(content) != header.sum {
        return Err(damaged("its checksum is wrong".to_owned()));
    }
    let start = bytes.len() - content.len();
    let mut content = bytes;
    content.drain(..start);
    Ok((header, content))
}

/// The checkpoint before one, in the same folder.
fn older(path: &Path) -> Option<PathBuf> {
    let folder = path.parent()?;
    list(folder)
        .into_iter()
        .find(|other| other.as_path() < path)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: &str = "0.0.1";

    fn header(content: &[u8], steps: u64) -> Header {
        Header {
            version: OWN.to_owned(),
            build: 0,
            case: "a".to_owned(),
            scene: 1,
            cloud: 2,
            points: 3,
            dimension: 2,
            processes: 1,
            time: 0.1,
            steps,
            finished: false,
            length: content.len() as u64,
            sum: checksum(content),
        }
    }

    fn two(folder: &Path) -> [PathBuf; 2] {
        [1, 20].map(|steps| {
            let file = path(folder, steps);
            write(
                &file,
                &header(b"\n\n{content}\n", steps),
                b"\n\n{content}\n",
            )
            .unwrap();
            file
        })
    }

    #[test]
    fn the_content_comes_back_and_the_newest_is_first() {
        let folder = tempfile::tempdir().unwrap();
        let [old, new] = two(folder.path());
        assert_eq!(list(folder.path()), [new.clone(), old]);
        let (header, content) = read(&new, OWN).unwrap();
        assert_eq!((header.steps, &content[..]), (20, &b"\n\n{content}\n"[..]));
    }

    /// Every byte that is changed and every length that it is cut to.
    #[test]
    fn what_is_changed_or_cut_anywhere_is_refused_and_the_one_before_is_offered() {
        let folder = tempfile::tempdir().unwrap();
        let [old, new] = two(folder.path());
        let whole = std::fs::read(&new).unwrap();
        for k in 0..whole.len() {
            let mut changed = whole.clone();
            changed[k] ^= 0x11;
            for bytes in [&changed[..], &whole[..k]] {
                std::fs::write(&new, bytes).unwrap();
                let error = read(&new, OWN).unwrap_err();
                let is_version = matches!(error, CheckpointError::Version { .. });
                let text = error.to_string();
                let offered = text.contains(&old.display().to_string());
                assert!(is_version || offered, "byte {k}: {text}");
            }
        }
    }

    #[test]
    fn another_version_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let [_, new] = two(folder.path());
        let text = read(&new, "9.9.9").unwrap_err().to_string();
        assert!(text.contains("0.0.1") && text.contains("9.9.9"), "{text}");
    }
}
