//! The list of the files that a run wrote into its folder: only those may be deleted by the next one.
//!
//! While a [`Manifest`] is open, [`write_atomically`](super::write_atomically) enters every file of the
//! folder, whoever writes it. A file is announced before it appears and entered with size and checksum once
//! it is whole, a line each, so that a run that is killed leaves a list which misses nothing:
//!
//! ```text
//! part .perifrac-Ab3dEf.part              a temporary file
//! file history.csv                        announced, or still growing
//! sum 8d3f21aa 5310 1764335465000000000 fields-0000.vtu
//! ```

mod entries;

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use super::OutputError;
use entries::Entries;
pub(super) use entries::Sum;

/// Name of the list; those of further processes have their number behind it.
pub const LIST: &str = ".perifrac-files";
const HEADER: &str =
    "# What perifrac wrote here. The next run deletes those files that are unchanged.\n";
/// Ending of files of the user that stood where a result belongs.
const KEPT: &str = "kept";

/// The open list of a folder.
#[derive(Debug, Clone)]
pub struct Manifest(Arc<Open>);

#[derive(Debug)]
pub(super) struct Open {
    folder: PathBuf,
    list: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    file: File,
    entries: Entries,
    /// Names that this process wrote.
    own: BTreeSet<String>,
    kept: Vec<PathBuf>,
}

/// Lists that are open in this process.
static OPEN: Mutex<Vec<Weak<Open>>> = Mutex::new(Vec::new());

impl Manifest {
    /// Begins a list of its own for a run.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be written.
    pub fn start(folder: &Path) -> Result<Self, OutputError> {
        Self::begin(folder, folder.join(LIST))
    }

    /// The list of a further process of a run; the one of the run itself where it is open in this process.
    ///
    /// # Errors
    /// As [`Manifest::start`].
    pub fn follow(folder: &Path) -> Result<Self, OutputError> {
        match of(folder) {
            Some(open) => Ok(Manifest(open)),
            None => Self::begin(
                folder,
                folder.join(format!("{LIST}-{}", std::process::id())),
            ),
        }
    }

    /// Goes on with the list of a folder whose files are brought up to date rather than replaced, or begins
    /// one. Temporary files that were left by a kill go. The folder must be locked.
    ///
    /// # Errors
    /// As [`Manifest::start`].
    pub fn go_on(folder: &Path) -> Result<Self, OutputError> {
        let list = folder.join(LIST);
        absorb(folder)?;
        if list.is_file() {
            for part in Entries::read(&list)?.parts_in(folder) {
                fs::remove_file(&part)
                    .map_err(|e| OutputError::from_io(&part, "remove a temporary file", e))?;
            }
        }
        match Self::resume(folder)? {
            Some(resumed) => Ok(resumed),
            None => Self::start(folder),
        }
    }

    /// Goes on with the list that a run left; nothing if it left none.
    ///
    /// # Errors
    /// As [`Manifest::start`].
    pub fn resume(folder: &Path) -> Result<Option<Self>, OutputError> {
        let list = folder.join(LIST);
        if !list.is_file() {
            return Ok(None);
        }
        let failed = |source| OutputError::from_io(&list, "add to the list of files", source);
        let file = OpenOptions::new().append(true).open(&list);
        let (file, entries) = (file.map_err(failed)?, Entries::read(&list)?);
        Self::register(folder, list, file, entries).map(Some)
    }

    fn begin(folder: &Path, list: PathBuf) -> Result<Self, OutputError> {
        let failed = |source| OutputError::from_io(&list, "begin the list of files", source);
        // Not emptied but removed: it may be a link to something else.
        match fs::remove_file(&list) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(failed(error));
            }
            _ => {}
        }
        let mut options = OpenOptions::new();
        let file = options.append(true).create_new(true).open(&list);
        let mut file = file.map_err(failed)?;
        file.write_all(HEADER.as_bytes()).map_err(failed)?;
        // Where a run goes on, its files of before are its own.
        let before = Entries::read(&folder.join(LIST)).unwrap_or_default();
        Self::register(folder, list, file, before)
    }

    fn register(
        folder: &Path,
        list: PathBuf,
        file: File,
        entries: Entries,
    ) -> Result<Self, OutputError> {
        let whole = folder.canonicalize();
        let folder = whole.map_err(|e| OutputError::from_io(folder, "find the folder", e))?;
        let state = Mutex::new(State {
            file,
            entries,
            own: BTreeSet::new(),
            kept: Vec::new(),
        });
        let open = Arc::new(Open {
            folder,
            list,
            state,
        });
        let mut all = locked(&OPEN);
        all.retain(|other| other.strong_count() > 0);
        all.push(Arc::downgrade(&open));
        Ok(Manifest(open))
    }

    /// Files that were not this run's and stood where it wrote one of its own, by their new names.
    pub fn kept(&self) -> Vec<PathBuf> {
        locked(&self.0.state).kept.clone()
    }
}

/// Removes the files that an earlier run wrote here and nobody has changed since, and the temporary files
/// that it left if it was killed. Its lists go too, but for the main one, which the next run replaces.
///
/// # Errors
/// [`OutputError`] if a list cannot be read or a file not be removed.
pub fn remove_results(folder: &Path) -> Result<(), OutputError> {
    let failed = |path: &Path, source| OutputError::from_io(path, "remove an old result", source);
    let names = fs::read_dir(folder).map_err(|source| failed(folder, source))?;
    let names: Vec<_> = names.flatten().map(|entry| entry.file_name()).collect();
    for list in names
        .iter()
        .filter_map(|name| name.to_str())
        .filter(is_list)
    {
        let path = folder.join(list);
        for own in Entries::read(&path)?.unchanged(folder) {
            fs::remove_file(&own).map_err(|source| failed(&own, source))?;
        }
        if list != LIST {
            fs::remove_file(&path).map_err(|source| failed(&path, source))?;
        }
    }
    Ok(())
}

/// Adds the lists that further processes left to the main one.
fn absorb(folder: &Path) -> Result<(), OutputError> {
    let failed =
        |path: &Path, source| OutputError::from_io(path, "join the lists of files", source);
    let names = fs::read_dir(folder).map_err(|source| failed(folder, source))?;
    let names: Vec<_> = names.flatten().map(|entry| entry.file_name()).collect();
    let main = folder.join(LIST);
    let others = names.iter().filter_map(|name| name.to_str());
    for other in others.filter(|name| is_list(name) && *name != LIST) {
        let other = folder.join(other);
        let text = fs::read(&other).map_err(|source| failed(&other, source))?;
        let mut options = OpenOptions::new();
        let file = options.append(true).create(true).open(&main);
        let added = file.and_then(|mut file| file.write_all(&text));
        added.map_err(|source| failed(&main, source))?;
        fs::remove_file(&other).map_err(|source| failed(&other, source))?;
    }
    Ok(())
}

fn is_list(name: &&str) -> bool {
    let rest = name.strip_prefix(LIST);
    rest.is_some_and(|rest| {
        let number = rest.strip_prefix('-');
        rest.is_empty() || number.is_some_and(|number| number.parse::<u32>().is_ok())
    })
}

/// The open list of a folder.
pub(super) fn of(folder: &Path) -> Option<Arc<Open>> {
    let all: Vec<Arc<Open>> = locked(&OPEN).iter().filter_map(Weak::upgrade).collect();
    if all.is_empty() {
        return None;
    }
    let folder = folder.canonicalize().ok()?;
    all.into_iter().find(|open| open.folder == folder)
}

/// Says that a file which was entered goes on growing.
pub(super) fn grows(path: &Path) -> Result<(), OutputError> {
    match of(directory(path)) {
        Some(open) => open.announce(path, None),
        None => Ok(()),
    }
}

/// The folder in which a file stands.
pub(super) fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn name(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy());
    name.unwrap_or_default().into_owned()
}

impl Open {
    /// Moves what stands at `path` out of the way, unless this list says that it may be replaced.
    pub(super) fn make_room(&self, path: &Path) -> Result<(), OutputError> {
        if path.symlink_metadata().is_err() {
            return Ok(());
        }
        let mut state = locked(&self.state);
        if state.entries.owns(path, &name(path)) {
            return Ok(());
        }
        let aside = free_name(path);
        let moved = fs::rename(path, &aside);
        moved.map_err(|e| OutputError::from_io(path, "move it out of the way", e))?;
        state.kept.push(aside);
        Ok(())
    }

    /// Enters a file, and the temporary one that it is written into, before either appears.
    pub(super) fn announce(&self, path: &Path, part: Option<&Path>) -> Result<(), OutputError> {
        let (name, part) = (name(path), part.map(name));
        let part = part.map_or(String::new(), |part| format!("part {part}\n"));
        let mut state = locked(&self.state);
        self.add(&mut state, &format!("{part}file {name}\n"))?;
        state.own.insert(name.clone());
        state.entries.files.insert(name, None);
        Ok(())
    }

    /// Enters a file that is whole.
    pub(super) fn enter(&self, path: &Path, sum: Sum) -> Result<(), OutputError> {
        let name = name(path);
        let mut state = locked(&self.state);
        self.add(&mut state, &format!("sum {sum} {name}\n"))?;
        state.entries.files.insert(name, Some(sum));
        Ok(())
    }

    fn add(&self, state: &mut State, lines: &str) -> Result<(), OutputError> {
        let written = state.file.write_all(lines.as_bytes());
        written.map_err(|e| OutputError::from_io(&self.list, "add to the list of files", e))
    }
}

impl Drop for Open {
    /// What was growing is whole now.
    fn drop(&mut self) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        let is_open = |name: &&String| state.entries.files.get(*name) == Some(&None);
        for name in state.own.iter().filter(is_open) {
            // Without its sum a file counts as the run's own, so nothing is lost if this fails.
            if let Ok(sum) = Sum::of(&self.folder.join(name)) {
                let _ = writeln!(state.file, "sum {sum} {name}");
            }
        }
    }
}

/// `NAME.kept`, or the first of `NAME.kept-2`, `NAME.kept-3` … that is free.
fn free_name(path: &Path) -> PathBuf {
    let named = |ending: String| path.with_file_name(format!("{}.{ending}", name(path)));
    let taken = |path: &PathBuf| path.symlink_metadata().is_ok();
    let mut aside = named(KEPT.to_owned());
    for number in 2_u64.. {
        if !taken(&aside) {
            break;
        }
        aside = named(format!("{KEPT}-{number}"));
    }
    aside
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
