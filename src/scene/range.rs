//! Ranges of the keys that tune a computation: what a scene may set, and why no more.
//!
//! A range is stated once, beside its key; the check of the scene, its message, and limits and
//! description in the JSON schema all come from there.

use schemars::Schema;
use schemars::transform::Transform;
use serde_json::{Value, json};

use super::diagnostics::Diagnostic;
use super::quantity::{Dimension, Quantity};
use super::span::{Span, Spanned};
use super::validate::{Report, short};

/// The values that a key may have.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    /// The key.
    pub key: &'static str,
    /// Least value, allowed.
    pub low: f64,
    /// Largest value, allowed.
    pub high: f64,
    /// What goes wrong outside: a clause that can follow a colon.
    pub why: &'static str,
}

impl Range {
    /// Reports a value outside.
    pub(super) fn check<D: Dimension>(&self, number: Quantity<D>, report: &mut Report) {
        self.check_value(number.value(), number.span(), report);
    }

    /// Reports a count outside.
    pub(super) fn check_count(&self, count: Spanned<u64>, report: &mut Report) {
        self.check_value(count.value as f64, count.span, report);
    }

    fn check_value(&self, found: f64, place: Span, report: &mut Report) {
        if (self.low..=self.high).contains(&found) {
            return;
        }
        let [low, high, found] = [self.low, self.high, found].map(short);
        let message = format!(
            "`{}` must lie between {low} and {high}, found {found}",
            self.key
        );
        report.add(Diagnostic::new(message).at(place).help(self.why));
    }

    /// Limits and reason, for the schema of the key.
    fn describe(&self, schema: &mut Schema) {
        let number = |value: f64| match value.fract().abs() < f64::EPSILON && value.abs() < 1e15 {
            true => json!(value as i64),
            false => json!(value),
        };
        let told = schema.get("description").and_then(Value::as_str);
        let [low, high] = [self.low, self.high].map(short);
        let description = format!(
            "{} From {low} to {high}: {}.",
            told.unwrap_or_default(),
            self.why
        );
        schema.insert("description".to_owned(), json!(description.trim_start()));
        schema.insert("minimum".to_owned(), number(self.low));
        schema.insert("maximum".to_owned(), number(self.high));
    }
}

/// Puts the limits of a key and their reason into its schema.
pub(super) fn within(range: &'static Range) -> impl Transform {
    move |schema: &mut Schema| range.describe(schema)
}
