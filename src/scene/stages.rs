//! Scenes in stages: `[[stages]]` at the end of a scene file, each of which changes the scene of the stage
//! before it and starts with the state in which that one ended.
//!
//! The text is split by its lines, and blank lines stand in for what belongs elsewhere, so that faults are
//! found at their place in the file.

use std::collections::BTreeSet;
use std::path::Path;

use super::diagnostics::{Diagnostic, SceneErrors};
use super::loading::{LoadedScene, load_layers};
use super::overrides::Override;
use super::sources::Sources;
use super::{Scene, Spanned, Start, StartClock};

/// Name of the table.
pub(super) const STAGES: &str = "stages";
/// What a stage begins with before it says otherwise.
const GOES_ON: &str =
    "[start]\nfrom = \"the stage before\"\nclock = \"keep\"\ndisplacement = \"keep\"\n";

/// A stage with its own scene.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Its name, which is that of its folder.
    pub name: String,
    /// The scene.
    pub loaded: LoadedScene,
}

/// Loads the stages of a scene from texts of which each changes those before it; nothing where none has
/// stages. Texts after the one that has them hold for all stages. Overrides hold for all stages, and those of
/// `at_last` after them for the last one.
///
/// # Errors
/// [`SceneErrors`] of the first stage that has a fault, also for one whose clock goes on and that ends before it
/// begins.
pub fn load_stages(
    layers: &[(&str, &str)],
    base_dir: &Path,
    overrides: &[Override],
    at_last: &[Override],
) -> Result<Option<Vec<Stage>>, SceneErrors> {
    let Some(place) = layers.iter().position(|(_, text)| has_stages(text)) else {
        return Ok(None);
    };
    let (below, above) = (&layers[..place], &layers[place + 1..]);
    let (file, text) = layers[place];
    let split = split(file, text)?;
    let mut stages: Vec<Stage> = Vec::new();
    let with_last = [overrides, at_last].concat();
    for last in 1..=split.stages.len() {
        let mut all: Vec<(&str, &str)> = below.to_vec();
        all.push((file, &split.common));
        for (number, (_, text)) in split.stages[..last].iter().enumerate() {
            all.extend((number > 0).then_some(("the stage before", GOES_ON)));
            all.push((file, text));
        }
        all.extend(above);
        let overrides = match last == split.stages.len() {
            true => &with_last,
            false => overrides,
        };
        let loaded = load_layers(&all, base_dir, overrides)?;
        if let Some(before) = stages.last() {
            check_clock(before, &loaded)?;
        }
        let name = split.stages[last - 1].0.clone();
        stages.push(Stage { name, loaded });
    }
    Ok(Some(stages))
}

/// Refuses a stage that goes on with the clock of the one before and ends no later than that.
fn check_clock(before: &Stage, loaded: &LoadedScene) -> Result<(), SceneErrors> {
    let end = |scene: &Scene| scene.time.end.filter(|_| !scene.time.is_steady());
    let keeps = |start: &Spanned<Start>| start.clock.value == StartClock::Keep;
    let goes_on = loaded.scene.start.as_ref().is_some_and(keeps);
    let (Some(begin), Some(end)) = (end(&before.loaded.scene), end(&loaded.scene)) else {
        return Ok(());
    };
    if !goes_on || end.value() > begin.value() {
        return Ok(());
    }
    let message = format!(
        "the stage would end at {end}, where the clock of the stage \"{}\" before it ends at {begin}",
        before.name
    );
    let help = "all stages share one clock: choose a later end, or set start.clock = \"reset\"";
    Err(loaded.errors(vec![Diagnostic::new(message).at(end.span()).help(help)]))
}

/// A text without its stages, and the name and text of each.
struct Split {
    common: String,
    stages: Vec<(String, String)>,
}

/// Whether a text has stages. Faults of syntax are told when it is parsed.
fn has_stages(text: &str) -> bool {
    let table: toml::Table = text.parse().unwrap_or_default();
    table.contains_key(STAGES)
}

fn split(file: &str, text: &str) -> Result<Split, SceneErrors> {
    let table: toml::Table = text.parse().unwrap_or_default();
    let refuse = |message: String| {
        let help = "end the file with [[stages]], each with a name and the sections that it changes, as in \
                    [stages.time]";
        let fault = Diagnostic::new(message).help(help);
        Err(SceneErrors::new(vec![fault], Sources::new(file, text)))
    };
    let stages = table.get(STAGES).and_then(toml::Value::as_array);
    let entries = stages.filter(|entries| !entries.is_empty());
    let Some(entries) = entries else {
        return refuse("`stages` is no list of tables".to_owned());
    };
    let mut names = Vec::new();
    let mut seen = BTreeSet::new();
    for (number, entry) in entries.iter().enumerate() {
        let name = entry.get("name").and_then(toml::Value::as_str);
        let plain = |name: &&str| {
            let sound = |c: char| c.is_alphanumeric() || "-_".contains(c);
            !name.is_empty() && name.chars().all(sound)
        };
        let Some(name) = name.filter(plain) else {
            let number = number + 1;
            return refuse(format!(
                "stage {number} has no name of letters, digits, - and _"
            ));
        };
        let from = entry.get("start").and_then(|start| start.get("from"));
        if number > 0 && from.is_some() {
            return refuse(format!(
                "stage \"{name}\" starts from the stage before, and `start.from` names another state; leave it \
                 out, or run the stage as a scene of its own"
            ));
        }
        if !seen.insert(name) {
            return refuse(format!("two stages are called \"{name}\""));
        }
        names.push(name.to_owned());
    }
    let texts = match texts(text) {
        Ok(texts) => texts,
        Err(message) => return refuse(message),
    };
    if texts.len() != names.len() + 1 {
        return refuse("a stage does not begin with a line [[stages]]".to_owned());
    }
    let mut texts = texts.into_iter();
    let common = texts.next().unwrap_or_default();
    let stages = names.into_iter().zip(texts).collect();
    Ok(Split { common, stages })
}

/// The text before the first stage, and that of every stage with its sections at the top.
fn texts(text: &str) -> Result<Vec<String>, String> {
    let mut texts = vec![String::new()];
    let mut in_section = false;
    for (number, line) in text.lines().enumerate() {
        let bare = line.trim();
        if bare.starts_with("[[stages]]") {
            texts.push("\n".repeat(number + 1));
            in_section = false;
            continue;
        }
        let is_stage = texts.len() > 1;
        let own = match (is_stage, bare.starts_with('[') && is_header(bare)) {
            (false, _) => line.to_owned(),
            (true, true) => {
                in_section = true;
                header(bare).ok_or_else(|| {
                    format!(
                        "line {}: {bare} stands after the first stage; what holds for all stages comes before",
                        number + 1
                    )
                })?
            }
            // The name, and comments.
            (true, false) if !in_section && is_name(bare) => String::new(),
            (true, false) => line.to_owned(),
        };
        if let Some(last) = texts.last_mut() {
            last.push_str(&own);
            last.push('\n');
        }
    }
    Ok(texts)
}

/// Whether a line that begins with a bracket names a section rather than going on with a list.
fn is_header(line: &str) -> bool {
    let inner = line.trim_start_matches('[');
    let inner = inner.split('#').next().unwrap_or_default().trim_end();
    let name = inner.trim_end_matches(']');
    inner.ends_with(']')
        && name.starts_with(|c: char| c.is_alphabetic() || c == '"')
        && !name.contains([',', '='])
}

fn is_name(line: &str) -> bool {
    let rest = line.strip_prefix("name");
    rest.is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// A header of a stage as that of a scene.
fn header(line: &str) -> Option<String> {
    let start = if line.starts_with("[[") { "[[" } else { "[" };
    let rest = line.strip_prefix(start)?.strip_prefix("stages.")?;
    Some(format!("{start}{rest}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    const SCENE: &str = r#"title = "Staged"
[geometry]
type = "lattice"
size = [1, 1]
points = [4, 4]
[fluid]
viscosity = "1 cP"
[materials.a]
permeability = "1 mD"
storage = 1e-10
[flow.boundary.left]
pressure = "1 MPa"
[time]
end = "1 s"

[[stages]]
name = "first"

[[stages]]
name = "second"
[stages.time]
end = "2 s"
[stages.flow.boundary.left]
pressure = { time = [
  1,
  2,
], value = [1e6, 2e6] }

[[stages]]
name = "third"
[stages.time]
end = "3 s"
"#;

    fn load(text: &str) -> Result<Option<Vec<Stage>>, String> {
        let stages = load_stages(&[("staged.toml", text)], Path::new(""), &[], &[]);
        stages.map_err(|errors| errors.render(false))
    }

    #[test]
    fn each_stage_changes_the_one_before() {
        let stages = load(SCENE).unwrap().unwrap();
        let names: Vec<&str> = stages.iter().map(|stage| &*stage.name).collect();
        assert_eq!(names, ["first", "second", "third"]);
        let end = |k: usize| stages[k].loaded.scene.time.end.unwrap().value();
        assert_eq!([end(0), end(1), end(2)], [1.0, 2.0, 3.0]);
        // What the second stage changed holds in the third.
        assert!(stages[2].loaded.resolved_toml().contains("time = ["));
        assert!(!stages[0].loaded.resolved_toml().contains("time = ["));
    }

    #[test]
    fn what_is_typed_for_the_last_stage_leaves_the_others() {
        let all = [Override::from("time.step=0.1".to_owned())];
        let last = [Override::by_option("--end", "time.end", "5")];
        let stages = load_stages(&[("staged.toml", SCENE)], Path::new(""), &all, &last);
        let stages = stages.unwrap().unwrap();
        let end = |stage: &Stage| stage.loaded.scene.time.end.unwrap().value();
        assert_eq!(stages.iter().map(end).collect::<Vec<_>>(), [1.0, 2.0, 5.0]);
        let step = |stage: &Stage| stage.loaded.scene.time.step.unwrap().value();
        assert!(stages.iter().all(|stage| step(stage) == 0.1));
    }

    #[test]
    fn a_stage_that_ends_before_it_begins_is_refused_unless_its_clock_is_reset() {
        for end in ["1 s", "2 s"] {
            let early = SCENE.replace("end = \"3 s\"", &format!("end = \"{end}\""));
            let message = load(&early).unwrap_err();
            assert!(
                message.contains("before it ends at 2 s")
                    && message.contains(&format!("\"{end}\"")),
                "{message}"
            );
            let reset = format!("{early}[stages.start]\nclock = \"reset\"\n");
            assert!(load(&reset).is_ok());
        }
    }

    #[test]
    fn faults_are_at_their_place_in_the_file() {
        let wrong = SCENE.replace("end = \"3 s\"", "end = \"3 m\"");
        let line = wrong.lines().position(|line| line.contains("3 m")).unwrap() + 1;
        let message = load(&wrong).unwrap_err();
        assert!(
            message.contains(&format!("staged.toml:{line}")),
            "{message}"
        );
    }

    #[test]
    fn what_is_no_stage_is_refused_by_name() {
        assert!(load("title = \"a\"\n").unwrap().is_none());
        for (old, new, expected) in [
            ("name = \"second\"\n", "", "stage 2 has no name"),
            ("\"second\"", "\"first\"", "two stages are called \"first\""),
            ("\"second\"", "\"../up\"", "stage 2 has no name"),
            (
                "[stages.time]",
                "[solver]",
                "[solver] stands after the first stage",
            ),
            (
                "[stages.time]",
                "[stages.start]\nfrom = \"elsewhere\"\n[stages.time]",
                "stage \"second\" starts from the stage before",
            ),
        ] {
            let message = load(&SCENE.replacen(old, new, 1)).unwrap_err();
            assert!(message.contains(expected), "{message}");
        }
    }
}
