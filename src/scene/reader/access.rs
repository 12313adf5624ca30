//! The parts serde walks through: keys and values of tables, items of lists, places, variants.

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer, MapAccess, SeqAccess,
    VariantAccess, Visitor,
};

use super::{ReadError, Reader};
use crate::scene::span::{SPANNED, Span};
use crate::scene::tree::{Item, Node, Step};

pub(super) struct TableReader<'a> {
    pub items: std::vec::IntoIter<&'a Item>,
    pub current: Option<&'a Item>,
}

impl<'a> MapAccess<'a> for TableReader<'a> {
    type Error = ReadError;

    fn next_key_seed<K: DeserializeSeed<'a>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, ReadError> {
        self.current = self.items.next();
        let Some(item) = self.current else {
            return Ok(None);
        };
        let key = KeyReader {
            key: &item.key,
            span: item.key_span,
        };
        seed.deserialize(key).map(Some).map_err(|error| {
            error
                .placed(item.key_span)
                .below(Step::Key(item.key.clone()))
        })
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, ReadError> {
        let item = self
            .current
            .take()
            .ok_or_else(|| ReadError::custom("a value without key"))?;
        seed.deserialize(Reader::new(&item.node)).map_err(|error| {
            error
                .placed(item.node.span)
                .below(Step::Key(item.key.clone()))
        })
    }
}

/// A key, with its place for those who ask.
struct KeyReader<'a> {
    key: &'a str,
    span: Span,
}

impl<'a> Deserializer<'a> for KeyReader<'a> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_borrowed_str(self.key)
    }

    fn deserialize_newtype_struct<V: Visitor<'a>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        if name == SPANNED {
            let key = StrDeserializer::new(self.key);
            return visitor.visit_seq(SpannedKey {
                key: Some(key),
                span: self.span,
                part: 0,
            });
        }
        visitor.visit_newtype_struct(self)
    }

    serde::forward_to_deserialize_any! {
        <W: Visitor<'a>>
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string option enum
        bytes byte_buf unit unit_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

pub(super) struct ListReader<'a> {
    pub list: &'a [Node],
    pub next: usize,
}

impl<'a> ListReader<'a> {
    pub(super) fn next_sound(&mut self) -> Option<(usize, &'a Node)> {
        let (index, node) = self
            .list
            .iter()
            .enumerate()
            .skip(self.next)
            .find(|(_, node)| !node.faulty)?;
        self.next = index + 1;
        Some((index, node))
    }
}

impl<'a> SeqAccess<'a> for &mut ListReader<'a> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'a>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, ReadError> {
        let Some((index, node)) = self.next_sound() else {
            return Ok(None);
        };
        let value = seed.deserialize(Reader::new(node));
        value
            .map(Some)
            .map_err(|error| error.placed(node.span).below(Step::Index(index)))
    }
}

pub(super) struct SpannedReader<'a> {
    pub reader: Reader<'a>,
    pub part: u8,
}

impl<'a> SeqAccess<'a> for SpannedReader<'a> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'a>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, ReadError> {
        self.part += 1;
        let span = self.reader.node.span;
        match self.part {
            1 => seed.deserialize(span.start.into_deserializer()).map(Some),
            2 => seed.deserialize(span.end.into_deserializer()).map(Some),
            _ => seed.deserialize(self.reader).map(Some),
        }
    }
}

struct SpannedKey<'a> {
    key: Option<StrDeserializer<'a, ReadError>>,
    span: Span,
    part: u8,
}

impl<'a> SeqAccess<'a> for SpannedKey<'a> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'a>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, ReadError> {
        self.part += 1;
        match self.part {
            1 => seed
                .deserialize(self.span.start.into_deserializer())
                .map(Some),
            2 => seed
                .deserialize(self.span.end.into_deserializer())
                .map(Some),
            _ => self.key.take().map(|key| seed.deserialize(key)).transpose(),
        }
    }
}

pub(super) struct VariantReader<'a> {
    pub variant: &'a str,
    pub place: Span,
    pub content: Reader<'a>,
}

impl<'a> EnumAccess<'a> for VariantReader<'a> {
    type Error = ReadError;
    type Variant = Reader<'a>;

    fn variant_seed<V: DeserializeSeed<'a>>(
        self,
        seed: V,
    ) -> Result<(V::Value, Reader<'a>), ReadError> {
        let name: StrDeserializer<'_, ReadError> = self.variant.into_deserializer();
        let value = seed
            .deserialize(name)
            .map_err(|error| error.placed(self.place))?;
        Ok((value, self.content))
    }
}

impl<'a> VariantAccess<'a> for Reader<'a> {
    type Error = ReadError;

    fn unit_variant(self) -> Result<(), ReadError> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'a>>(self, seed: T) -> Result<T::Value, ReadError> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'a>>(self, _: usize, visitor: V) -> Result<V::Value, ReadError> {
        self.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'a>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.deserialize_any(visitor)
    }
}
