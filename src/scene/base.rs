//! Scene files that change other ones: `base = "scene.toml"` names the file that is changed, which may
//! have a base itself.

use std::path::{Path, PathBuf};

use super::diagnostics::{Diagnostic, SceneErrors};
use super::overrides::BASE;
use super::sources::Sources;
use super::tree::Node;

/// A scene file as read.
pub(super) struct Layer {
    /// Its path, as messages show it.
    pub name: String,
    pub text: String,
    path: PathBuf,
}

/// More bases than this on top of each other are a slip.
const DEEPEST: usize = 16;

/// The file and its bases, the first one first; a base is relative to the file that names it.
///
/// # Errors
/// [`SceneErrors`] for a file that cannot be read, and for a `base` that is no path or leads in a
/// circle.
pub(super) fn layers(path: &Path) -> Result<Vec<Layer>, SceneErrors> {
    let mut layers = vec![read(path, None)?];
    while let Some(base) = next(&layers)? {
        layers.push(base);
    }
    layers.reverse();
    Ok(layers)
}

/// The base of the last of the files.
fn next(layers: &[Layer]) -> Result<Option<Layer>, SceneErrors> {
    let Some(last) = layers.last() else {
        return Ok(None);
    };
    // A text with faults of syntax has no base; they are told when it is parsed.
    let table: toml::Table = last.text.parse().unwrap_or_default();
    let Some(base) = table.get(BASE) else {
        return Ok(None);
    };
    let name = &last.name;
    let Some(base) = base.as_str() else {
        let message = format!("the `base` of the scene file `{name}` must be a text, found {base}");
        return refuse(name, message, HELP);
    };
    let path = last
        .path
        .parent()
        .unwrap_or_else(|| Path::new(""))
        .join(base);
    let same = |layer: &&Layer| match (layer.path.canonicalize(), path.canonicalize()) {
        (Ok(first), Ok(second)) => first == second,
        _ => false,
    };
    if let Some(circle) = layers.iter().find(same) {
        let message = format!(
            "the `base` of the scene file `{name}` leads back to `{}`",
            circle.name
        );
        return refuse(name, message, HELP);
    }
    if layers.len() > DEEPEST {
        let message = format!("the scene file `{name}` is the {DEEPEST}th base in a row");
        return refuse(name, message, HELP);
    }
    read(&path, Some((base, last))).map(Some)
}

const HELP: &str = "`base` names a scene file, relative to this one, which this one changes";

fn refuse<T>(name: &str, message: String, help: &str) -> Result<T, SceneErrors> {
    let fault = Diagnostic::new(message).help(help);
    Err(SceneErrors::new(vec![fault], Sources::new(name, "")))
}

/// Reads a file; `named` is the base's name and the file that it stands in.
fn read(path: &Path, named: Option<(&str, &Layer)>) -> Result<Layer, SceneErrors> {
    let name = path.display().to_string();
    let what = match named {
        None => format!("the scene file `{name}`"),
        Some((base, layer)) => format!("the base `{base}` of the scene file `{}`", layer.name),
    };
    let (place, help) = match named {
        None => (&name, "check the path and the permissions"),
        Some((_, layer)) => (&layer.name, HELP),
    };
    if path.is_dir() {
        let help = "name the scene file in it, such as scene.toml";
        return refuse(place, format!("{what} is a folder, not a scene file"), help);
    }
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) => return refuse(place, format!("cannot read {what}: {error}"), help),
    };
    match String::from_utf8(bytes) {
        Ok(text) => Ok(Layer {
            name,
            text,
            path: path.to_owned(),
        }),
        Err(error) => {
            let sound = &error.as_bytes()[..error.utf8_error().valid_up_to()];
            let line = sound.iter().filter(|byte| **byte == b'\n').count() + 1;
            let help = "save the file with the encoding UTF-8";
            refuse(
                place,
                format!("{what} is not UTF-8 text (line {line})"),
                help,
            )
        }
    }
}

/// A `base` that is left once the files are laid over each other: one that was set, or one in a text
/// without a file.
pub(super) fn misplaced(root: &Node) -> Option<Diagnostic> {
    let item = root.table()?.get(BASE)?;
    let fault = Diagnostic::new("`base` stands in scene files only").at(item.key_span);
    Some(fault.help("name the base in the file that changes it, or run the base itself"))
}

#[cfg(test)]
mod tests {
    use crate::scene::load_file;

    const FIRST: &str = "title = \"First\"\n[geometry]\ntype = \"lattice\"\nsize = [1, 1]\npoints = [4, 4]\n\
                         [fluid]\nviscosity = 1\n[materials.a]\npermeability = 1\nstorage = 1\n\
                         [flow]\n[time]\nend = 1\n";

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    #[test]
    fn a_base_may_have_a_base_relative_to_its_own_folder() {
        let place = folder(&[
            ("first.toml", FIRST),
            (
                "sub/second.toml",
                "base = \"../first.toml\"\n[time]\nend = 2\nstep = 0.5\n",
            ),
            (
                "third.toml",
                "base = \"sub/second.toml\"\n[time]\nend = 3\n",
            ),
        ]);
        let loaded = load_file(&place.path().join("third.toml"), &[]).unwrap();
        let time = &loaded.scene.time;
        assert!((time.end.unwrap().value() - 3.0).abs() < 1e-15);
        assert!((time.step.unwrap().value() - 0.5).abs() < 1e-15);
        assert_eq!(loaded.scene.title.as_deref(), Some("First"));
        assert!(!loaded.resolved_toml().contains("base"));
    }

    #[test]
    fn a_base_that_cannot_be_used_is_named_with_the_file_that_names_it() {
        for (text, words) in [
            (
                "base = \"absent.toml\"\n",
                "cannot read the base `absent.toml` of the scene file",
            ),
            ("base = 3\n", "must be a text, found 3"),
            ("base = \"second.toml\"\n", "leads back to"),
            ("base = \".\"\n", "is a folder"),
        ] {
            let place = folder(&[
                ("second.toml", text),
                ("third.toml", "base = \"second.toml\"\n"),
            ]);
            let told = load_file(&place.path().join("third.toml"), &[])
                .unwrap_err()
                .to_string();
            assert!(
                told.contains(words) && told.contains("second.toml"),
                "{told}"
            );
        }
    }

    #[test]
    fn a_base_cannot_be_set() {
        let place = folder(&[("first.toml", FIRST)]);
        let set = ["base=other.toml".to_owned()];
        let told = load_file(&place.path().join("first.toml"), &set)
            .unwrap_err()
            .to_string();
        assert!(told.contains("`base` stands in scene files only"), "{told}");
    }
}
