//! Numbers and section marks of a `.msh` file one after another.

use std::path::Path;
use std::str::FromStr;

use crate::plan::files::{FileError, Place};

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Binary { big_endian: bool },
}

/// A place in a file.
pub(super) struct Cursor<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Cursor<'a> {
    /// Reads the section `$MeshFormat`, which comes first.
    ///
    /// # Errors
    /// [`FileError::Damaged`] if it is not there, [`FileError::Unsupported`] for another version.
    pub(super) fn open(path: &'a Path, bytes: &'a [u8]) -> Result<Self, FileError> {
        let mut cursor = Cursor {
            path,
            bytes,
            at: 0,
            encoding: Encoding::Text,
        };
        if cursor.section()?.as_deref() != Some("MeshFormat") {
            return Err(cursor.damaged("it does not begin with $MeshFormat".to_owned()));
        }
        let version: String = cursor.number("a version")?;
        let unsupported = |what, found: String, remedy| FileError::Unsupported {
            path: path.to_path_buf(),
            what,
            found,
            remedy,
        };
        if version != "4.1" {
            let remedy = "save the mesh in version 4.1 (gmsh -save -format msh41)";
            return Err(unsupported("version", version, remedy));
        }
        let binary: u8 = cursor.number("whether the file is binary")?;
        let size: u8 = cursor.number("the size of numbers")?;
        if size != 8 {
            let remedy = "save the mesh with 8 bytes a number";
            return Err(unsupported("the size of numbers", size.to_string(), remedy));
        }
        if binary == 1 {
            cursor.end_line();
            let big_endian = cursor.is_big_endian()?;
            cursor.encoding = Encoding::Binary { big_endian };
        }
        cursor.end("MeshFormat")?;
        Ok(cursor)
    }

    /// The order of bytes, of which a 1 is the mark.
    fn is_big_endian(&mut self) -> Result<bool, FileError> {
        match self.take::<4>("the order of bytes")? {
            [1, 0, 0, 0] => Ok(false),
            [0, 0, 0, 1] => Ok(true),
            _ => Err(self.damaged("the mark of the order of bytes is not 1".to_owned())),
        }
    }

    /// The file.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// Name of the section that begins here; `None` at the end of the file.
    pub(super) fn section(&mut self) -> Result<Option<String>, FileError> {
        match self.word() {
            None => Ok(None),
            Some(word) => match word.strip_prefix('$') {
                Some(name) if !name.starts_with("End") => {
                    self.end_line();
                    Ok(Some(name.to_owned()))
                }
                _ => Err(self.damaged(format!("`{word}` stands where a section should begin"))),
            },
        }
    }

    /// Numbers of a binary section begin right behind the end of the line of its name.
    fn end_line(&mut self) {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == b'\n');
        self.at += end.map_or(0, |end| end + 1);
    }

    /// Goes to the end of a section.
    pub(super) fn skip(&mut self, section: &str) -> Result<(), FileError> {
        let mark = format!("$End{section}");
        let rest = &self.bytes[self.at..];
        let found = rest
            .windows(mark.len())
            .position(|window| window == mark.as_bytes());
        self.at += found.ok_or_else(|| self.damaged(format!("{mark} is missing")))?;
        Ok(())
    }

    /// Takes the mark at the end of a section.
    pub(super) fn end(&mut self, section: &str) -> Result<(), FileError> {
        let mark = format!("$End{section}");
        match self.word() {
            Some(word) if word == mark => Ok(()),
            Some(word) => Err(self.damaged(format!("`{word}` stands where {mark} should"))),
            None => Err(self.damaged(format!("{mark} is missing"))),
        }
    }

    /// A number of 4 bytes.
    pub(super) fn int(&mut self, what: &str) -> Result<i32, FileError> {
        match self.encoding {
            Encoding::Text => self.number(what),
            Encoding::Binary { big_endian } => {
                let bytes = self.take::<4>(what)?;
                Ok(if big_endian {
                    i32::from_be_bytes(bytes)
                } else {
                    i32::from_le_bytes(bytes)
                })
            }
        }
    }

    /// A number or count of 8 bytes.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, FileError> {
        match self.encoding {
            Encoding::Text => self.number(what),
            Encoding::Binary { big_endian } => {
                let bytes = self.take::<8>(what)?;
                Ok(if big_endian {
                    u64::from_be_bytes(bytes)
                } else {
                    u64::from_le_bytes(bytes)
                })
            }
        }
    }

    /// A coordinate.
    pub(super) fn real(&mut self, what: &str) -> Result<f64, FileError> {
        match self.encoding {
            Encoding::Text => self.number(what),
            Encoding::Binary { .. } => self.size(what).map(f64::from_bits),
        }
    }

    /// A word as a number, in binary files too.
    pub(super) fn number<T: FromStr>(&mut self, what: &str) -> Result<T, FileError> {
        let word = self.word().ok_or_else(|| self.cut_off(what))?;
        let number = word.parse();
        number.map_err(|_| self.damaged(format!("`{word}` stands where {what} should")))
    }

    /// The rest of a line between quotation marks.
    pub(super) fn quoted(&mut self) -> Result<String, FileError> {
        let rest = &self.bytes[self.at..];
        let line = rest.split(|byte| *byte == b'\n').next().unwrap_or(rest);
        let text = String::from_utf8_lossy(line);
        let name = text
            .trim()
            .strip_prefix('"')
            .and_then(|text| text.strip_suffix('"'));
        let name = name.map(str::to_owned);
        let name = name
            .ok_or_else(|| self.damaged("a name between quotation marks is missing".to_owned()));
        self.at += line.len();
        name
    }

    /// The file is damaged here.
    pub(super) fn damaged(&self, reason: String) -> FileError {
        let before = &self.bytes[..self.at.min(self.bytes.len())];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        FileError::Damaged {
            path: self.path.to_path_buf(),
            place: (self.encoding == Encoding::Text).then_some(Place::Line(line)),
            reason,
        }
    }

    fn cut_off(&self, what: &str) -> FileError {
        self.damaged(format!("the file ends where {what} should stand"))
    }

    fn word(&mut self) -> Option<String> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = &rest[start..];
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        self.at += start + length;
        Some(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], FileError> {
        let chunk = self
            .bytes
            .get(self.at..)
            .and_then(|rest| rest.first_chunk::<N>());
        let chunk = *chunk.ok_or_else(|| self.cut_off(what))?;
        self.at += N;
        Ok(chunk)
    }
}
