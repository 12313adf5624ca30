//! What reading reports: the fault, its place, and the way to it.

use std::fmt;

use serde::de::{Error, Expected, Unexpected};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::schema::places_of;
use crate::scene::span::Span;
use crate::scene::suggest::{closest, one_of};
use crate::scene::tree::Step;

/// A fault, and the way to it from the leaf up.
#[derive(Debug)]
pub(in crate::scene) struct ReadError {
    pub diagnostic: Box<Diagnostic>,
    /// Steps from the fault up to the root.
    pub upward: Vec<Step>,
    /// A key that should have been there.
    pub missing: Option<Missing>,
}

/// What was not found.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene) enum Missing {
    /// This key.
    Key(&'static str),
    /// Any of the keys that tell a variant.
    AnyKey,
}

impl ReadError {
    pub(super) fn new(diagnostic: Diagnostic) -> Self {
        Self {
            diagnostic: Box::new(diagnostic),
            upward: Vec::new(),
            missing: None,
        }
    }

    /// Sets the place unless a deeper one is known.
    pub(super) fn placed(mut self, span: Span) -> Self {
        if self.diagnostic.place.is_none() {
            *self.diagnostic = self.diagnostic.at(span);
        }
        self
    }

    pub(super) fn below(mut self, step: Step) -> Self {
        self.upward.push(step);
        self
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.diagnostic.message)
    }
}

impl std::error::Error for ReadError {}

/// Parts the message of a custom error from its remedy.
pub(in crate::scene) const HELP: &str = "\nhelp: ";

impl Error for ReadError {
    fn custom<T: fmt::Display>(text: T) -> Self {
        let text = text.to_string();
        Self::new(match text.split_once(HELP) {
            Some((message, help)) => Diagnostic::new(message).help(help),
            None => Diagnostic::new(text),
        })
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::new(Diagnostic::new(format!(
            "expected {}, found {}",
            expected_words(&expected.to_string()),
            found_words(found)
        )))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        let words = expected.to_string();
        let expected = expected_words(&words);
        Self::new(Diagnostic::new(format!(
            "expected {expected}, found {length} of them"
        )))
    }

    fn unknown_variant(found: &str, options: &'static [&'static str]) -> Self {
        Self::new(unknown(
            &format!("`{found}` is not known here"),
            found,
            options,
        ))
    }

    fn unknown_field(found: &str, options: &'static [&'static str]) -> Self {
        let message = format!("unknown key `{found}`");
        let near = closest(found, options.iter().copied()).is_some();
        let places = match near {
            true => Vec::new(),
            false => places_of(found),
        };
        let places: Vec<&str> = places.iter().map(String::as_str).collect();
        Self::new(match places.len() {
            1..=MANY => Diagnostic::new(message).help(format!("it belongs to {}", one_of(&places))),
            _ => unknown(&message, found, options),
        })
    }

    fn missing_field(field: &'static str) -> Self {
        let missing = Some(Missing::Key(field));
        Self {
            missing,
            ..Self::new(Diagnostic::new(format!("`{field}` is missing")))
        }
    }

    fn duplicate_field(field: &'static str) -> Self {
        Self::new(Diagnostic::new(format!("`{field}` is given twice")))
    }
}

/// Places of a key that are worth a list.
const MANY: usize = 3;

fn unknown(message: &str, found: &str, options: &[&str]) -> Diagnostic {
    let diagnostic = Diagnostic::new(message);
    match closest(found, options.iter().copied()) {
        Some(option) => diagnostic.help(format!("did you mean `{option}`?")),
        None if options.is_empty() => diagnostic,
        None => diagnostic.help(format!("expected {}", one_of(options))),
    }
}

pub(super) fn expected_words(serde_words: &str) -> &str {
    match serde_words {
        "a string" => "a text",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        "a map" => "a table",
        "u64" | "u32" | "u16" | "u8" | "usize" => "a whole number, not negative",
        "i64" | "i32" => "a whole number",
        "f64" => "a number",
        words if words.starts_with("struct ") => "a table",
        words if words.starts_with("an array of length 2") => "two values",
        words => words,
    }
}

fn found_words(found: Unexpected<'_>) -> String {
    match found {
        Unexpected::Str(text) => format!("the text \"{text}\""),
        Unexpected::Signed(number) => format!("{number}"),
        Unexpected::Unsigned(number) => format!("{number}"),
        Unexpected::Float(number) => format!("{number}"),
        Unexpected::Bool(value) => format!("{value}"),
        Unexpected::Map => "a table".to_owned(),
        Unexpected::Seq => "a list".to_owned(),
        other => other.to_string(),
    }
}
