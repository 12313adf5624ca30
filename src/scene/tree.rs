//! The scene as a tree of values that know their places: what the TOML parser found, with the
//! `--set` texts merged in.

use std::ops::Range;

use serde::ser::{Serialize, SerializeMap, Serializer};
use toml::de::{DeTable, DeValue};
use toml::value::Datetime;

use super::diagnostics::Diagnostic;
use super::span::Span;

/// A value and its place.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub value: Value,
    pub span: Span,
    /// Set once a fault in it has been reported: it is then passed over.
    pub faulty: bool,
}

/// The kinds of TOML values.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Text(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Date(Datetime),
    List(Vec<Node>),
    Table(Table),
}

/// A table in the order of the file.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    pub entries: Vec<Item>,
}

/// One key of a table with its value.
#[derive(Debug, Clone)]
pub(super) struct Item {
    pub key: String,
    pub key_span: Span,
    pub node: Node,
}

/// One step on the way from the root to a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    Index(usize),
}

impl Node {
    pub(super) fn new(value: Value, span: Span) -> Self {
        Self {
            value,
            span,
            faulty: false,
        }
    }

    pub(super) fn table(&self) -> Option<&Table> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// Puts a text before all entries of a table; tells whether this is one.
    pub(super) fn insert_first(&mut self, key: &str, text: &str) -> bool {
        let Value::Table(table) = &mut self.value else {
            return false;
        };
        let item = Item {
            key: key.to_owned(),
            key_span: Span::NOWHERE,
            node: Node::new(Value::Text(text.to_owned()), Span::NOWHERE),
        };
        table.entries.insert(0, item);
        true
    }

    /// Visits the texts that are paths of files: `path` of the geometry, `from` of a start, and `file` anywhere.
    pub(super) fn each_path(&mut self, visit: &mut impl FnMut(&mut String)) {
        self.each_path_in("", visit);
    }

    fn each_path_in(&mut self, parent: &str, visit: &mut impl FnMut(&mut String)) {
        match &mut self.value {
            Value::Table(table) => {
                for Item { key, node, .. } in &mut table.entries {
                    let is_path = matches!(
                        (parent, key.as_str()),
                        ("geometry", "path") | ("start", "from") | (_, "file")
                    );
                    match &mut node.value {
                        Value::Text(text) if is_path => visit(text),
                        _ => node.each_path_in(key, visit),
                    }
                }
            }
            Value::List(list) => {
                list.iter_mut()
                    .for_each(|node| node.each_path_in(parent, visit));
            }
            _ => {}
        }
    }

    /// Passes the value at the end of the path over from now on.
    pub(super) fn mark_faulty(&mut self, path: &[Step]) {
        let Some((step, rest)) = path.split_first() else {
            self.faulty = true;
            return;
        };
        let child = match (step, &mut self.value) {
            (Step::Key(key), Value::Table(table)) => table.get_mut(key).map(|item| &mut item.node),
            (Step::Index(index), Value::List(list)) => list.get_mut(*index),
            _ => None,
        };
        match child {
            Some(child) => child.mark_faulty(rest),
            None => self.faulty = true,
        }
    }

    /// The value at the end of a path.
    pub(super) fn descend(&self, path: &[Step]) -> Option<&Self> {
        path.iter()
            .try_fold(self, |node, step| match (step, &node.value) {
                (Step::Key(key), Value::Table(table)) => table.get(key).map(|item| &item.node),
                (Step::Index(index), Value::List(list)) => list.get(*index),
                _ => None,
            })
    }
}

impl Table {
    pub(super) fn get(&self, key: &str) -> Option<&Item> {
        self.entries.iter().find(|item| item.key == key)
    }

    pub(super) fn get_mut(&mut self, key: &str) -> Option<&mut Item> {
        self.entries.iter_mut().find(|item| item.key == key)
    }
}

/// Parses a TOML text; every syntax error is reported.
pub(super) fn parse(text: &str, offset: usize) -> Result<Node, Vec<Diagnostic>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        return Err(errors
            .iter()
            .map(|error| syntax_error(error, text, offset))
            .collect());
    }
    let mut faults = Vec::new();
    let span = Span::shifted(table.span(), offset);
    let table = convert_table(table.into_inner(), offset, &mut faults);
    if faults.is_empty() {
        Ok(Node::new(Value::Table(table), span))
    } else {
        Err(faults)
    }
}

fn syntax_error(error: &toml::de::Error, text: &str, offset: usize) -> Diagnostic {
    let message = error.message().replace('\n', "; ");
    let diagnostic = Diagnostic::new(message);
    let Some(range) = error.span() else {
        return diagnostic;
    };
    let range = visible(text, range);
    let place = Span::shifted(range.clone(), offset);
    let excerpt = text.get(range.clone()).unwrap_or_default();
    match error.message() {
        m if m.starts_with("string values must be quoted") && range.is_empty() => {
            Diagnostic::new("a value is missing").at(place)
        }
        m if m.starts_with("string values must be quoted") => {
            Diagnostic::new("a text must stand in quotes")
                .at(place)
                .help(format!("write \"{excerpt}\""))
        }
        "duplicate key" => Diagnostic::new(format!("duplicate key `{excerpt}`"))
            .at(place)
            .help("keep one of them"),
        m => match m.split_once(" string, expected ") {
            Some((_, quote)) => Diagnostic::new("a text is not closed")
                .at(place)
                .help(format!("end it with {quote}")),
            None => diagnostic.at(place),
        },
    }
}

/// Widens an empty or broken range to whole characters inside the text.
fn visible(text: &str, range: Range<usize>) -> Range<usize> {
    let floor = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = floor(range.start);
    start..floor(range.end).max(start)
}

fn convert_table(table: DeTable<'_>, offset: usize, faults: &mut Vec<Diagnostic>) -> Table {
    let mut entries: Vec<Item> = table
        .into_iter()
        .map(|(key, value)| {
            let span = Span::shifted(value.span(), offset);
            Item {
                key_span: Span::shifted(key.span(), offset),
                key: key.into_inner().into_owned(),
                node: Node::new(convert(value.into_inner(), span, offset, faults), span),
            }
        })
        .collect();
    entries.sort_unstable_by_key(|item| item.key_span.start);
    Table { entries }
}

fn convert(value: DeValue<'_>, span: Span, offset: usize, faults: &mut Vec<Diagnostic>) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Boolean(value) => Value::Boolean(value),
        DeValue::Datetime(value) => Value::Date(value),
        DeValue::Integer(digits) => {
            let number = i64::from_str_radix(digits.as_str(), digits.radix());
            Value::Integer(number.unwrap_or_else(|_| {
                faults.push(Diagnostic::new("the whole number is too large").at(span));
                0
            }))
        }
        DeValue::Float(digits) => Value::Float(digits.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Array(list) => Value::List(
            list.into_iter()
                .map(|item| {
                    let span = Span::shifted(item.span(), offset);
                    Node::new(convert(item.into_inner(), span, offset, faults), span)
                })
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(convert_table(table, offset, faults)),
    }
}

impl Serialize for Node {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.value {
            Value::Text(text) => serializer.serialize_str(text),
            Value::Integer(value) => serializer.serialize_i64(*value),
            Value::Float(value) => serializer.serialize_f64(*value),
            Value::Boolean(value) => serializer.serialize_bool(*value),
            Value::Date(value) => value.serialize(serializer),
            Value::List(list) => serializer.collect_seq(list),
            Value::Table(table) => {
                let mut map = serializer.serialize_map(Some(table.entries.len()))?;
                for item in &table.entries {
                    map.serialize_entry(&item.key, &item.node)?;
                }
                map.end()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_keep_the_order_of_the_file() {
        let root = parse("z = 1\na = 2\n[m.b]\nx = 1\n[m.a]\n[c]\n", 0).unwrap();
        let keys = |table: &Table| {
            table
                .entries
                .iter()
                .map(|i| i.key.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(keys(root.table().unwrap()), ["z", "a", "m", "c"]);
        let m = root.descend(&[Step::Key("m".to_owned())]).unwrap();
        assert_eq!(keys(m.table().unwrap()), ["b", "a"]);
    }

    #[test]
    fn all_syntax_errors_are_reported_with_their_places() {
        let text = "a = 3 m\nb = \nc = 1\nc = 2\n";
        let errors = parse(text, 100).unwrap_err();
        assert!(errors.len() >= 3, "{errors:?}");
        let lines: Vec<usize> = errors
            .iter()
            .map(|e| text[..e.place.unwrap().start - 100].matches('\n').count())
            .collect();
        assert!(
            lines.contains(&0) && lines.contains(&1) && lines.contains(&3),
            "{errors:?}"
        );
    }

    #[test]
    fn a_number_beyond_64_bits_is_refused() {
        let errors = parse("a = 99999999999999999999\n", 0).unwrap_err();
        assert_eq!(errors[0].message, "the whole number is too large");
    }

    #[test]
    fn a_faulty_value_is_marked_at_the_end_of_its_path() {
        let mut root = parse("a = [1, {b = 2}]", 0).unwrap();
        let path = [Step::Key("a".into()), Step::Index(1), Step::Key("b".into())];
        root.mark_faulty(&path);
        assert!(root.descend(&path).unwrap().faulty);
        assert!(!root.descend(&path[..2]).unwrap().faulty);
    }
}
