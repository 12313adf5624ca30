//! Reads the value tree through serde, keeping what serde's own formats lose: the place of every
//! fault, the way to it, and the words that would have been right.
//!
//! Enums are read in three ways, so that types can be written with plain derives:
//! - a text names a variant (`influence = "inverse"`);
//! - a table names it by `type` (`{ type = "box", … }`), the other keys are its content;
//! - if the enum's name ends in [`BY_KEY`], a table belongs to the variant that one of its keys
//!   is named after (`{ pressure = … }`), a bare value to the variant `value`, a list to `list`.

mod access;
mod error;

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, IntoDeserializer, Unexpected, Visitor};

use self::access::{ListReader, SpannedReader, TableReader, VariantReader};
use self::error::expected_words;
pub(super) use self::error::{HELP, Missing, ReadError};
use super::diagnostics::Diagnostic;
use super::span::{SPANNED, Span};
use super::suggest::one_of;
use super::tree::{Item, Node, Step, Value};

/// Ending of the serde name of enums whose variant is told by the keys present.
const BY_KEY: &str = " by key";
const TYPE: &str = "type";

/// Reads a value of type `T`; the first fault ends it.
pub(super) fn read<'a, T: Deserialize<'a>>(node: &'a Node) -> Result<T, ReadError> {
    T::deserialize(Reader::new(node)).map_err(|error| error.placed(node.span))
}

/// A value to be read; `without_type` leaves the tag of a tagged table out.
#[derive(Clone, Copy)]
struct Reader<'a> {
    node: &'a Node,
    without_type: bool,
}

impl<'a> Reader<'a> {
    fn new(node: &'a Node) -> Self {
        Self {
            node,
            without_type: false,
        }
    }

    fn items(self) -> impl Iterator<Item = &'a Item> {
        let table = self.node.table();
        table
            .into_iter()
            .flat_map(|table| &table.entries)
            .filter(move |item| !item.node.faulty && (!self.without_type || item.key != TYPE))
    }

    fn visit_table<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let items: Vec<&Item> = self.items().collect();
        visitor.visit_map(TableReader {
            items: items.into_iter(),
            current: None,
        })
    }

    fn visit_list<V: Visitor<'a>>(
        self,
        list: &'a [Node],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let expected = expected_words(&visitor_words(&visitor)).to_owned();
        let mut items = ListReader { list, next: 0 };
        let value = visitor.visit_seq(&mut items)?;
        if items.next_sound().is_some() {
            let length = list.len();
            return Err(ReadError::custom(format!(
                "expected {expected}, found {length} of them"
            )));
        }
        Ok(value)
    }

    fn visit_single<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.node.value {
            Value::Text(text) => visitor.visit_borrowed_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(value) => visitor.visit_bool(*value),
            _ => Err(invalid(self.node, &visitor_words(&visitor))),
        }
    }

    /// The variant's name, the place of what names it, and the content.
    fn variant(
        self,
        name: &str,
        variants: &'static [&'static str],
    ) -> Result<(&'a str, Span, Self), ReadError> {
        let by_key = name.ends_with(BY_KEY);
        match &self.node.value {
            Value::Table(_) if by_key && !keys(variants).is_empty() => self.keyed_variant(variants),
            Value::Table(_) if !by_key => self.tagged_variant(variants),
            Value::List(_) if variants.contains(&"list") => Ok(("list", self.node.span, self)),
            Value::Text(_) | Value::Integer(_) | Value::Float(_) if variants.contains(&"value") => {
                Ok(("value", self.node.span, self))
            }
            Value::Text(text) if !by_key => Ok((text, self.node.span, self)),
            _ if by_key => Err(invalid(self.node, &by_key_words(variants))),
            _ => Err(invalid(self.node, &one_of(variants))),
        }
    }

    fn tagged_variant(
        self,
        variants: &'static [&'static str],
    ) -> Result<(&'a str, Span, Self), ReadError> {
        let Some(tag) = self.items().find(|item| item.key == TYPE) else {
            let error = ReadError::missing_field(TYPE);
            let help = format!("expected {}", one_of(variants));
            return Err(ReadError {
                diagnostic: Box::new(error.diagnostic.help(help)),
                ..error
            });
        };
        let Value::Text(text) = &tag.node.value else {
            let error = invalid(&tag.node, &one_of(variants));
            return Err(error
                .placed(tag.node.span)
                .below(Step::Key(TYPE.to_owned())));
        };
        Ok((
            text,
            tag.node.span,
            Self {
                without_type: true,
                ..self
            },
        ))
    }

    fn keyed_variant(
        self,
        variants: &'static [&'static str],
    ) -> Result<(&'a str, Span, Self), ReadError> {
        let keys = keys(variants);
        let mut found = self
            .items()
            .filter(|item| keys.contains(&item.key.as_str()));
        match (found.next(), found.next()) {
            (Some(only), None) => Ok((&only.key, only.key_span, self)),
            (Some(first), Some(second)) => Err(ReadError::new(
                Diagnostic::new(format!("`{}` excludes `{}`", first.key, second.key))
                    .at(second.key_span)
                    .also(first.key_span, "given here")
                    .help("keep one of them"),
            )),
            _ => Err(ReadError {
                missing: Some(Missing::AnyKey),
                ..ReadError::new(Diagnostic::new(format!("{} is missing", one_of(&keys))))
            }),
        }
    }
}

/// The variants that are told by a key.
fn keys(variants: &[&'static str]) -> Vec<&'static str> {
    variants
        .iter()
        .copied()
        .filter(|name| !["value", "list"].contains(name))
        .collect()
}

fn by_key_words(variants: &[&'static str]) -> String {
    let mut words = Vec::new();
    if variants.contains(&"value") {
        words.push("a value".to_owned());
    }
    if variants.contains(&"list") {
        words.push("a list".to_owned());
    }
    if !keys(variants).is_empty() {
        words.push(format!("a table with {}", one_of(&keys(variants))));
    }
    words.join(" or ")
}

/// What a visitor says it expects.
fn visitor_words<'de, V: Visitor<'de>>(visitor: &V) -> String {
    struct Words<'v, V>(&'v V);
    impl<'de, V: Visitor<'de>> fmt::Display for Words<'_, V> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.0.expecting(f)
        }
    }
    Words(visitor).to_string()
}

fn invalid(node: &Node, expected: &str) -> ReadError {
    let found = match &node.value {
        Value::Text(text) => Unexpected::Str(text),
        Value::Integer(number) => Unexpected::Signed(*number),
        Value::Float(number) => Unexpected::Float(*number),
        Value::Boolean(value) => Unexpected::Bool(*value),
        Value::Date(_) => Unexpected::Other("a date"),
        Value::List(_) => Unexpected::Seq,
        Value::Table(_) => Unexpected::Map,
    };
    ReadError::invalid_type(found, &expected)
}

impl<'a> Deserializer<'a> for Reader<'a> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.node.value {
            Value::List(list) => self.visit_list(list, visitor),
            Value::Table(_) => self.visit_table(visitor),
            _ => self.visit_single(visitor),
        }
    }

    fn deserialize_option<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_some(self)
    }

    // What asks for a table, a list or a single value is not compiled for the others.
    fn deserialize_struct<V: Visitor<'a>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.deserialize_map(visitor)
    }

    fn deserialize_map<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.node.value {
            Value::Table(_) => self.visit_table(visitor),
            _ => Err(invalid(self.node, &visitor_words(&visitor))),
        }
    }

    fn deserialize_tuple<V: Visitor<'a>>(
        self,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_seq<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.node.value {
            Value::List(list) => self.visit_list(list, visitor),
            _ => Err(invalid(self.node, &visitor_words(&visitor))),
        }
    }

    fn deserialize_bool<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        self.visit_single(visitor)
    }

    fn deserialize_f64<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        self.visit_single(visitor)
    }

    fn deserialize_u64<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        self.visit_single(visitor)
    }

    fn deserialize_string<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        self.visit_single(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'a>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        if name == SPANNED {
            return visitor.visit_seq(SpannedReader {
                reader: self,
                part: 0,
            });
        }
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'a>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let (variant, place, content) = self.variant(name, variants)?;
        visitor.visit_enum(VariantReader {
            variant,
            place,
            content,
        })
    }

    serde::forward_to_deserialize_any! {
        <W: Visitor<'a>>
        i8 i16 i32 i64 i128 u8 u16 u32 u128 f32 char str bytes byte_buf unit unit_struct tuple_struct
        identifier ignored_any
    }
}

impl<'a> IntoDeserializer<'a, ReadError> for Reader<'a> {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}
