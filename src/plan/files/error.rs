//! The one error type of the file readers.

use std::fmt;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Where in a file a value stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, counted from 1.
    Line(usize),
    /// Entry of an array in the order it is handed over, counted from 0.
    Index(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(formatter, "line {line}"),
            Self::Index(index) => write!(formatter, "index {index} (counted from 0)"),
        }
    }
}

/// What makes a number unusable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValueFault {
    /// Not a number.
    Nan,
    /// Plus or minus infinity, or too large for a double.
    Infinite,
    /// Zero or negative where only positive values have a meaning.
    NotPositive,
    /// Below zero where only zero and positive values have a meaning.
    Negative,
    /// Above what has a meaning.
    Above {
        /// The largest value that has one.
        most: f64,
        /// Why it is no more.
        why: &'static str,
    },
}

impl fmt::Display for ValueFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Nan => "not a number; fill the gap in the data",
            Self::Infinite => "not finite; correct the value",
            Self::NotPositive => "not positive; correct the value",
            Self::Negative => "negative; correct the value",
            Self::Above { most, why } => {
                return write!(formatter, "above {most}: {why}; correct the value");
            }
        })
    }
}

/// Why a file gives no points or properties; every message names the file and the remedy.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// There is no such file.
    #[error("{path}: file not found; correct the path, which is relative to the scene file")]
    NotFound {
        /// The file that was asked for.
        path: PathBuf,
    },
    /// No file of this name comes with the program.
    #[error("no file \"{name}\" comes with the program; there is {}", known.join(", "))]
    NotBundled {
        /// The name that was asked for.
        name: String,
        /// All names.
        known: Vec<&'static str>,
    },
    /// More or fewer values than cells of the array.
    #[error(
        "{path}: {found} values, but `cells` says {cells}; correct `cells`, or leave it out for one value \
         per point"
    )]
    Cells {
        /// The file.
        path: PathBuf,
        /// Values in it.
        found: usize,
        /// Cells along each axis and in all.
        cells: String,
    },
    /// A directory stands where a file is wanted.
    #[error("{path} is a directory; give the name of a file inside it")]
    IsDirectory {
        /// The directory.
        path: PathBuf,
    },
    /// The user may not read the file.
    #[error("{path}: no permission to read the file; change its permissions")]
    NotReadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Any other failure of the operating system.
    #[error("{path}: could not be read: {source}; check the device, then try again")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The name does not tell a format that is read here.
    #[error("{path}: {found} is not a known format; the known extensions are {known}")]
    MirrorContinuation {
        /// The file.
        path: PathBuf,
        /// Its extension.
        found: String,
        /// The extensions that are read here.
        known: &'static str,
    },
    /// The bytes are no UTF-8 text.
    #[error("{path}, line {line}: not UTF-8 text; save the file with the encoding UTF-8")]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// First line with a wrong byte, counted from 1.
        line: usize,
    },
    /// The file has no values.
    #[error("{path}: the file holds no {what}; add at least one")]
    Empty {
        /// The file.
        path: PathBuf,
        /// What is missing, in the plural.
        what: &'static str,
    },
    /// The first line holds numbers instead of names.
    #[error("{path}, line {line}: `{found}` is no column name; add a header line with the names")]
    NoHeader {
        /// The file.
        path: PathBuf,
        /// Line where the header should be, counted from 1.
        line: usize,
        /// The number found instead of a name.
        found: String,
    },
    /// A column or point array that is needed is not there.
    #[error("{path}: no {kind} {missing}; the file has {found}; {remedy}")]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// `column` or `point data`.
        kind: &'static str,
        /// The names wanted.
        missing: String,
        /// The names in the file.
        found: String,
        /// What to do, with the closest name.
        remedy: String,
    },
    /// Two columns mean the same.
    #[error("{path}: the columns `{first}` and `{second}` are the same; remove or rename one")]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// The first of the two.
        first: String,
        /// The second.
        second: String,
    },
    /// A column name ends in a unit other than the SI unit.
    #[error(
        "{path}: column `{column}` has the unit `{unit}`; convert the values to {expected} and \
         name it `{name}_{expected}`"
    )]
    WrongUnit {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The column without its unit.
        name: String,
        /// The unit it has.
        unit: String,
        /// The unit it must have.
        expected: &'static str,
    },
    /// A column of a table with several must be chosen.
    #[error("{path}: the file has several columns, {found}; choose one with `column`")]
    ColumnNeeded {
        /// The file.
        path: PathBuf,
        /// The names in the file.
        found: String,
    },
    /// A column was chosen in a format without columns.
    #[error("{path}: an `.npy` file has no column `{column}`; remove `column`")]
    ColumnInArray {
        /// The file.
        path: PathBuf,
        /// The column asked for.
        column: String,
    },
    /// A row is shorter or longer than the header.
    #[error(
        "{path}, line {line}: {found} values, but the header has {expected} columns; complete the \
         line"
    )]
    Ragged {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Number of columns in the header.
        expected: usize,
        /// Number of values in the line.
        found: usize,
    },
    /// A cell that must hold a value is empty.
    #[error("{path}, line {line}: column `{column}` is empty; fill in a value")]
    EmptyCell {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// The column.
        column: String,
    },
    /// A cell holds something other than a number.
    #[error("{path}, line {line}: `{text}` in column `{column}` is no number; correct it")]
    NotNumber {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// The column.
        column: String,
        /// What the cell holds.
        text: String,
    },
    /// A number that makes no sense for the quantity.
    #[error("{path}, {place}: {quantity} is {value:?}, {fault} ({bad} of {total} values are bad)")]
    Value {
        /// The file.
        path: PathBuf,
        /// Where the first bad value stands.
        place: Place,
        /// The quantity.
        quantity: &'static str,
        /// The first bad value, SI unit of the quantity.
        value: f64,
        /// What is wrong with it.
        fault: ValueFault,
        /// How many values of the quantity are bad.
        bad: usize,
        /// How many values of the quantity there are.
        total: usize,
    },
    /// The file is cut off or was changed, so that its parts do not fit together.
    #[error(
        "{path}{place}: {reason}; the file is damaged or incomplete: write or copy it again",
        place = comma(.place)
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where, if the format has lines.
        place: Option<Place>,
        /// What does not fit.
        reason: String,
    },
    /// An array whose shape is not that of the points.
    #[error("{path}: an array of shape {shape} for {points}; {remedy}")]
    Shape {
        /// The file.
        path: PathBuf,
        /// The shape of the array.
        shape: String,
        /// How the points are arranged.
        points: String,
        /// What to do.
        remedy: String,
    },
    /// More or fewer values than points.
    #[error(
        "{path}: {found} values for {points} points; the file needs one value per point, in \
         the order of the cloud (x fastest on a lattice)"
    )]
    Length {
        /// The file.
        path: PathBuf,
        /// Values found.
        found: usize,
        /// Points of the cloud.
        points: usize,
    },
    /// An element of a mesh that cannot become a point.
    #[error("{path}: element {label}, a {kind}: {fault}")]
    Element {
        /// The file.
        path: PathBuf,
        /// Number of the element in the file.
        label: u64,
        /// Its form.
        kind: &'static str,
        /// What is wrong with it, and what to do.
        fault: String,
    },
    /// The file may be sound, but has a variant of its format that is not read here.
    #[error("{path}: {what} `{found}` is not read here; {remedy}")]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The property of the file.
        what: &'static str,
        /// Its value.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
}

fn comma(place: &Option<Place>) -> String {
    place.map(|place| format!(", {place}")).unwrap_or_default()
}
