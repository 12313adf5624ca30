//! What is wrong with a scene, and how it is shown: with the place underlined and the remedy.

use std::fmt;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::sources::Sources;
use super::span::Span;

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Diagnostic {
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// Where; `None` if the fault is that something is absent.
    pub place: Option<Span>,
    /// A few words under the underlined place.
    pub label: Option<String>,
    /// A second place that matters, with its words.
    pub also: Option<(Span, String)>,
    /// What to do about it.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A diagnostic without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            ..Self::default()
        }
    }

    /// Sets the place. [`Span::NOWHERE`] leaves it out.
    #[must_use]
    pub fn at(mut self, place: Span) -> Self {
        self.place = Some(place).filter(|place| place.is_somewhere());
        self
    }

    /// Sets the words under the place.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// Adds a second place. [`Span::NOWHERE`] leaves it out.
    #[must_use]
    pub fn also(mut self, place: Span, label: impl Into<String>) -> Self {
        self.also = place.is_somewhere().then(|| (place, label.into()));
        self
    }

    /// Sets the remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    fn render(&self, sources: &Sources, renderer: &Renderer) -> String {
        let mut group = Group::with_title(Level::ERROR.primary_title(&self.message));
        let place = self.place.and_then(|place| sources.locate(place));
        let also = self
            .also
            .as_ref()
            .and_then(|(span, label)| Some((sources.locate(*span)?, label)));
        if let Some((name, text, range)) = place {
            let primary = AnnotationKind::Primary
                .span(range)
                .label(self.label.as_deref());
            let mut snippet = Snippet::source(text).path(name).annotation(primary);
            let mut elsewhere = None;
            if let Some(((other, text, range), label)) = also {
                let context = AnnotationKind::Context.span(range).label(label.as_str());
                if other == name {
                    snippet = snippet.annotation(context);
                } else {
                    elsewhere = Some(Snippet::source(text).path(other).annotation(context));
                }
            }
            group = group.element(snippet).elements(elsewhere);
        } else {
            group = group.element(annotate_snippets::Origin::path(sources.name()));
        }
        let help = self.help.as_deref().map(|help| Level::HELP.message(help));
        renderer.render(&[group.elements(help)])
    }
}

/// Faults that are shown; nobody reads more, and each is cut out of the whole text.
const MOST_SHOWN: usize = 100;

/// Everything that is wrong with a scene, in the order of the file.
///
/// `Debug` shows the same text as `Display`: a program whose `main` returns these errors underlines the place.
#[derive(Clone, PartialEq, Eq)]
pub struct SceneErrors {
    /// The faults; never empty.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts their places refer to.
    pub sources: Sources,
}

impl SceneErrors {
    /// Sorts the faults by place; those without one come last.
    pub fn new(mut diagnostics: Vec<Diagnostic>, sources: Sources) -> Self {
        diagnostics.sort_by_key(|d| d.place.map_or(usize::MAX, |place| place.start));
        diagnostics.dedup();
        Self {
            diagnostics,
            sources,
        }
    }

    /// The files that the faults are in; that of the scene where none of them has a place.
    fn names(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        let places = self.diagnostics.iter().filter_map(|fault| fault.place);
        for (name, ..) in places.filter_map(|place| self.sources.locate(place)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        match names.is_empty() {
            true => self.sources.name().to_owned(),
            false => names.join(" and "),
        }
    }

    /// The whole report as text, with terminal colours or without.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let shown = self.diagnostics.iter().take(MOST_SHOWN);
        let mut parts: Vec<String> = shown.map(|d| d.render(&self.sources, &renderer)).collect();
        let (count, name) = (self.diagnostics.len(), self.names());
        if count > MOST_SHOWN {
            parts.push(format!(
                "{count} errors in {name}, of which the first {MOST_SHOWN} are shown"
            ));
        } else if count > 1 {
            parts.push(format!("{count} errors in {name}"));
        }
        parts.join("\n\n")
    }
}

impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl fmt::Debug for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\n{self}")
    }
}

impl std::error::Error for SceneErrors {}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources() -> Sources {
        let mut sources = Sources::new("case.toml", "title = \"t\"\nµ = 3 # é\nend = -1\n");
        sources.add("--set #1", "time.step=9");
        sources
    }

    #[test]
    fn the_place_is_underlined_after_letters_of_several_bytes() {
        let start = sources()
            .locate(Span { start: 0, end: 0 })
            .unwrap()
            .1
            .find("-1")
            .unwrap();
        let error = Diagnostic::new("`end` must be positive")
            .at(Span {
                start,
                end: start + 2,
            })
            .label("is negative")
            .help("write a later time");
        let text = SceneErrors::new(vec![error], sources()).to_string();
        assert!(text.contains("error: `end` must be positive"), "{text}");
        assert!(text.contains("case.toml:3:7"), "{text}");
        assert!(text.contains("^^ is negative"), "{text}");
        assert!(text.contains("help: write a later time"), "{text}");
        assert!(!text.contains('\u{1b}'), "{text}");
    }

    #[test]
    fn a_set_text_is_shown_under_its_own_name_beside_the_file() {
        let sources = sources();
        let end = sources
            .locate(Span { start: 0, end: 0 })
            .unwrap()
            .1
            .find("end")
            .unwrap();
        let offset = sources.locate(Span { start: 0, end: 0 }).unwrap().1.len() + 1;
        let error = Diagnostic::new("`step` is longer than the run")
            .at(Span {
                start: offset + 10,
                end: offset + 11,
            })
            .also(
                Span {
                    start: end,
                    end: end + 8,
                },
                "the run ends here",
            );
        let text = SceneErrors::new(vec![error], sources).to_string();
        assert!(text.contains("--set #1:1:11"), "{text}");
        assert!(text.contains("the run ends here"), "{text}");
    }

    #[test]
    fn of_many_errors_the_first_hundred_are_shown() {
        let fault = |k: usize| Diagnostic::new(format!("fault {k}")).at(Span { start: 0, end: 1 });
        let errors = SceneErrors::new((0..5000).map(fault).collect(), sources());
        let text = errors.to_string();
        assert_eq!(text.matches("error: fault").count(), MOST_SHOWN);
        assert!(
            text.ends_with("5000 errors in case.toml, of which the first 100 are shown"),
            "{text}"
        );
    }

    #[test]
    fn several_errors_are_counted_by_the_texts_they_are_in() {
        let sources = sources();
        let offset = sources.locate(Span { start: 0, end: 0 }).unwrap().1.len() + 1;
        let fault = |start: usize| {
            let end = start + 1;
            Diagnostic::new(format!("fault {start}")).at(Span { start, end })
        };
        let set = [fault(offset), fault(offset + 2)];
        let errors = SceneErrors::new(set.to_vec(), sources.clone());
        assert!(errors.to_string().ends_with("2 errors in --set #1"));
        let both = [fault(0), set[0].clone()];
        let errors = SceneErrors::new(both.to_vec(), sources);
        assert!(
            errors
                .to_string()
                .ends_with("2 errors in case.toml and --set #1")
        );
    }

    #[test]
    fn several_errors_come_in_file_order_and_are_counted() {
        let late = Diagnostic::new("late").at(Span { start: 20, end: 21 });
        let early = Diagnostic::new("early").at(Span { start: 0, end: 5 });
        let absent = Diagnostic::new("absent");
        let errors = SceneErrors::new(vec![absent, late, early], sources());
        let order: Vec<_> = errors
            .diagnostics
            .iter()
            .map(|d| d.message.as_str())
            .collect();
        assert_eq!(order, ["early", "late", "absent"]);
        assert!(errors.to_string().ends_with("3 errors in case.toml"));
        assert!(errors.render(true).contains('\u{1b}'));
    }
}
