//! The lines of a list of files, and whether files are still what they say.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::str::FromStr;
use std::time::UNIX_EPOCH;

use super::super::OutputError;
use super::super::atomic::{PART_END, PART_START};

/// What a list says.
#[derive(Debug, Default)]
pub(super) struct Entries {
    /// Files with their sums; none of a file that was growing when the run was killed.
    pub files: BTreeMap<String, Option<Sum>>,
    /// Temporary files.
    parts: Vec<String>,
}

/// What tells the content of a file from any other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sum {
    /// CRC-32.
    pub check: u32,
    /// Bytes.
    pub size: u64,
    /// Time of the last change, ns since 1970.
    pub changed: u128,
}

impl Entries {
    /// Reads a list; a line that is torn or foreign says nothing.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be read.
    pub(super) fn read(list: &Path) -> Result<Self, OutputError> {
        let bytes = std::fs::read(list);
        let bytes = bytes.map_err(|e| OutputError::from_io(list, "read the list of files", e))?;
        let text = String::from_utf8_lossy(&bytes);
        let mut entries = Self::default();
        let whole = text
            .split_inclusive('\n')
            .filter_map(|line| line.strip_suffix('\n'));
        whole.for_each(|line| entries.take(line));
        Ok(entries)
    }

    fn take(&mut self, line: &str) {
        let (kind, rest) = line.split_once(' ').unwrap_or_default();
        match kind {
            "part" if is_part(rest) => self.parts.push(rest.to_owned()),
            "file" if is_plain(rest) => {
                self.files.insert(rest.to_owned(), None);
            }
            "sum" => {
                let mut words = rest.splitn(4, ' ');
                let mut word = || words.next().unwrap_or_default();
                let sum = [word(), word(), word()].join(" ").parse();
                if let (Ok(sum), name) = (sum, word())
                    && is_plain(name)
                {
                    self.files.insert(name.to_owned(), Some(sum));
                }
            }
            _ => {}
        }
    }

    /// Whether the file at `path`, which bears the name, is what the list says of it.
    pub(super) fn owns(&self, path: &Path, name: &str) -> bool {
        match self.files.get(name) {
            None => false,
            Some(None) => true,
            Some(Some(sum)) => sum.is_of(path),
        }
    }

    /// Temporary files of the list that are there.
    pub(super) fn parts_in(&self, folder: &Path) -> Vec<PathBuf> {
        let parts = self.parts.iter().map(|name| folder.join(name));
        parts.filter(is_file).collect()
    }

    /// Files of the list that are there and unchanged, temporary ones too.
    pub(super) fn unchanged(&self, folder: &Path) -> Vec<PathBuf> {
        let files = self.files.keys().map(|name| (name, folder.join(name)));
        let files = files.filter(|(name, path)| is_file(path) && self.owns(path, name));
        let files = files.map(|(_, path)| path);
        files.chain(self.parts_in(folder)).collect()
    }
}

fn is_file(path: &impl AsRef<Path>) -> bool {
    let path = path.as_ref();
    path.symlink_metadata().is_ok_and(|data| data.is_file())
}

/// A name and no way to elsewhere.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(own)), None) if own == name)
}

fn is_part(name: &str) -> bool {
    is_plain(name) && name.starts_with(PART_START) && name.ends_with(PART_END)
}

impl Sum {
    /// Sum of a file that is written already.
    ///
    /// # Errors
    /// Those of reading it.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let mut reader = flate2::CrcReader::new(File::open(path)?);
        let mut buffer = vec![0; 1 << 16];
        while io::Read::read(&mut reader, &mut buffer)? > 0 {}
        Self::new(reader.crc().sum(), path)
    }

    /// Sum of a file whose checksum is known.
    ///
    /// # Errors
    /// Those of asking for its size.
    pub(crate) fn new(check: u32, path: &Path) -> io::Result<Self> {
        let data = path.metadata()?;
        let changed = data.modified()?.duration_since(UNIX_EPOCH);
        Ok(Sum {
            check,
            size: data.len(),
            changed: changed.unwrap_or_default().as_nanos(),
        })
    }

    /// Whether a file still has the content. It is read only if its time has changed, as in a copy.
    fn is_of(self, path: &Path) -> bool {
        let Ok(now) = Self::new(self.check, path) else {
            return false;
        };
        let same = || Self::of(path).is_ok_and(|own| own.check == self.check);
        now.size == self.size && (now.changed == self.changed || same())
    }
}

impl fmt::Display for Sum {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{:08x} {} {}",
            self.check, self.size, self.changed
        )
    }
}

impl FromStr for Sum {
    type Err = std::num::ParseIntError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut words = text.splitn(3, ' ');
        let mut word = || words.next().unwrap_or_default();
        Ok(Sum {
            check: u32::from_str_radix(word(), 16)?,
            size: word().parse()?,
            changed: word().parse()?,
        })
    }
}
