//! From a file, or from a text in memory, to a [`Scene`].

use std::path::{Path, PathBuf};

use super::diagnostics::{Diagnostic, SceneErrors};
use super::draft::Draft;
use super::overrides::Override;
use super::sources::Sources;
use super::tree::{self, Node};
use super::validate::Context;
use super::{Scene, base, overrides, recover};

/// A scene, with what is needed to speak about it.
#[derive(Debug, Clone)]
pub struct LoadedScene {
    /// The scene.
    pub scene: Scene,
    /// The texts its places refer to.
    pub sources: Sources,
    /// Folder that paths in the scene are relative to.
    pub base_dir: PathBuf,
    merged: Node,
}

impl LoadedScene {
    /// The scene file with all `--set` values in it, as TOML: running it again gives the same run, from any folder,
    /// for paths in it are absolute.
    pub fn resolved_toml(&self) -> String {
        let mut anchored = self.merged.clone();
        anchored.each_path(&mut |typed| {
            // Without a working directory there is nothing to be relative to.
            if let Ok(path) = std::path::absolute(self.path(typed)) {
                *typed = path.to_string_lossy().into_owned();
            }
        });
        // A tree that was read from TOML can always be written as TOML.
        toml::to_string_pretty(&anchored).unwrap_or_default()
    }

    /// The scene with this title, unless it has one of its own: its text then says all by itself.
    #[must_use]
    pub fn titled(mut self, title: &str) -> Self {
        if self.scene.title.is_none() && self.merged.insert_first("title", title) {
            self.scene.title = Some(title.to_owned());
        }
        self
    }

    /// A path of the scene, relative to where the scene file is.
    pub fn path(&self, typed: &str) -> PathBuf {
        self.base_dir.join(typed)
    }

    /// Errors about this scene that were found later on, such as while planning.
    pub fn errors(&self, diagnostics: Vec<Diagnostic>) -> SceneErrors {
        SceneErrors::new(diagnostics, self.sources.clone())
    }
}

/// Loads a scene file and applies `--set` texts (`key.path=value`) in their order.
///
/// A file may name another one as its `base`, which it changes, and that one another.
///
/// # Errors
/// All faults at once: the file cannot be read, syntax, unknown keys, units, broken rules.
pub fn load_file(path: &Path, overrides: &[String]) -> Result<LoadedScene, SceneErrors> {
    with_layers(path, |layers, base_dir| {
        load_layers(layers, base_dir, overrides)
    })
}

/// Hands the texts of a scene file and its bases to `load`, with the folder that its paths are relative to.
///
/// # Errors
/// [`SceneErrors`] for a file that cannot be read, and those of `load`.
pub fn with_layers<T>(
    path: &Path,
    load: impl FnOnce(&[(&str, &str)], &Path) -> Result<T, SceneErrors>,
) -> Result<T, SceneErrors> {
    let layers = base::layers(path)?;
    let layers: Vec<(&str, &str)> = (layers.iter())
        .map(|layer| (&*layer.name, &*layer.text))
        .collect();
    load(&layers, path.parent().unwrap_or_else(|| Path::new("")))
}

/// Loads a scene from a text; `name` stands for it in messages, paths in it are relative to
/// `base_dir`.
///
/// # Errors
/// All faults at once: syntax, unknown keys, units, broken rules.
pub fn load_str(
    name: &str,
    text: &str,
    base_dir: &Path,
    overrides: &[String],
) -> Result<LoadedScene, SceneErrors> {
    load_layers(&[(name, text)], base_dir, overrides)
}

/// Loads a scene from texts of which each changes those before it; each has its name for messages.
///
/// # Errors
/// As [`load_str`].
pub fn load_layers(
    layers: &[(&str, &str)],
    base_dir: &Path,
    overrides: &[impl Into<Override> + Clone],
) -> Result<LoadedScene, SceneErrors> {
    let overrides: Vec<Override> = overrides.iter().cloned().map(Into::into).collect();
    let Some(((name, text), changes)) = layers.split_first() else {
        let fault = Diagnostic::new("there is no scene");
        return Err(SceneErrors::new(vec![fault], Sources::new("", "")));
    };
    let mut sources = Sources::new(name, text);
    let faults = match merge(text, changes, &overrides, &mut sources) {
        Ok(merged) => match build(merged.clone()) {
            Ok(scene) => {
                return Ok(LoadedScene {
                    scene,
                    sources,
                    base_dir: base_dir.to_owned(),
                    merged,
                });
            }
            Err(faults) => faults,
        },
        Err(faults) => faults,
    };
    Err(SceneErrors::new(faults, sources))
}

fn merge(
    text: &str,
    changes: &[(&str, &str)],
    overrides: &[Override],
    sources: &mut Sources,
) -> Result<Node, Vec<Diagnostic>> {
    let blank = |line: &str| line.trim().is_empty() || line.trim().starts_with('#');
    if text.trim_start_matches('\u{feff}').lines().all(blank) {
        let fault = Diagnostic::new("the scene file is empty");
        return Err(vec![
            fault.help("start from a bundled case: perifrac cases --write NAME"),
        ]);
    }
    let mut root = tree::parse(text, 0)?;
    for (name, text) in changes {
        overrides::lay_over(&mut root, name, text, sources)?;
    }
    let mut faults = overrides::apply(&mut root, overrides, sources);
    faults.extend(base::misplaced(&root));
    if faults.is_empty() {
        Ok(root)
    } else {
        Err(faults)
    }
}

fn build(mut root: Node) -> Result<Scene, Vec<Diagnostic>> {
    let reading = recover::read_all::<Draft>(&mut root);
    let mut faults = reading.faults;
    let Some(draft) = reading.value else {
        if faults.len() >= recover::MOST_FAULTS {
            let message = format!("reading ended after {} faults", faults.len());
            faults.push(Diagnostic::new(message).help("correct these first"));
        }
        return Err(faults);
    };
    faults.extend(draft.check(&Context {
        draft: &draft,
        faulty: &reading.faulty,
    }));
    if !faults.is_empty() {
        return Err(faults);
    }
    draft
        .finish()
        .ok_or_else(|| vec![Diagnostic::new("the scene is not complete")])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    const SMALL: &str = r#"# a comment
title = "Small"
[geometry]
type = "lattice"
size = [1, 1]
points = [10, 10]
[fluid]
viscosity = "1 cP"
[materials.z_first]
permeability = "1 mD"
storage = 1e-10
[materials.a_second]
region = { type = "box", min = [0, 0], max = [0.5, 1] }
permeability = "2 mD"
storage = 1e-10
[flow.boundary.left]
pressure = "1 MPa"
[time]
end = "10 s"
"#;

    fn load(text: &str, overrides: &[&str]) -> Result<LoadedScene, SceneErrors> {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        load_str("small.toml", text, Path::new("there"), &overrides)
    }

    #[test]
    fn quantities_arrive_in_si_and_defaults_are_filled_in() {
        let scene = load(SMALL, &[]).unwrap().scene;
        assert_eq!(scene.fluid.as_ref().unwrap().viscosity.value(), 1e-3);
        assert_eq!(scene.fluid.unwrap().density.value(), 1000.0);
        assert_eq!(scene.time.end.unwrap().value(), 10.0);
        assert_eq!(scene.time.tolerance.map(|own| own.value()), None);
        assert_eq!(scene.solver.name.value, "auto");
        assert_eq!(scene.geometry.bounds().unwrap().max, [1.0, 1.0]);
        assert!(scene.gravity.is_none() && scene.wells.is_empty() && scene.output.vtu);
        let storage = scene.materials.get("z_first").unwrap().storage.as_ref();
        assert_eq!(
            storage.and_then(|own| own.typed().value()).unwrap().value(),
            1e-10
        );
    }

    #[test]
    fn materials_keep_the_order_of_the_file() {
        let loaded = load(SMALL, &[]).unwrap();
        let names: Vec<_> = loaded
            .scene
            .materials
            .iter()
            .map(|e| e.name.as_str())
            .collect();
        assert_eq!(names, ["z_first", "a_second"]);
        let toml = loaded.resolved_toml();
        assert!(
            toml.find("z_first").unwrap() < toml.find("a_second").unwrap(),
            "{toml}"
        );
    }

    #[test]
    fn the_resolved_text_names_files_from_any_folder() {
        let text = format!(
            "{}\n[start]\nfrom = \"/runs/before\"\n",
            SMALL.replace(
                "[materials.a_second]",
                "[materials.a_second]\ndensity = { file = \"rho.csv\" }"
            )
        );
        let sets = [Override::from("geometry.path=points.csv".to_owned())];
        let mut sources = Sources::new("scene", &text);
        let merged = merge(&text, &[], &sets, &mut sources).unwrap();
        let loaded = LoadedScene {
            base_dir: PathBuf::from("/scenes"),
            merged,
            ..load(SMALL, &[]).unwrap()
        };
        let toml = loaded.resolved_toml();
        for path in ["/scenes/points.csv", "/scenes/rho.csv", "/runs/before"] {
            assert!(toml.contains(&format!("\"{path}\"")), "{toml}");
        }
    }

    #[test]
    fn the_resolved_text_gives_the_same_scene_again() {
        let sets = [
            "time.end=30 s",
            "time.first_step=0.5",
            "wells.w.at=[0.5, 0.5]",
            "wells.w.rate=1e-6 m^2/s",
        ];
        let once = load(SMALL, &sets).unwrap();
        assert!(
            once.resolved_toml().contains("end = \"30 s\""),
            "{}",
            once.resolved_toml()
        );
        let twice = load(&once.resolved_toml(), &[]).unwrap();
        assert_eq!(once.resolved_toml(), twice.resolved_toml());
        assert_eq!(twice.scene.time.end.unwrap().value(), 30.0);
        assert_eq!(twice.scene.time.first_step.unwrap().value(), 0.5);
        assert_eq!(
            twice
                .scene
                .wells
                .get("w")
                .unwrap()
                .rate
                .as_ref()
                .unwrap()
                .resolved()
                .at(0.0),
            1e-6
        );
    }

    #[test]
    fn a_fault_in_a_set_text_is_shown_there() {
        let text = load(SMALL, &["time.max_step=1", "time.end=30 sec"])
            .unwrap_err()
            .to_string();
        assert!(text.contains("--set #2:1:10"), "{text}");
        assert!(text.contains("time.end=30 sec"), "{text}");
        assert!(text.contains("unknown unit `sec`"), "{text}");
        let text = load(SMALL, &["time.ned=30"]).unwrap_err().to_string();
        assert!(
            text.contains("did you mean `end`?") && text.contains("--set #1"),
            "{text}"
        );
    }

    #[test]
    fn a_later_stage_can_underline_the_scene() {
        let loaded = load(SMALL, &[]).unwrap();
        let region = loaded.scene.materials.entries[1]
            .value
            .region
            .as_ref()
            .unwrap();
        let fault = Diagnostic::new("the region holds no point").at(region.span);
        let text = loaded.errors(vec![fault]).to_string();
        assert!(text.contains("small.toml:13:10"), "{text}");
        assert_eq!(loaded.path("k.npy"), Path::new("there").join("k.npy"));
    }

    #[test]
    fn syntax_errors_come_together() {
        let broken = SMALL
            .replace("\"1 cP\"", "1 cP")
            .replace("end = \"10 s\"", "end =");
        let errors = load(&broken, &[]).unwrap_err();
        let messages: Vec<_> = errors
            .diagnostics
            .iter()
            .map(|d| d.message.as_str())
            .collect();
        assert_eq!(
            messages,
            ["a text must stand in quotes", "a value is missing"]
        );
        assert_eq!(
            errors.diagnostics[0].help.as_deref(),
            Some("write \"1 cP\"")
        );
        let twice = format!("{SMALL}end = 3\n");
        assert!(
            load(&twice, &[])
                .unwrap_err()
                .to_string()
                .contains("duplicate key")
        );
    }

    #[test]
    fn a_file_may_change_another_one() {
        let change = "base = \"small.toml\"\n[time]\nmax_step = \"1 s\"\n[materials.a_second]\n\
                      storage = 3e-10\nregion = { type = \"box\", min = [0, 0], max = [0.4, 1] }\n";
        let layers = [("small.toml", SMALL), ("smoke.toml", change)];
        let loaded = load_layers(&layers, Path::new(""), &[] as &[Override]).unwrap();
        assert_eq!(loaded.scene.time.end.unwrap().value(), 10.0);
        assert_eq!(loaded.scene.time.max_step.unwrap().value(), 1.0);
        let second = loaded.scene.materials.get("a_second").unwrap();
        let storage = second.storage.as_ref();
        assert_eq!(
            storage.and_then(|own| own.typed().value()).unwrap().value(),
            3e-10
        );
        assert!(second.permeability.is_some());
        assert!(loaded.resolved_toml().contains("0.4"));
        let wrong = [
            ("small.toml", SMALL),
            ("smoke.toml", "[time]\nmax_step = 1 s\n"),
        ];
        let text = load_layers(&wrong, Path::new(""), &[] as &[Override])
            .unwrap_err()
            .to_string();
        assert!(text.contains("smoke.toml:2:12"), "{text}");
    }

    #[test]
    fn windows_line_ends_and_a_byte_order_mark_are_fine() {
        let text = format!("\u{feff}{}", SMALL.replace('\n', "\r\n"));
        assert!(load(&text, &[]).is_ok());
        let text = text.replace("\"1 cP\"", "0");
        let errors = load(&text, &[]).unwrap_err();
        assert_eq!(
            errors.sources.excerpt(errors.diagnostics[0].place.unwrap()),
            Some("0")
        );
        assert!(errors.to_string().contains("small.toml:8:13"), "{errors}");
    }

    #[test]
    fn a_file_that_is_no_scene_is_named() {
        let folder = std::env::temp_dir().join(format!("perifrac-scene-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        let cases = [
            (folder.join("absent.toml"), "cannot read the scene file"),
            (folder.clone(), "is a folder"),
            (
                write("empty.toml", b"\n# only a comment\n"),
                "the scene file is empty",
            ),
            (
                write("latin.toml", b"title = 'x'\n# \xe9\n"),
                "is not UTF-8 text (line 2)",
            ),
        ];
        for (path, message) in cases {
            let text = load_file(&path, &[]).unwrap_err().to_string();
            assert!(text.contains(message), "{text}");
        }
        let loaded = load_file(&write("good.toml", SMALL.as_bytes()), &[]).unwrap();
        assert_eq!(loaded.base_dir, folder);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
