//! Reads on after a fault, so that one run shows all of them.
//!
//! Serde stops at the first fault. Here the faulty value is then marked, passed over, and the
//! reading repeated; a value that must not be absent takes its table with it. What is left can
//! still be checked.

use std::collections::BTreeSet;

use serde::de::DeserializeOwned;

use super::diagnostics::Diagnostic;
use super::reader::{Missing, ReadError, read};
use super::suggest::closest;
use super::tree::{Node, Step, Value};

/// What could be read, and what could not.
pub(super) struct Reading<T> {
    /// The value without its faulty parts, or `None` if nothing is left of it.
    pub value: Option<T>,
    /// All faults.
    pub faults: Vec<Diagnostic>,
    /// Keys of the root in which there was a fault.
    pub faulty: BTreeSet<String>,
}

/// Faults after which reading ends: each takes a reading of the whole tree, and nobody reads more. One
/// less than are shown, so that the end of reading is told too.
pub(super) const MOST_FAULTS: usize = 99;

/// Reads as much of the tree as can be read, up to [`MOST_FAULTS`] faults.
pub(super) fn read_all<T: DeserializeOwned>(root: &mut Node) -> Reading<T> {
    let mut reading = Reading {
        value: None,
        faults: Vec::new(),
        faulty: BTreeSet::new(),
    };
    loop {
        let error = match read(root) {
            Ok(value) => {
                reading.value = Some(value);
                return reading;
            }
            Err(error) => error,
        };
        let path: Vec<Step> = error.upward.iter().rev().cloned().collect();
        if let Some(Step::Key(key)) = path.first() {
            reading.faulty.insert(key.clone());
        }
        if !is_consequence(root, &path, &error) {
            reading.faults.push(*error.diagnostic);
        }
        if path.is_empty() || reading.faults.len() >= MOST_FAULTS {
            return reading;
        }
        root.mark_faulty(&path);
    }
}

/// Whether a key is missing only because its value was faulty and is passed over, or because it
/// was misspelt and reported as unknown.
fn is_consequence(root: &Node, path: &[Step], error: &ReadError) -> bool {
    let Some(node) = root.descend(path) else {
        return false;
    };
    match (&node.value, error.missing) {
        (Value::Table(table), Some(Missing::Key(key))) => table
            .entries
            .iter()
            .any(|item| item.node.faulty && closest(&item.key, [key]).is_some()),
        (Value::Table(table), Some(Missing::AnyKey)) => {
            table.entries.iter().any(|item| item.node.faulty)
        }
        // A list that became too short.
        (Value::List(list), _) => list.iter().any(|node| node.faulty),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::scene::span::{Named, Spanned};
    use crate::scene::tree::parse;

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Colour {
        Red,
        Blue,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Round {
        radius: f64,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Form {
        Round(Round),
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Left {
        #[allow(dead_code)]
        left: f64,
    }

    #[allow(dead_code)]
    #[derive(Debug, Deserialize)]
    #[serde(rename = "Side by key", rename_all = "kebab-case")]
    enum Side {
        Value(f64),
        Left(Left),
        Right(Left),
    }

    #[derive(Debug, Default, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Toy {
        count: Option<u64>,
        colour: Option<Colour>,
        forms: Vec<Form>,
        named: Named<Round>,
        side: Option<Side>,
        pair: Option<[f64; 2]>,
        place: Spanned<f64>,
    }

    fn toy(text: &str) -> (Option<Toy>, Vec<(String, String)>) {
        let mut root = parse(text, 0).unwrap();
        let reading = read_all::<Toy>(&mut root);
        let faults = reading.faults.into_iter().map(|fault| {
            let place = fault.place.unwrap();
            (fault.message, text[place.start..place.end].to_owned())
        });
        (reading.value, faults.collect())
    }

    #[test]
    fn each_fault_is_reported_at_its_place() {
        let table = [
            (
                "count = -1",
                "expected a whole number, not negative, found -1",
                "-1",
            ),
            (
                "count = 'x'",
                "expected a whole number, not negative, found the text \"x\"",
                "'x'",
            ),
            ("colour = 'rde'", "`rde` is not known here", "'rde'"),
            ("colour = 3", "expected `red` or `blue`, found 3", "3"),
            ("cuont = 1", "unknown key `cuont`", "cuont"),
            (
                "forms = [{radius = 1}]",
                "`type` is missing",
                "{radius = 1}",
            ),
            (
                "forms = [{type = 'rond', radius = 1}]",
                "`rond` is not known here",
                "'rond'",
            ),
            (
                "forms = [{type = 'round', raduis = 1}]",
                "unknown key `raduis`",
                "raduis",
            ),
            (
                "forms = [{type = 'round'}]",
                "`radius` is missing",
                "{type = 'round'}",
            ),
            ("forms = 3", "expected a list, found 3", "3"),
            (
                "side = {left = 1, right = 2}",
                "`left` excludes `right`",
                "right",
            ),
            ("side = {}", "`left` or `right` is missing", "{}"),
            (
                "pair = [1, 2, 3]",
                "expected two values, found 3 of them",
                "[1, 2, 3]",
            ),
            (
                "pair = [1, 'a']",
                "expected a number, found the text \"a\"",
                "'a'",
            ),
            ("pair = [1]", "expected two values, found 1 of them", "[1]"),
            (
                "place = 1979-05-27",
                "expected a number, found a date",
                "1979-05-27",
            ),
        ];
        for (text, message, excerpt) in table {
            let (_, faults) = toy(text);
            assert_eq!(faults, [(message.to_owned(), excerpt.to_owned())], "{text}");
        }
    }

    #[test]
    fn all_faults_of_one_text_are_reported_and_the_rest_is_read() {
        let text = "count = -1\ncolour = 'x'\nplace = 2.5\n\
                    forms = [{type = 'round', radius = 1}, {type = 'round', radius = 'a'}]\n\
                    [named.a]\nradius = true\n[named.b]\nradius = 4\n[nmaed]\n";
        let (value, faults) = toy(text);
        assert_eq!(faults.len(), 5, "{faults:?}");
        let value = value.unwrap();
        assert_eq!(value.forms.len(), 1);
        assert_eq!(
            value
                .named
                .iter()
                .map(|e| e.name.as_str())
                .collect::<Vec<_>>(),
            ["b"]
        );
        assert!((value.named.get("b").unwrap().radius - 4.0).abs() < 1e-15);
        let Form::Round(round) = &value.forms[0];
        assert!((round.radius - 1.0).abs() < 1e-15);
        let place = value.place.span;
        assert_eq!(&text[place.start..place.end], "2.5");
    }

    #[test]
    fn reading_ends_after_many_faults() {
        let entries = (0..5000).map(|k| format!("m{k} = {{ radius = 'x' }}\n"));
        let text = format!("[named]\n{}", entries.collect::<String>());
        let (value, faults) = toy(&text);
        assert!(value.is_none());
        assert_eq!(faults.len(), MOST_FAULTS);
    }

    #[test]
    fn the_three_ways_to_name_a_variant_are_read() {
        let (value, faults) =
            toy("side = 3\ncolour = 'blue'\nforms = [{radius = 1, type = 'round'}]");
        assert!(faults.is_empty(), "{faults:?}");
        let value = value.unwrap();
        assert!(matches!(value.side, Some(Side::Value(_))));
        assert!(matches!(value.colour, Some(Colour::Blue)));
        assert!(matches!(
            toy("side = {left = 1}").0.unwrap().side,
            Some(Side::Left(_))
        ));
    }
}
