//! Collections of `.vtu` files over time (`.pvd`), the file to open in `ParaView`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::vtk::escape;
use super::{OutputError, write_atomically};

const OPENING: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" \
                       byte_order=\"LittleEndian\">\n<Collection>\n";
const CLOSING: &str = "</Collection>\n</VTKFile>\n";

/// A time series of output files.
///
/// The whole file is rewritten atomically after each output, so that an interrupted run leaves a
/// complete collection of everything written so far.
#[derive(Debug)]
pub struct Pvd {
    path: PathBuf,
    entries: Vec<(f64, String)>,
}

impl Pvd {
    /// Starts an empty collection, replacing an older file.
    ///
    /// # Errors
    /// [`OutputError`] if the file cannot be written.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let collection = Self {
            path: path.as_ref().to_path_buf(),
            entries: Vec::new(),
        };
        collection.rewrite()?;
        Ok(collection)
    }

    /// Continues an existing collection, keeping the entries up to the time `until` (s), which a
    /// resumed run starts from. A missing file is created.
    ///
    /// # Errors
    /// [`OutputError::Malformed`] if this program did not write the file, else [`OutputError`] if it
    /// cannot be read or written.
    pub fn resume(path: impl AsRef<Path>, until: f64) -> Result<Self, OutputError> {
        let path = path.as_ref();
        if !path.exists() {
            return Self::create(path);
        }
        let text =
            std::fs::read_to_string(path).map_err(|e| OutputError::from_io(path, "read it", e))?;
        let mut entries = parse(path, &text)?;
        entries.retain(|(time, _)| *time <= until);
        let collection = Self {
            path: path.to_path_buf(),
            entries,
        };
        collection.rewrite()?;
        Ok(collection)
    }

    /// Times, s, and files of a collection, relative to it; none where there is no such file.
    ///
    /// # Errors
    /// [`OutputError::Malformed`] if this program did not write it, else why it cannot be read.
    pub fn read(path: &Path) -> Result<Vec<(f64, String)>, OutputError> {
        if !path.exists() {
            return Ok(Vec::new());
        }
        let text = std::fs::read_to_string(path);
        parse(
            path,
            &text.map_err(|e| OutputError::from_io(path, "read it", e))?,
        )
    }

    /// Times of the outputs, s.
    pub fn times(&self) -> Vec<f64> {
        self.entries.iter().map(|(time, _)| *time).collect()
    }

    /// Adds the output `file` at `time` (s). A path below the directory of the collection is stored
    /// relative to it, so that the results can be moved together.
    ///
    /// # Errors
    /// [`OutputError`] if the file cannot be written.
    pub fn add(&mut self, time: f64, file: impl AsRef<Path>) -> Result<(), OutputError> {
        let file = file.as_ref();
        let directory = self.path.parent().unwrap_or(Path::new(""));
        let relative = file.strip_prefix(directory).unwrap_or(file);
        self.entries
            .push((time, relative.to_string_lossy().replace('\\', "/")));
        self.rewrite()
    }

    fn rewrite(&self) -> Result<(), OutputError> {
        let mut text = String::from(OPENING);
        for (time, file) in &self.entries {
            let file = escape(file);
            let _ = writeln!(
                text,
                "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>"
            );
        }
        text.push_str(CLOSING);
        write_atomically(&self.path, |writer| writer.write_all(text.as_bytes()))
    }
}

/// Reads the lines [`Pvd::rewrite`] writes; it is no general XML reader.
fn parse(path: &Path, text: &str) -> Result<Vec<(f64, String)>, OutputError> {
    let malformed = |line: usize, reason: &str| OutputError::Malformed {
        path: path.to_path_buf(),
        line,
        reason: reason.to_owned(),
    };
    let body = text
        .strip_prefix(OPENING)
        .and_then(|rest| rest.strip_suffix(CLOSING))
        .ok_or_else(|| malformed(1, "it is not a collection written by perifrac"))?;
    let mut entries = Vec::new();
    for (index, line) in body.lines().enumerate() {
        let entry = attribute(line, "timestep")
            .and_then(|time| time.parse().ok())
            .zip(attribute(line, "file"));
        let number = OPENING.lines().count() + index + 1;
        let (time, file) = entry.ok_or_else(|| malformed(number, "no time or no file name"))?;
        entries.push((time, unescape(file)));
    }
    Ok(entries)
}

fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = line.split_once(&format!(" {name}=\""))?;
    rest.split_once('"').map(|(value, _)| value)
}

fn unescape(text: &str) -> String {
    text.replace("&quot;", "\"")
        .replace("&gt;", ">")
        .replace("&lt;", "<")
        .replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(path: &Path) -> Vec<(String, String)> {
        let text = std::fs::read_to_string(path).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let sets = document
            .descendants()
            .filter(|node| node.has_tag_name("DataSet"));
        let get = |node: roxmltree::Node<'_, '_>, name| node.attribute(name).unwrap().to_owned();
        sets.map(|node| (get(node, "timestep"), get(node, "file")))
            .collect()
    }

    #[test]
    fn the_collection_is_complete_after_every_output() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.pvd");
        let mut collection = Pvd::create(&path).unwrap();
        assert!(listed(&path).is_empty());
        collection.add(0.0, "fields/a&b.vtu").unwrap();
        assert_eq!(
            listed(&path),
            [("0.0".to_owned(), "fields/a&b.vtu".to_owned())]
        );
        collection
            .add(0.1, directory.path().join("fields/1.vtu"))
            .unwrap();
        assert_eq!(
            listed(&path)[1],
            ("0.1".to_owned(), "fields/1.vtu".to_owned())
        );
    }

    #[test]
    fn resuming_keeps_the_entries_up_to_the_checkpoint() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.pvd");
        let mut collection = Pvd::create(&path).unwrap();
        for time in [0.0, 1.0, 2.0] {
            collection
                .add(time, format!("<{time}> & more.vtu"))
                .unwrap();
        }
        let mut collection = Pvd::resume(&path, 1.0).unwrap();
        collection.add(1.5, "new.vtu").unwrap();
        let files: Vec<String> = listed(&path).into_iter().map(|(_, file)| file).collect();
        assert_eq!(files, ["<0> & more.vtu", "<1> & more.vtu", "new.vtu"]);
    }

    #[test]
    fn a_foreign_file_is_not_overwritten() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.pvd");
        std::fs::write(&path, "<VTKFile/>").unwrap();
        assert!(matches!(
            Pvd::resume(&path, 1.0),
            Err(OutputError::Malformed { .. })
        ));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "<VTKFile/>");
    }
}
