//! `--set key.path=value`: the value is TOML, or else a bare string.

use super::diagnostics::Diagnostic;
use super::sources::Sources;
use super::span::Span;
use super::tree::{self, Item, Node, Table, Value};

/// A key and its value as `key.path=value`, with the option that it was typed as.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Such as `--end`; `None` for `--set`.
    option: Option<&'static str>,
    text: String,
}

impl Override {
    /// A key that an option of its own sets to the text that was typed.
    pub fn by_option(option: &'static str, key: &str, typed: &str) -> Self {
        // As a string of TOML, whatever the text.
        let value = toml::Value::String(typed.to_owned());
        Override {
            option: Some(option),
            text: format!("{key}={value}"),
        }
    }

    /// As `--set` takes it.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// The text of a `--set`.
impl From<String> for Override {
    fn from(text: String) -> Self {
        Override { option: None, text }
    }
}

/// Applies overrides to the tree in their order.
pub(super) fn apply(
    root: &mut Node,
    overrides: &[Override],
    sources: &mut Sources,
) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let mut sets = 0;
    for Override { option, text } in overrides {
        sets += usize::from(option.is_none());
        let name = option.map_or_else(|| format!("--set #{sets}"), str::to_owned);
        let offset = sources.add_typed(&name, text);
        match read(text, offset) {
            Ok(Node {
                value: Value::Table(new),
                ..
            }) => merge(root, new, &mut faults),
            Ok(_) => {}
            Err(errors) => faults.extend(errors),
        }
    }
    faults
}

/// Lays a second file over the tree: its sections add to those of the first, its values replace them.
pub(super) fn lay_over(
    root: &mut Node,
    name: &str,
    text: &str,
    sources: &mut Sources,
) -> Result<(), Vec<Diagnostic>> {
    let offset = sources.add(name, text);
    let Value::Table(mut table) = tree::parse(text, offset)?.value else {
        return Ok(());
    };
    table.entries.retain(|item| item.key != BASE);
    let inline = |span: Span| text[span.start - offset..].starts_with('{');
    lay(root, table, &inline);
    Ok(())
}

/// Key of a scene file that names the file it changes.
pub(super) const BASE: &str = "base";

fn lay(target: &mut Node, new: Table, inline: &dyn Fn(Span) -> bool) {
    let Value::Table(table) = &mut target.value else {
        return;
    };
    for item in new.entries {
        match (table.get_mut(&item.key), &item.node.value) {
            (Some(old), Value::Table(inner))
                if !inline(item.node.span) && matches!(old.node.value, Value::Table(_)) =>
            {
                lay(&mut old.node, inner.clone(), inline);
            }
            (Some(old), _) => old.node = item.node,
            (None, _) => table.entries.push(item),
        }
    }
}

fn read(text: &str, offset: usize) -> Result<Node, Vec<Diagnostic>> {
    let whole = Span {
        start: offset,
        end: offset + text.len(),
    };
    let refuse = |message: &str| {
        Err(vec![
            Diagnostic::new(message)
                .at(whole)
                .help("write --set key.path=value, one key at a time"),
        ])
    };
    match tree::parse(text, offset) {
        Ok(node) => match node.table() {
            Some(table) if table.entries.len() == 1 && !text.trim_start().starts_with('[') => {
                Ok(node)
            }
            _ => refuse("`--set` needs exactly one key and its value"),
        },
        Err(errors) => {
            let Some((key, value)) = text.split_once('=') else {
                return refuse("`--set` needs a key and a value");
            };
            // Text that opens a TOML string, list or table was meant to be one.
            if value.trim_start().starts_with(['"', '\'', '[', '{']) || value.contains('\n') {
                return Err(errors);
            }
            bare_string(key, value, offset)
        }
    }
}

fn bare_string(key: &str, value: &str, offset: usize) -> Result<Node, Vec<Diagnostic>> {
    // Any value will do to read the key by; the real one takes its place.
    let mut node = tree::parse(&format!("{key}=0"), offset)?;
    let start = offset + key.len() + 1 + (value.len() - value.trim_start().len());
    let span = Span {
        start,
        end: start + value.trim().len(),
    };
    replace_leaf(
        &mut node,
        Node::new(Value::Text(value.trim().to_owned()), span),
    );
    Ok(node)
}

/// Puts `leaf` where the one way through the tables ends.
fn replace_leaf(node: &mut Node, leaf: Node) {
    match &mut node.value {
        Value::Table(table) => {
            if let Some(item) = table.entries.first_mut() {
                replace_leaf(&mut item.node, leaf);
            }
        }
        _ => *node = leaf,
    }
}

/// Sets the one value that `new` leads to, making the tables on the way.
fn merge(target: &mut Node, new: Table, faults: &mut Vec<Diagnostic>) {
    for item in new.entries {
        let Value::Table(table) = &mut target.value else {
            let message = format!(
                "`{}` cannot be set inside a value that is no table",
                item.key
            );
            faults.push(
                Diagnostic::new(message)
                    .at(item.key_span)
                    .also(target.span, "this value"),
            );
            return;
        };
        let dotted = is_dotted(&item);
        match (table.get_mut(&item.key), item.node.value) {
            (Some(old), Value::Table(inner)) if dotted => merge(&mut old.node, inner, faults),
            (Some(old), value) => old.node = Node::new(value, item.node.span),
            (None, value) => table.entries.push(Item {
                key: item.key,
                key_span: item.key_span,
                node: Node::new(value, item.node.span),
            }),
        }
    }
}

/// Whether the item is a step of a dotted key rather than the value itself: the table of a dotted
/// key has the place of the key, an inline table `{…}` has its own.
fn is_dotted(item: &Item) -> bool {
    item.node.span == item.key_span
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tree::parse;

    fn merged(file: &str, sets: &[&str]) -> Result<String, Vec<Diagnostic>> {
        let mut root = parse(file, 0).unwrap();
        let mut sources = Sources::new("a.toml", file);
        let sets: Vec<Override> = (sets.iter())
            .map(|set| Override::from((*set).to_owned()))
            .collect();
        let faults = apply(&mut root, &sets, &mut sources);
        if faults.is_empty() {
            Ok(toml::to_string(&root).unwrap())
        } else {
            Err(faults)
        }
    }

    #[test]
    fn a_value_is_toml_or_else_a_bare_string() {
        let file = "[time]\nend = 1\n";
        let table = [
            ("time.end=30", "end = 30\n"),
            ("time.end=30 s", "end = \"30 s\"\n"),
            ("time.end = \"30 s\"", "end = \"30 s\"\n"),
            ("time.end=1e-3 m^2/s", "end = \"1e-3 m^2/s\"\n"),
            ("time.end=steady", "end = \"steady\"\n"),
            ("time.end=a=b:c=d", "end = \"a=b:c=d\"\n"),
            ("time.end=true", "end = true\n"),
            ("time.end=[1, 2]", "end = [1, 2]\n"),
        ];
        for (set, expected) in table {
            assert_eq!(
                merged(file, &[set]).unwrap(),
                format!("[time]\n{expected}"),
                "{set}"
            );
        }
    }

    #[test]
    fn missing_tables_are_made_and_other_keys_kept() {
        let text = merged("a = 1\n[b]\nc = 2\n", &["b.d.e=3", "x.y=4"]).unwrap();
        assert_eq!(text, "a = 1\n\n[b]\nc = 2\n\n[b.d]\ne = 3\n\n[x]\ny = 4\n");
    }

    #[test]
    fn an_inline_table_replaces_the_whole_value() {
        let text = merged("[h]\nradius = 1\n", &["h={ratio = 3}"]).unwrap();
        assert_eq!(text, "[h]\nratio = 3\n");
    }

    #[test]
    fn the_last_of_two_settings_of_a_key_wins() {
        assert_eq!(merged("", &["a.b=1", "a.b=2"]).unwrap(), "[a]\nb = 2\n");
    }

    #[test]
    fn a_setting_that_cannot_be_read_says_so() {
        let table = [
            ("time.end", "needs a key and a value"),
            ("[time]", "needs exactly one key"),
            ("a=1\nb=2", "needs exactly one key"),
            ("a=[1, 2", "unclosed array"),
            ("a.b=1", "cannot be set inside a value that is no table"),
            ("a b=1", ""),
        ];
        for (set, message) in table {
            let faults = merged("a = 1\n", &[set]).unwrap_err();
            assert!(faults[0].message.contains(message), "{set}: {faults:?}");
            assert!(faults[0].place.unwrap().start >= 7, "{set}: {faults:?}");
        }
    }
}
