//! From a scene in a program to a plan, in one go.

use std::path::{Path, PathBuf};

use super::{OwnEffect, Plan, PointTable, resolve::resolve_given};
use crate::scene::{LoadedScene, SceneErrors, load_file, load_layers, load_str};

/// What becomes a [`Plan`]: a scene, changes to it, and what no scene can hold, points and effects of the
/// program itself.
///
/// ```
/// use perifrac::prelude::*;
///
/// let scene = r#"
///     title = "A square that drains to the left"
///     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
///     fluid.viscosity = "1 mPa s"
///     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
///     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
///     time.end = "1 s"
/// "#;
/// let plan = Setup::text(scene).set("time.end", "2 s").plan()?;
/// assert_eq!(plan.time.end, 2.0);
/// let wrong = Setup::text(scene).set("time.ned", "2 s").plan();
/// assert!(wrong.is_err_and(|errors| errors.to_string().contains("did you mean `end`?")));
/// # Ok::<(), SceneErrors>(())
/// ```
#[derive(Debug, Clone)]
pub struct Setup {
    scene: Source,
    changes: Vec<String>,
    points: Option<PointTable>,
    effects: Vec<OwnEffect>,
}

/// Name of points that are handed in.
const POINTS: &str = "points-of-the-program.csv";

#[derive(Debug, Clone)]
enum Source {
    Text(String),
    File(PathBuf),
    Layers(Layers),
}

/// Texts of which each changes those before it.
#[derive(Debug, Clone)]
struct Layers {
    case: String,
    /// The texts, each after its name for messages.
    texts: Vec<(String, String)>,
    base: PathBuf,
}

impl Setup {
    /// A scene as TOML; paths in it are relative to the working directory.
    pub fn text(scene: impl Into<String>) -> Self {
        Self::new(Source::Text(scene.into()))
    }

    /// A scene file; paths in it are relative to its folder.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self::new(Source::File(path.into()))
    }

    /// Texts in TOML of which each changes those before it, each after its name for messages: a bundled case with a
    /// variant, or the scene that a checkpoint holds. `case` is the name in reports, and paths are relative
    /// to `base`.
    pub fn layers(
        case: impl Into<String>,
        texts: Vec<(String, String)>,
        base: impl Into<PathBuf>,
    ) -> Self {
        Self::new(Source::Layers(Layers {
            case: case.into(),
            texts,
            base: base.into(),
        }))
    }

    fn new(scene: Source) -> Self {
        Setup {
            scene,
            changes: Vec::new(),
            points: None,
            effects: Vec::new(),
        }
    }

    /// Changes a key of the scene, as `--set key=value` does.
    #[must_use]
    pub fn set(mut self, key: &str, value: &str) -> Self {
        self.changes.push(format!("{key}={value}"));
        self
    }

    /// Takes these points as the cloud. The section `[geometry]` of the scene then holds only `bounds` and
    /// what else goes with points from a file; messages call them `points-of-the-program.csv`.
    #[must_use]
    pub fn points(mut self, points: PointTable) -> Self {
        self.points = Some(points);
        self.set("geometry.type", "file")
            .set("geometry.path", POINTS)
    }

    /// Adds an effect of the program itself.
    #[must_use]
    pub fn effect(mut self, effect: OwnEffect) -> Self {
        self.effects.push(effect);
        self
    }

    /// The plan.
    ///
    /// # Errors
    /// [`SceneErrors`] with every fault of the scene and its place.
    pub fn plan(&self) -> Result<Plan, SceneErrors> {
        self.plan_of(&self.load()?)
    }

    /// The plan of the scene that [`Setup::load`] gave, for who needs both.
    ///
    /// # Errors
    /// As [`Setup::plan`].
    pub fn plan_of(&self, loaded: &LoadedScene) -> Result<Plan, SceneErrors> {
        let mut plan = resolve_given(loaded, &self.name(), self.points.as_ref())?;
        plan.own_effects.clone_from(&self.effects);
        Ok(plan)
    }

    /// The scene with its changes: its text, and the places of faults that are found later.
    ///
    /// # Errors
    /// [`SceneErrors`] of what is wrong with the text.
    pub fn load(&self) -> Result<LoadedScene, SceneErrors> {
        match &self.scene {
            Source::Text(text) => load_str("scene", text, Path::new(""), &self.changes),
            Source::File(path) => load_file(path, &self.changes),
            Source::Layers(layers) => {
                let texts = layers.texts.iter();
                let texts: Vec<_> = texts.map(|(name, text)| (&**name, &**text)).collect();
                load_layers(&texts, &layers.base, &self.changes)
            }
        }
    }

    /// The name of the case in reports: that of the file.
    fn name(&self) -> String {
        let stem = match &self.scene {
            Source::Text(_) => None,
            Source::File(path) => path.file_stem(),
            Source::Layers(layers) => return layers.case.clone(),
        };
        stem.map_or_else(
            || "scene".into(),
            |stem| stem.to_string_lossy().into_owned(),
        )
    }
}
