//! The frame of a `.vtu` file: its root element, and the block of data after the XML.

use std::borrow::Cow;
use std::path::Path;

use roxmltree::Node;

use super::super::FileError;
use super::super::error::Place;

/// Data of all arrays in one block at the end of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Appended<'a> {
    /// Whether the block is base64 text instead of bytes.
    pub(super) base64: bool,
    /// The block, without the underscore that starts it.
    pub(super) bytes: &'a [u8],
}

/// How numbers are stored in a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout<'a> {
    /// Whether the most significant byte comes first.
    pub(super) big_endian: bool,
    /// Bytes of one number of a block header, 4 or 8.
    pub(super) header_bytes: usize,
    /// Whether blocks are compressed with zlib.
    pub(super) zlib: bool,
    /// Data after the XML.
    pub(super) appended: Option<Appended<'a>>,
}

impl<'a> Layout<'a> {
    /// Reads the attributes of the root element.
    ///
    /// # Errors
    /// [`FileError::Unsupported`] for another kind of grid or compressor.
    pub(super) fn new(
        path: &Path,
        root: Node<'_, '_>,
        appended: Option<Appended<'a>>,
    ) -> Result<Self, FileError> {
        let attribute = |name, default| root.attribute(name).unwrap_or(default);
        let kind = if root.has_tag_name("VTKFile") {
            attribute("type", "")
        } else {
            root.tag_name().name()
        };
        let compressor = attribute("compressor", "");
        let header = attribute("header_type", "UInt32");
        let order = attribute("byte_order", "LittleEndian");
        GRID.expect(path, kind)?;
        COMPRESSOR.expect(path, compressor)?;
        HEADER_TYPE.expect(path, header)?;
        BYTE_ORDER.expect(path, order)?;
        Ok(Self {
            big_endian: order == "BigEndian",
            header_bytes: if header == "UInt64" { 8 } else { 4 },
            zlib: !compressor.is_empty(),
            appended,
        })
    }
}

/// An attribute and the values of it that are read here.
struct Property {
    what: &'static str,
    known: &'static [&'static str],
    remedy: &'static str,
}

const GRID: Property = Property {
    what: "the kind of grid",
    known: &["UnstructuredGrid"],
    remedy: "save the points as an unstructured grid",
};
const COMPRESSOR: Property = Property {
    what: "the compressor",
    known: &["", "vtkZLibDataCompressor"],
    remedy: "save the file with zlib or without compression",
};
const HEADER_TYPE: Property = Property {
    what: "header_type",
    known: &["UInt32", "UInt64"],
    remedy: "use UInt32 or UInt64",
};
const BYTE_ORDER: Property = Property {
    what: "byte_order",
    known: &["LittleEndian", "BigEndian"],
    remedy: "use LittleEndian or BigEndian",
};

impl Property {
    fn expect(&self, path: &Path, found: &str) -> Result<(), FileError> {
        if self.known.contains(&found) {
            return Ok(());
        }
        Err(FileError::Unsupported {
            path: path.to_path_buf(),
            what: self.what,
            found: found.to_owned(),
            remedy: self.remedy,
        })
    }
}

/// Separates the XML from the appended data, which as raw bytes are no XML at all.
///
/// # Errors
/// [`FileError::Damaged`] if the data do not end.
pub(super) fn separate<'a>(
    path: &Path,
    bytes: &'a [u8],
) -> Result<(Cow<'a, [u8]>, Option<Appended<'a>>), FileError> {
    let Some(start) = find(bytes, b"<AppendedData") else {
        return Ok((Cow::Borrowed(bytes), None));
    };
    let damaged = |reason: &str| FileError::Damaged {
        path: path.to_path_buf(),
        place: Some(Place::Line(
            1 + bytes[..start].iter().filter(|&&b| b == b'\n').count(),
        )),
        reason: reason.to_owned(),
    };
    let cut_off = || damaged("<AppendedData> is cut off");
    let tag = start + find(&bytes[start..], b">").ok_or_else(cut_off)?;
    if bytes[..tag].ends_with(b"/") {
        return Ok((Cow::Borrowed(bytes), None));
    }
    let mark = tag + find(&bytes[tag..], b"_").ok_or_else(cut_off)?;
    let end = find_last(bytes, b"</AppendedData")
        .filter(|&end| end > mark)
        .ok_or_else(cut_off)?;
    let encoding = attribute(&bytes[start..tag], b"encoding").unwrap_or_default();
    if !matches!(encoding, b"base64" | b"raw") {
        return Err(damaged(
            "the encoding of <AppendedData> is not base64 or raw",
        ));
    }
    let xml = [&bytes[..=tag], &bytes[end..]].concat();
    Ok((
        Cow::Owned(xml),
        Some(Appended {
            base64: encoding == b"base64",
            bytes: &bytes[mark + 1..end],
        }),
    ))
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes
        .windows(wanted.len())
        .position(|window| window == wanted)
}

fn find_last(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes
        .windows(wanted.len())
        .rposition(|window| window == wanted)
}

/// Value of an attribute in the text of a tag; the XML is parsed only after the data are cut out.
fn attribute<'a>(tag: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    let after = &tag[find(tag, name)? + name.len()..];
    let mut parts = after.split(|byte| matches!(byte, b'"' | b'\''));
    parts.next()?;
    parts.next()
}
