//! One run at a time in a folder.

use std::fs::{File, OpenOptions};
use std::io::{Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};

use super::OutputError;

/// Name of the file that is locked.
pub const LOCK: &str = ".perifrac-lock";

/// The right to write into a folder. The system takes it back when the process ends, however that ends.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// Nothing on a file system that knows no locks.
    _file: Option<Flock<File>>,
}

/// How often to try again: a holder that was killed just now takes a moment to go away.
const TRIES: usize = 10;
/// Pause between two tries.
const PAUSE: Duration = Duration::from_millis(50);

impl FolderLock {
    /// Locks a folder that exists.
    ///
    /// # Errors
    /// [`OutputError::Busy`] with the number of the process that holds it, else why the file of the lock
    /// cannot be made.
    pub fn take(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(LOCK);
        let failed = |source| OutputError::from_io(&path, "lock the folder", source);
        for _ in 0..TRIES {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let file = options.open(&path).map_err(failed)?;
            match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
                Ok(mut file) if is_still_there(&file, &path) => {
                    name_holder(&mut file).map_err(failed)?;
                    let _file = Some(file);
                    return Ok(FolderLock { path, _file });
                }
                // Held, or removed by the holder before: others would lock another file.
                Ok(_) | Err((_, Errno::EWOULDBLOCK)) => std::thread::sleep(PAUSE),
                Err(_) => return Ok(FolderLock { path, _file: None }),
            }
        }
        Err(OutputError::Busy {
            process: holder(&path),
            path: folder.to_owned(),
        })
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // What stays behind is locked by nobody.
        let _ = std::fs::remove_file(&self.path);
    }
}

fn is_still_there(file: &File, path: &Path) -> bool {
    let place = |data: std::fs::Metadata| (data.dev(), data.ino());
    let (own, named) = (file.metadata().map(place), path.metadata().map(place));
    matches!((own, named), (Ok(own), Ok(named)) if own == named)
}

fn name_holder(file: &mut File) -> std::io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{}", std::process::id())
}

/// The process that holds the lock, as it says itself; 0 if it does not.
fn holder(path: &Path) -> u32 {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.trim().parse().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_held_by_one_and_free_again_afterwards() {
        let folder = tempfile::tempdir().unwrap();
        let held = FolderLock::take(folder.path()).unwrap();
        let refused = FolderLock::take(folder.path()).unwrap_err().to_string();
        let process = std::process::id().to_string();
        assert!(refused.contains(&process), "{refused}");
        drop(held);
        assert!(!folder.path().join(LOCK).exists());
        FolderLock::take(folder.path()).unwrap();
    }

    #[test]
    fn what_a_killed_process_left_locks_nothing() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(LOCK), "999999\n").unwrap();
        let _held = FolderLock::take(folder.path()).unwrap();
        assert_eq!(holder(&folder.path().join(LOCK)), std::process::id());
    }
}
