//! What several verbs share: naming a scene, overriding it, finding the place of a late error.

use std::path::Path;

use crate::cases;
use crate::effects::EffectError;
use crate::explain::{Explanation, explain};
use crate::geometry::GeometryError;
use crate::model::ModelError;
use crate::plan::{FileError, Plan, resolve_for};
use crate::run::{Examined, RunError, examine_for};
use crate::scene::{self, Diagnostic, LoadedScene, Span};
use crate::schemes;

use super::exit::Failure;
use super::processes::Processes;

/// Scene and overrides, for every verb that reads a scene.
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    /// Path of a scene file, or name of a bundled case or of a variant of it, such as
    /// notched-tension/smoke
    pub scene: String,
    /// Override a key: --set time.end="2 s", --set materials.left.permeability=1e8
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Time scheme: implicit, explicit, semi-implicit, staggered or monolithic (see `perifrac schemes`)
    #[arg(long, value_name = "SCHEME")]
    pub scheme: Option<String>,
    /// Linear solver: NAME or NAME:key=value,… (see `perifrac solvers`)
    #[arg(long, value_name = "SOLVER")]
    pub solver: Option<String>,
}

/// A scene with its plan.
pub struct Planned {
    /// The scene, for places in errors.
    pub loaded: LoadedScene,
    /// The plan.
    pub plan: Plan,
}

impl SceneArgs {
    /// Loads and resolves the scene.
    ///
    /// # Errors
    /// [`Failure::Scene`] or [`Failure::Usage`].
    pub fn plan(&self) -> Result<Planned, Failure> {
        let mut overrides = self.overrides.clone();
        let quoted = |value: &str| toml::Value::from(value).to_string();
        overrides.extend(
            self.scheme
                .as_ref()
                .map(|s| format!("scheme.name={}", quoted(s))),
        );
        overrides.extend(
            self.solver
                .as_ref()
                .map(|s| format!("solver.name={}", quoted(s))),
        );
        let path = Path::new(&self.scene);
        let (case, variant) = match self.scene.split_once('/') {
            Some((case, variant)) => (case, Some(variant)),
            None => (&*self.scene, None),
        };
        let bundled = cases::find(case).filter(|_| !path.is_file());
        let (case, loaded) = match bundled {
            Some(case) => {
                let layers = case
                    .layers(variant)
                    .ok_or_else(|| unknown_variant(case, variant.unwrap_or_default()))?;
                let layers: Vec<(&str, &str)> =
                    layers.iter().map(|(name, text)| (&**name, *text)).collect();
                (
                    self.scene.replace('/', "-"),
                    scene::load_layers(&layers, Path::new(""), &overrides)?,
                )
            }
            None if path.exists() || looks_like_path(&self.scene) => {
                let loaded = scene::load_file(path, &overrides)?;
                // What changes another file is named after the case, as a bundled variant is.
                let is_variant = Path::new(loaded.sources.name()) != path;
                (case_name(path, is_variant), loaded)
            }
            None => return Err(unknown_case(&self.scene)),
        };
        let plan = resolve_for(&loaded, &case, Processes::started().size)?;
        Ok(Planned { loaded, plan })
    }
}

fn looks_like_path(name: &str) -> bool {
    name.contains(['/', '\\']) || name.ends_with(".toml")
}

fn unknown_variant(case: &cases::Case, variant: &str) -> Failure {
    let names: Vec<&str> = case.variants.iter().map(|(name, _)| *name).collect();
    let known = match names.is_empty() {
        true => "it has none".to_owned(),
        false => format!("it has {}", names.join(", ")),
    };
    Failure::Usage(format!(
        "the bundled case \"{}\" has no variant \"{variant}\": {known}",
        case.name
    ))
}

fn unknown_case(name: &str) -> Failure {
    let names = cases::names();
    let guess = scene::closest(name, names.iter().copied())
        .map_or_else(String::new, |guess| format!("; did you mean {guess}?"));
    Failure::Usage(format!(
        "there is no file and no bundled case called \"{name}\"{guess} (bundled: {})",
        names.join(", ")
    ))
}

/// Name of a case from its path: the file's, its folder's for a file called scene.toml, and both for a
/// variant, which is a file that changes another.
fn case_name(path: &Path, is_variant: bool) -> String {
    let text = |name: &std::ffi::OsStr| name.to_string_lossy().into_owned();
    let stem = path.file_stem().map_or("scene".to_owned(), text);
    let whole = std::path::absolute(path).ok();
    let folder = whole.and_then(|path| path.parent()?.file_name().map(text));
    match folder {
        Some(folder) if is_variant => format!("{folder}-{stem}"),
        Some(folder) if stem == "scene" => folder,
        _ => stem,
    }
}

impl Planned {
    /// What the plan will do and cost.
    ///
    /// # Errors
    /// [`Failure::Scene`] for what a run would refuse at its start and estimates can tell.
    pub fn explain(&self) -> Result<Explanation, Failure> {
        let processes = Processes::started().size;
        schemes::check(&self.plan, processes)
            .map_err(|error| self.failure(RunError::refused(&self.plan, error)))?;
        let explained = match self.plan.dimension {
            2 => explain::<2>(&self.plan),
            _ => explain::<3>(&self.plan),
        };
        explained.map_err(|error| self.locate(&error))
    }

    /// What the plan will do and cost, with model and scheme built where that is quick.
    ///
    /// # Errors
    /// [`Failure`] for what a run would refuse at its start.
    pub fn examine(&self) -> Result<Examined, Failure> {
        let processes = Processes::started().size;
        let examined = match self.plan.dimension {
            2 => examine_for::<2>(&self.plan, processes),
            _ => examine_for::<3>(&self.plan, processes),
        };
        examined.map_err(|error| self.failure(error))
    }

    /// An error of a run, underlined in the scene where it has a place there.
    pub fn failure(&self, error: RunError) -> Failure {
        match error {
            RunError::Model(error) => self.locate(&error),
            other => other.into(),
        }
    }

    /// An error of the model, underlined in the scene where it has a place there.
    pub fn locate(&self, error: &ModelError) -> Failure {
        let diagnostic = Diagnostic::new(error.to_string());
        let diagnostic = match self.place(error) {
            Some(place) => diagnostic.at(place),
            None => diagnostic,
        };
        let diagnostic = match self.remedy(error) {
            Some(help) => diagnostic.help(help),
            None => diagnostic,
        };
        self.loaded.errors(vec![diagnostic]).into()
    }

    fn place(&self, error: &ModelError) -> Option<Span> {
        let scene = &self.loaded.scene;
        let material = |name: &String| scene.materials.get(name);
        let well = |name: &String| scene.wells.get(name).map(|well| well.at.span);
        let horizon = match scene.horizon.span() {
            span if span.is_somewhere() => span,
            _ => scene.geometry.span,
        };
        match error {
            ModelError::Geometry(GeometryError::TooLarge { .. })
            | ModelError::Generate(_)
            | ModelError::Unresolved { .. } => Some(scene.geometry.span),
            ModelError::Geometry(_) => Some(horizon),
            ModelError::CrackThroughPoint { name, .. }
            | ModelError::CrackAtBoundary { name, .. } => {
                scene.cracks.get(name).map(scene::Crack::span)
            }
            ModelError::EmptyRegion { material: name }
            | ModelError::CoveredRegion { material: name }
            | ModelError::UnusedRegion { material: name } => {
                material(name)?.region.as_ref().map(|region| region.span)
            }
            ModelError::EmptyBand { name } => scene.cracks.get(name).map(scene::Crack::span),
            ModelError::ProbeOffPoints { what, name, .. } => match *what {
                "output.probes" => Some(scene.output.probes.get(name)?.at.span),
                _ => Some(scene.output.profiles.get(name)?.from.span),
            },
            ModelError::EmptyPressureRegion { number }
            | ModelError::CoveredPressureRegion { number } => scene
                .flow
                .as_ref()?
                .regions
                .get(number - 1)
                .map(|region| region.region.span),
            ModelError::Table(FileError::Length { path, .. }) => {
                scene
                    .materials
                    .iter()
                    .find_map(|entry| match entry.value.permeability.as_deref() {
                        Some(scene::PermeabilityField::File(file))
                            if Path::new(&file.file.value) == path =>
                        {
                            Some(file.file.span)
                        }
                        _ => None,
                    })
            }
            ModelError::Points { .. } | ModelError::UnknownMaterial { .. } => {
                match &scene.geometry.value {
                    scene::Geometry::File(file) => Some(file.path.span),
                    _ => Some(scene.geometry.span),
                }
            }
            ModelError::NoMaterial { .. } => scene.materials.iter().next().map(|entry| entry.span),
            ModelError::Effect(EffectError::EmptyWell { name, .. }) => well(name),
            ModelError::Effect(EffectError::EmptyInjection { name, .. }) => {
                Some(scene.cracks.get(name)?.injection.as_ref()?.at.span)
            }
            ModelError::Effect(EffectError::OverlappingWells { second, .. }) => well(second),
            ModelError::Effect(EffectError::EmptyLoad { name, .. }) => {
                let mut loads = scene.mechanics.as_ref()?.loads.iter();
                loads.find(|entry| entry.name == *name).map(|e| e.span)
            }
            ModelError::MissingProperty { material: name, .. } => {
                let mut materials = scene.materials.iter();
                materials.find(|entry| entry.name == *name).map(|e| e.span)
            }
            ModelError::Consistency(_) => match (&scene.flow, &scene.mechanics) {
                (Some(flow), _) => Some(flow.gradient.span),
                (None, mechanics) => Some(mechanics.as_ref()?.gradient.span),
            },
            _ => None,
        }
    }

    /// What to do where the error itself cannot know the keys of a scene.
    fn remedy(&self, error: &ModelError) -> Option<&'static str> {
        match error {
            ModelError::Geometry(GeometryError::TooFewPoints { .. }) => Some(
                "add points, or set horizon.neighbours to fewer, or horizon.radius to a length",
            ),
            ModelError::Effect(EffectError::EmptyWell { .. }) => {
                Some("enlarge its radius, leave the radius out, or refine the cloud there")
            }
            ModelError::MissingProperty { .. } => {
                Some("add it to the material, or take out the section that asks for it")
            }
            ModelError::Consistency(_) if self.loaded.scene.flow.is_none() => {
                Some("here it is mechanics.gradient that asks for it; \"plain\" does without")
            }
            _ => None,
        }
    }
}
