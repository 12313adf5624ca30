//! The hold of a run on its folder: nobody else writes there, and only results of runs are replaced.

use std::path::{Path, PathBuf};

use crate::output::{
    FolderLock, LIST, LOCK, Manifest, OutputError, remove_results, write_atomically,
};

const MARK: &str = "resolved.toml";

/// A folder and the right to write there.
pub(super) struct Hold {
    folder: PathBuf,
    /// Closed before the lock is given back.
    manifest: Option<Manifest>,
    /// What the process that leads a run holds.
    _lock: Option<FolderLock>,
}

impl Hold {
    /// Makes the folder if need be and locks it. What is in it must be results; they stay until
    /// [`Hold::begin`].
    ///
    /// # Errors
    /// [`OutputError::Foreign`] for other things in it, [`OutputError::Busy`] if another run writes there,
    /// else why it cannot be used.
    pub(super) fn take(folder: &Path, resolved: &str) -> Result<Self, OutputError> {
        let is_empty = prepare(folder)?;
        let lock = FolderLock::take(folder)?;
        let mut hold = Hold {
            _lock: Some(lock),
            ..Self::follow(folder)
        };
        if is_empty {
            hold.begin(resolved)?;
        }
        Ok(hold)
    }

    /// Locks the folder of a run that goes on.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if another run writes there, else why it cannot be used.
    pub(super) fn go_on(folder: &Path) -> Result<Self, OutputError> {
        let lock = FolderLock::take(folder)?;
        Ok(Hold {
            manifest: Some(Manifest::go_on(folder)?),
            _lock: Some(lock),
            ..Self::follow(folder)
        })
    }

    /// The part of a further process of a run.
    pub(super) fn follow(folder: &Path) -> Self {
        Hold {
            folder: folder.to_owned(),
            manifest: None,
            _lock: None,
        }
    }

    /// Removes the results of an earlier run and writes the resolved scene, which marks the folder as one
    /// of results.
    ///
    /// # Errors
    /// [`OutputError`] of a file that cannot be removed or written.
    pub(super) fn begin(&mut self, resolved: &str) -> Result<(), OutputError> {
        self.manifest = None;
        remove_results(&self.folder)?;
        self.manifest = Some(Manifest::start(&self.folder)?);
        write_atomically(self.folder.join(MARK), |file| {
            file.write_all(resolved.as_bytes())
        })
    }

    /// Opens a list for what a further process writes, unless there is one.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be written.
    pub(super) fn list(&mut self) -> Result<(), OutputError> {
        if self.manifest.is_none() {
            self.manifest = Some(Manifest::follow(&self.folder)?);
        }
        Ok(())
    }

    /// Files that were not the run's and stood where it wrote one of its own, by their new names.
    pub(super) fn kept(&self) -> Vec<PathBuf> {
        self.manifest.as_ref().map_or_else(Vec::new, Manifest::kept)
    }
}

/// Makes the folder if need be; gives whether it is empty.
fn prepare(folder: &Path) -> Result<bool, OutputError> {
    let io = |source: std::io::Error| OutputError::from_io(folder, "prepare the folder", source);
    if !folder.exists() {
        std::fs::create_dir_all(folder).map_err(io)?;
    }
    let entries = std::fs::read_dir(folder).map_err(io)?;
    let names: Result<Vec<_>, _> = entries.map(|entry| Ok(entry?.file_name())).collect();
    let mut names = names.map_err(io)?;
    // Another run that is about to begin here has the lock and nothing else.
    names.retain(|name| name != LOCK);
    if names.iter().any(|name| name == MARK || name == LIST) || names.is_empty() {
        return Ok(names.is_empty());
    }
    Err(OutputError::Foreign {
        path: folder.to_owned(),
    })
}
