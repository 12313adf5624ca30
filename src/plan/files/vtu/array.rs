//! Numbers of one `<DataArray>`: text, base64 or bytes, plain or compressed with zlib.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::read::ZlibDecoder;
use roxmltree::Node;

use super::document::Layout;

impl Layout<'_> {
    /// The `count` numbers of an array, or what is wrong with it.
    pub(super) fn values(&self, node: Node<'_, '_>, count: usize) -> Result<Vec<f64>, String> {
        let kind = node.attribute("type").unwrap_or("");
        let kind = Kind::named(kind).ok_or_else(|| format!("type `{kind}` is unknown"))?;
        let expected = count
            .checked_mul(kind.bytes())
            .ok_or_else(|| format!("{count} values are impossible"))?;
        let bytes = match node.attribute("format").unwrap_or("ascii") {
            "ascii" => return ascii(&text_of(node), count),
            "binary" => {
                let mut text = text_of(node).into_bytes();
                text.retain(|byte| !byte.is_ascii_whitespace());
                self.payload(Source::Base64(&text), expected)?
            }
            "appended" => self.payload(self.appended_at(node)?, expected)?,
            other => return Err(format!("format `{other}` is unknown")),
        };
        Ok(kind.numbers(&bytes, self.big_endian))
    }

    fn appended_at(&self, node: Node<'_, '_>) -> Result<Source<'_>, String> {
        let appended = self.appended.ok_or("there is no <AppendedData>")?;
        let offset: usize = node
            .attribute("offset")
            .and_then(|text| text.trim().parse().ok())
            .ok_or("the offset is missing or no number")?;
        let rest = appended
            .bytes
            .get(offset..)
            .ok_or("the offset is beyond the data")?;
        Ok(if appended.base64 {
            Source::Base64(rest)
        } else {
            Source::Raw(rest)
        })
    }

    /// Bytes of an array behind its header.
    fn payload(&self, source: Source<'_>, expected: usize) -> Result<Vec<u8>, String> {
        if self.zlib {
            return self.inflate(source, expected);
        }
        let found = self.header(&source, 1)?[0];
        if found != expected {
            return Err(format!("{found} bytes stored, {expected} needed"));
        }
        Ok(source.range(self.header_bytes, expected)?.into_owned())
    }

    /// The header holds the number of blocks, the size of a block, the size of a shorter last
    /// block or zero, and the compressed size of each block.
    fn inflate(&self, source: Source<'_>, expected: usize) -> Result<Vec<u8>, String> {
        let blocks = self.header(&source, 1)?[0];
        let numbers = blocks.checked_add(3).ok_or("the header is impossible")?;
        let sizes = self.header(&source, numbers)?.split_off(3);
        let start = numbers * self.header_bytes;
        let total = sizes
            .iter()
            .try_fold(0_usize, |sum, &size| sum.checked_add(size));
        let stored = source.range(start, total.ok_or("the header is impossible")?)?;
        let mut rest = stored.as_ref();
        let mut bytes = Vec::new();
        for size in sizes {
            let (block, after) = rest.split_at_checked(size).ok_or(CUT_OFF)?;
            // One byte more than allowed tells too long data from complete ones, without filling
            // the memory.
            let room = (expected - bytes.len()) as u64 + 1;
            ZlibDecoder::new(block)
                .take(room)
                .read_to_end(&mut bytes)
                .map_err(|error| format!("a compressed block is broken ({error})"))?;
            if bytes.len() > expected {
                break;
            }
            rest = after;
        }
        if bytes.len() == expected {
            return Ok(bytes);
        }
        let more = if bytes.len() > expected {
            "more than "
        } else {
            ""
        };
        Err(format!(
            "{more}{} bytes stored, {expected} needed",
            bytes.len().min(expected)
        ))
    }

    fn header(&self, source: &Source<'_>, numbers: usize) -> Result<Vec<usize>, String> {
        let length = numbers
            .checked_mul(self.header_bytes)
            .ok_or("the header is impossible")?;
        let bytes = source.range(0, length)?;
        let number = |chunk: &[u8]| {
            let shifted = |value: u64, &byte: &u8| value << 8 | u64::from(byte);
            let value = if self.big_endian {
                chunk.iter().fold(0, shifted)
            } else {
                chunk.iter().rev().fold(0, shifted)
            };
            usize::try_from(value).map_err(|_| "the header is impossible".to_owned())
        };
        bytes.chunks_exact(self.header_bytes).map(number).collect()
    }
}

const CUT_OFF: &str = "the data are cut off";

/// Text of the array itself; notes inside it are elements of their own.
fn text_of(node: Node<'_, '_>) -> String {
    node.children()
        .filter(Node::is_text)
        .filter_map(|child| child.text())
        .collect()
}

fn ascii(text: &str, count: usize) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        word.parse::<f64>()
            .map_err(|_| format!("`{word}` is no number"))
    };
    let values = text
        .split_ascii_whitespace()
        .map(number)
        .collect::<Result<Vec<_>, _>>()?;
    match values.len() {
        found if found == count => Ok(values),
        found => Err(format!("{found} values stored, {count} needed")),
    }
}

/// Bytes of an array and of what follows it.
#[derive(Debug, Clone, Copy)]
enum Source<'a> {
    Raw(&'a [u8]),
    /// Base64 texts one after another, each with its own padding, without blanks.
    Base64(&'a [u8]),
}

impl<'a> Source<'a> {
    fn range(&self, start: usize, length: usize) -> Result<Cow<'a, [u8]>, String> {
        let end = start.checked_add(length).ok_or(CUT_OFF)?;
        match self {
            Self::Raw(bytes) => Ok(bytes.get(start..end).ok_or(CUT_OFF)?.into()),
            Self::Base64(text) => {
                let mut bytes = decode(text, end)?;
                bytes.truncate(end);
                Ok(bytes.split_off(start).into())
            }
        }
    }
}

/// Decodes at least `wanted` bytes. Header and data may be separate texts with padding between.
fn decode(text: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut rest = text;
    while bytes.len() < wanted {
        let quads = (wanted - bytes.len()).div_ceil(3).min(rest.len() / 4);
        let mut length = quads * 4;
        if let Some(padding) = rest[..length].iter().position(|&byte| byte == b'=') {
            length = (padding / 4 + 1) * 4;
        }
        if length == 0 {
            return Err(CUT_OFF.to_owned());
        }
        let (segment, after) = rest.split_at(length);
        BASE64
            .decode_vec(segment, &mut bytes)
            .map_err(|error| format!("the base64 text is broken ({error})"))?;
        rest = after;
    }
    Ok(bytes)
}

/// Number type of an array.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float32,
    Float64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::Int8,
            "UInt8" => Self::UInt8,
            "Int16" => Self::Int16,
            "UInt16" => Self::UInt16,
            "Int32" => Self::Int32,
            "UInt32" => Self::UInt32,
            "Int64" => Self::Int64,
            "UInt64" => Self::UInt64,
            "Float32" => Self::Float32,
            "Float64" => Self::Float64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Int8 | Self::UInt8 => 1,
            Self::Int16 | Self::UInt16 => 2,
            Self::Int32 | Self::UInt32 | Self::Float32 => 4,
            Self::Int64 | Self::UInt64 | Self::Float64 => 8,
        }
    }

    fn numbers(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        match self {
            Self::Int8 => each(bytes, big_endian, |b| f64::from(i8::from_le_bytes(b))),
            Self::UInt8 => each(bytes, big_endian, |b| f64::from(u8::from_le_bytes(b))),
            Self::Int16 => each(bytes, big_endian, |b| f64::from(i16::from_le_bytes(b))),
            Self::UInt16 => each(bytes, big_endian, |b| f64::from(u16::from_le_bytes(b))),
            Self::Int32 => each(bytes, big_endian, |b| f64::from(i32::from_le_bytes(b))),
            Self::UInt32 => each(bytes, big_endian, |b| f64::from(u32::from_le_bytes(b))),
            Self::Int64 => each(bytes, big_endian, |b| i64::from_le_bytes(b) as f64),
            Self::UInt64 => each(bytes, big_endian, |b| u64::from_le_bytes(b) as f64),
            Self::Float32 => each(bytes, big_endian, |b| f64::from(f32::from_le_bytes(b))),
            Self::Float64 => each(bytes, big_endian, f64::from_le_bytes),
        }
    }
}

fn each<const N: usize>(bytes: &[u8], big_endian: bool, number: fn([u8; N]) -> f64) -> Vec<f64> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks
        .iter()
        .map(|&chunk| {
            let mut chunk = chunk;
            if big_endian {
                chunk.reverse();
            }
            number(chunk)
        })
        .collect()
}
