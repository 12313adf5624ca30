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
        let unsupported = |what, found: &str, remedy| FileError::Unsupported {
            path: path.to_path_buf(),
            what,
            found: found.to_owned(),
            remedy,
        };
        if !root.has_tag_name("VTKFile") {
            let name = root.tag_name().name();
            return Err(unsupported("the root element", name, "give a VTK XML file"));
        }
        let attribute = |name, default| root.attribute(name).unwrap_or(default);
        let kind = attribute("type", "");
        if kind != "UnstructuredGrid" {
            let remedy = "save the points as an unstructured grid";
            return Err(unsupported("the kind of grid", kind, remedy));
        }
        let compressor = attribute("compressor", "");
        if !matches!(compressor, "" | "vtkZLibDataCompressor") {
            let remedy = "save the file with zlib or without compression";
            return Err(unsupported("the compressor", compressor, remedy));
        }
        let header_bytes = match attribute("header_type", "UInt32") {
            "UInt32" => 4,
            "UInt64" => 8,
            other => return Err(unsupported("header_type", other, "use UInt32 or UInt64")),
        };
        let big_endian = match attribute("byte_order", "LittleEndian") {
            "LittleEndian" => false,
            "BigEndian" => true,
            other => {
                let remedy = "use LittleEndian or BigEndian";
                return Err(unsupported("byte_order", other, remedy));
            }
        };
        Ok(Self {
            big_endian,
            header_bytes,
            zlib: !compressor.is_empty(),
            appended,
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
    let end = bytes
        .windows(b"</AppendedData".len())
        .rposition(|window| window == b"</AppendedData")
        .filter(|&end| end > mark)
        .ok_or_else(cut_off)?;
    let base64 = match attribute(&bytes[start..tag], b"encoding") {
        Some(b"base64") => true,
        None | Some(b"raw") => false,
        Some(_) => {
            return Err(damaged(
                "the encoding of <AppendedData> is not base64 or raw",
            ));
        }
    };
    let xml = [&bytes[..=tag], &bytes[end..]].concat();
    Ok((
        Cow::Owned(xml),
        Some(Appended {
            base64,
            bytes: &bytes[mark + 1..end],
        }),
    ))
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes
        .windows(wanted.len())
        .position(|window| window == wanted)
}

/// Value of an attribute in the text of a tag; the XML is parsed only after the data are cut out.
fn attribute<'a>(tag: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    let after = &tag[find(tag, name)? + name.len()..];
    let mut parts = after.split(|byte| matches!(byte, b'"' | b'\''));
    parts.next()?;
    parts.next()
}
