//! The texts a scene is made of: the file, and one text for each `--set`.

use std::ops::Range;

use super::span::Span;

/// One text and where its bytes begin in the common count.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Source {
    name: String,
    text: String,
    offset: usize,
    /// Whether it stood on the command line.
    is_typed: bool,
}

/// The scene file and the `--set` texts, laid end to end so that one [`Span`] finds its text.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sources {
    list: Vec<Source>,
}

impl Sources {
    /// A scene file of that name (as shown in messages) and text.
    pub fn new(name: &str, text: &str) -> Self {
        let mut sources = Self::default();
        sources.add(name, text);
        sources
    }

    /// Appends the text of a file; returns the offset its spans are to be shifted by.
    pub(super) fn add(&mut self, name: &str, text: &str) -> usize {
        self.push(name, text, false)
    }

    /// Appends a text of the command line, likewise.
    pub(super) fn add_typed(&mut self, name: &str, text: &str) -> usize {
        self.push(name, text, true)
    }

    fn push(&mut self, name: &str, text: &str, is_typed: bool) -> usize {
        // One byte is left between two texts, so that a span at the very end of one of them
        // cannot be taken for the beginning of the next.
        let offset = self
            .list
            .last()
            .map_or(0, |last| last.offset + last.text.len() + 1);
        self.list.push(Source {
            name: name.to_owned(),
            text: text.to_owned(),
            offset,
            is_typed,
        });
        offset
    }

    /// Name of the scene file, as it was given.
    pub fn name(&self) -> &str {
        self.list.first().map_or("", |source| &source.name)
    }

    /// Whether a span lies in a text of the command line rather than in a file.
    pub fn is_typed(&self, span: Span) -> bool {
        let mut list = self.list.iter().rev();
        let source = list.find(|source| source.offset <= span.start);
        source.is_some_and(|source| source.is_typed)
    }

    /// The text in which a span lies: its name, the whole text, and the range inside it.
    pub fn locate(&self, span: Span) -> Option<(&str, &str, Range<usize>)> {
        let source = self
            .list
            .iter()
            .rev()
            .find(|source| source.offset <= span.start)?;
        let range = span.start - source.offset..span.end.checked_sub(source.offset)?;
        source.text.get(range.clone())?;
        Some((&source.name, &source.text, range))
    }

    /// The words a span underlines.
    pub fn excerpt(&self, span: Span) -> Option<&str> {
        let (_, text, range) = self.locate(span)?;
        text.get(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_finds_the_text_it_belongs_to() {
        let mut sources = Sources::new("a.toml", "abc");
        assert_eq!(sources.add("--set #1", "xyz"), 4);
        assert_eq!(sources.excerpt(Span { start: 1, end: 3 }), Some("bc"));
        assert_eq!(sources.excerpt(Span { start: 5, end: 7 }), Some("yz"));
        let (name, _, range) = sources.locate(Span { start: 4, end: 7 }).unwrap();
        assert_eq!((name, range), ("--set #1", 0..3));
        assert_eq!(
            sources.locate(Span { start: 3, end: 3 }).unwrap().0,
            "a.toml"
        );
    }

    #[test]
    fn a_span_outside_all_texts_finds_nothing() {
        let sources = Sources::new("a.toml", "abc");
        assert_eq!(sources.excerpt(Span::NOWHERE), None);
        assert_eq!(sources.excerpt(Span { start: 2, end: 9 }), None);
    }
}
