//! Whole files appear at once or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use flate2::CrcWriter;
use tempfile::{Builder, NamedTempFile};

use super::OutputError;
use super::manifest::{self, Sum};

/// Writes a file so that `path` holds either its old content or all of the new.
///
/// `fill` writes into a temporary file in the same directory, which is flushed, synchronised with
/// the disk and then renamed to `path`. If anything fails, the temporary file is removed and an
/// older file at `path` stays as it was. A symbolic link at `path` is replaced, not followed. In a folder
/// with an open [`Manifest`](super::Manifest) the file is entered there, and what is not the run's own is
/// moved out of its way.
///
/// # Errors
/// [`OutputError::IsDirectory`], [`OutputError::NotFound`], [`OutputError::NotWritable`],
/// [`OutputError::DiskFull`] or [`OutputError::Io`], also for the errors that `fill` returns.
pub fn write_atomically<F>(path: impl AsRef<Path>, fill: F) -> Result<(), OutputError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let path = path.as_ref();
    if path.is_dir() {
        return Err(OutputError::IsDirectory {
            path: path.to_path_buf(),
        });
    }
    let directory = manifest::directory(path);
    let failed = |action| move |source| OutputError::from_io(path, action, source);
    let list = manifest::of(directory);
    if let Some(list) = &list {
        list.make_room(path)?;
    }
    let mut announced = Ok(());
    let temporary = temporary_in(directory, |part| {
        announced = list
            .as_ref()
            .map_or(Ok(()), |list| list.announce(path, Some(part)));
    });
    let temporary = temporary.map_err(failed("create a temporary file beside it"))?;
    announced?;
    let writer = BufWriter::with_capacity(1 << 16, temporary);
    let mut writer = CrcWriter::new(writer);
    fill(&mut writer).map_err(failed("write its content"))?;
    let check = writer.crc().sum();
    let temporary = writer
        .into_inner()
        .into_inner()
        .map_err(|e| failed("flush it")(e.into_error()))?;
    temporary
        .as_file()
        .sync_all()
        .map_err(failed("synchronise it with the disk"))?;
    temporary
        .persist(path)
        .map_err(|e| failed("rename the temporary file to it")(e.error))?;
    synchronise_directory(directory);
    if let Some(list) = &list {
        list.enter(path, Sum::new(check, path).map_err(failed("look at it"))?)?;
    }
    Ok(())
}

/// How names of temporary files begin.
pub(super) const PART_START: &str = ".perifrac-";
/// And how they end.
pub(super) const PART_END: &str = ".part";

/// A temporary file, whose path is told before it appears.
fn temporary_in(directory: &Path, mut tell: impl FnMut(&Path)) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(PART_START).suffix(PART_END);
    builder.make_in(directory, |path| {
        tell(path);
        // Temporary files are private by default; results follow the user's umask instead.
        File::options().write(true).create_new(true).open(path)
    })
}

/// Makes the rename itself durable. Best effort: the file is complete either way, and some file
/// systems refuse to synchronise a directory.
fn synchronise_directory(directory: &Path) {
    if let Ok(handle) = File::open(directory) {
        let _ = handle.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::PathBuf;

    fn names(directory: &Path) -> Vec<PathBuf> {
        fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect()
    }

    #[test]
    fn new_content_replaces_the_old_and_nothing_else_is_left() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        write_atomically(&path, |w| w.write_all(b"old, and longer")).unwrap();
        write_atomically(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(directory.path()), [path]);
    }

    #[test]
    fn a_writer_that_fails_midway_leaves_the_old_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let result = write_atomically(&path, |w| {
            w.write_all(&vec![b'x'; 1 << 20])?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(matches!(result, Err(OutputError::DiskFull { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(directory.path()), [path]);
    }

    #[test]
    fn a_panicking_writer_leaves_no_temporary_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        let attempt = std::panic::AssertUnwindSafe(|| {
            write_atomically(&path, |w| {
                w.write_all(b"half")?;
                panic!("interrupted")
            })
        });
        assert!(std::panic::catch_unwind(attempt).is_err());
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn a_full_device_is_recognised_by_its_system_code() {
        let directory = tempfile::tempdir().unwrap();
        let enospc = 28;
        let result = write_atomically(directory.path().join("a"), |_| {
            Err(io::Error::from_raw_os_error(enospc))
        });
        let text = result.unwrap_err().to_string();
        assert!(
            text.contains("no space left") && text.contains("free some space"),
            "{text}"
        );
    }

    #[test]
    fn a_directory_in_the_way_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let result = write_atomically(directory.path(), |_| Ok(()));
        assert!(matches!(result, Err(OutputError::IsDirectory { .. })));
    }

    #[test]
    fn a_missing_directory_and_a_file_as_directory_are_not_found() {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("file"), "").unwrap();
        for name in ["missing/a.txt", "file/a.txt"] {
            let result = write_atomically(directory.path().join(name), |_| Ok(()));
            assert!(
                matches!(result, Err(OutputError::NotFound { .. })),
                "{name}: {result:?}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn an_unwritable_directory_is_reported_and_left_empty() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        fs::set_permissions(directory.path(), fs::Permissions::from_mode(0o555)).unwrap();
        // The superuser may write anywhere, so there is nothing to check then.
        let superuser = File::create(directory.path().join("probe")).is_ok();
        let result = write_atomically(directory.path().join("a.txt"), |_| Ok(()));
        if !superuser {
            assert!(
                matches!(result, Err(OutputError::NotWritable { .. })),
                "{result:?}"
            );
            assert!(names(directory.path()).is_empty());
        }
        fs::set_permissions(directory.path(), fs::Permissions::from_mode(0o755)).unwrap();
    }
}
