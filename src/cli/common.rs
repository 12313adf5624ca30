//! What several verbs share: naming a scene, overriding it, finding the place of a late error.

use std::borrow::Cow;
use std::path::Path;

use crate::cases;
use crate::explain::{Explanation, explain};
use crate::model::ModelError;
use crate::output::CheckpointError;
use crate::plan::{Plan, resolve_for};
use crate::run::{Examined, RunError, examine, locate};
use crate::scene::{self, Diagnostic, LoadedScene, Override, SceneErrors};
use crate::schemes;

use super::completions;
use super::exit::Failure;
use super::processes::Processes;

/// Scene and overrides, for every verb that reads a scene.
#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// Path of a scene file, or name of a bundled case or of a variant of it, such as
    /// notched-tension/smoke
    #[arg(add = completions::scenes())]
    pub scene: String,
    /// Override a key: --set time.end="2 s", --set materials.left.permeability=1e8
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Time scheme: implicit, explicit, semi-implicit, staggered or monolithic (see `perifrac schemes`)
    #[arg(long, value_name = "SCHEME", add = completions::schemes())]
    pub scheme: Option<String>,
    /// Linear solver: NAME or NAME:key=value,… (see `perifrac solvers`)
    #[arg(long, value_name = "SOLVER", add = completions::solvers())]
    pub solver: Option<String>,
    /// End of the run, such as "30 s", a bare number in seconds; outputs after it are left out. Of a scene in stages
    /// it is the end of the last one
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    pub end: Option<String>,
}

/// A scene with its plan.
pub(super) struct Planned {
    /// The scene, for places in errors.
    pub loaded: LoadedScene,
    /// The plan.
    pub plan: Plan,
    /// Whether it is a stage that starts with the state in which the one before it ends.
    pub follows: bool,
}

/// What a scene asks for: one run, or several that follow each other.
pub(super) enum Asked {
    /// One run.
    One(Box<Planned>),
    /// Stages with their names, each of which goes on where the one before it ended.
    Stages(Vec<(String, Planned)>),
}

impl Asked {
    /// Name of the case.
    pub(super) fn case(&self) -> &str {
        match self {
            Asked::One(planned) => &planned.plan.case,
            Asked::Stages(stages) => stages.first().map_or("", |(_, planned)| &planned.plan.case),
        }
    }

    /// All runs, with the names of stages.
    pub(super) fn all(&self) -> Vec<(Option<&str>, &Planned)> {
        match self {
            Asked::One(planned) => vec![(None, planned)],
            Asked::Stages(stages) => stages
                .iter()
                .map(|(name, planned)| (Some(&**name), planned))
                .collect(),
        }
    }
}

/// Texts of a scene, each of which changes those before it, with the name of its case and the folder that its
/// paths are relative to.
type Texts<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a Path);

impl SceneArgs {
    /// Loads and resolves the scene.
    ///
    /// # Errors
    /// [`Failure::Scene`] or [`Failure::Usage`].
    pub(super) fn ask(&self) -> Result<Asked, Failure> {
        let overrides = self.all_overrides();
        let end: Vec<Override> = self.end().into_iter().collect();
        self.with_texts(|(layers, case, base)| {
            let planned = |loaded: LoadedScene, follows| {
                let loaded = loaded.titled(case);
                Planned::resolve(loaded, case, follows)
            };
            let Some(stages) = scene::load_stages(layers, base, &overrides, &end)? else {
                let overrides = [&overrides[..], &end].concat();
                let loaded = scene::load_layers(layers, base, &overrides)?;
                self.check_end(&loaded)?;
                return planned(loaded, false).map(|one| Asked::One(Box::new(one)));
            };
            if let Some(last) = stages.last() {
                self.check_end(&last.loaded)?;
            }
            let stages = stages
                .into_iter()
                .enumerate()
                .map(|(number, stage)| Ok((stage.name, planned(stage.loaded, number > 0)?)));
            stages
                .collect::<Result<_, SceneErrors>>()
                .map(Asked::Stages)
        })
    }

    #[cfg(feature = "study")]
    /// As [`SceneArgs::ask`], where only one run will do.
    ///
    /// # Errors
    /// As there; [`Failure::Usage`] for a scene in stages.
    pub(super) fn plan(&self) -> Result<Planned, Failure> {
        match self.ask()? {
            Asked::One(planned) => Ok(*planned),
            Asked::Stages(_) => Err(Failure::Usage(format!(
                "{} has stages, which `perifrac run` runs one after the other; give a scene without [[stages]]",
                self.scene
            ))),
        }
    }

    /// `--end` as a change of the scene.
    fn end(&self) -> Option<Override> {
        let end = self.end.as_deref()?;
        Some(Override::by_option("--end", "time.end", end))
    }

    /// Keys that are set where there is one run, without scheme and solver.
    #[cfg(feature = "study")]
    pub(super) fn sets(&self) -> Vec<String> {
        let end = self.end().map(|end| end.text().to_owned());
        self.overrides.iter().cloned().chain(end).collect()
    }

    /// Refuses an end of what does not pass in time.
    fn check_end(&self, loaded: &LoadedScene) -> Result<(), SceneErrors> {
        let time = &loaded.scene.time;
        if self.end.is_none() || !time.is_steady() {
            return Ok(());
        }
        let fault = Diagnostic::new("a steady run has no `--end`").at(time.mode.span);
        let fault = fault.help("leave it out, or set time.mode=\"transient\"");
        Err(loaded.errors(vec![fault]))
    }

    fn all_overrides(&self) -> Vec<Override> {
        let named = [
            ("--scheme", "scheme.name", &self.scheme),
            ("--solver", "solver.name", &self.solver),
        ];
        let named = named.into_iter().filter_map(|(option, key, typed)| {
            Some(Override::by_option(option, key, typed.as_deref()?))
        });
        self.overrides
            .iter()
            .cloned()
            .map(Override::from)
            .chain(named)
            .collect()
    }

    /// Hands the texts of the scene to `load`.
    fn with_texts<T>(
        &self,
        load: impl FnOnce(Texts<'_>) -> Result<T, SceneErrors>,
    ) -> Result<T, Failure> {
        let path = Path::new(&self.scene);
        let (case, variant) = match self.scene.split_once('/') {
            Some((case, variant)) => (case, Some(variant)),
            None => (&*self.scene, None),
        };
        let bundled = cases::find(case).filter(|_| !path.is_file());
        if let Some(case) = bundled {
            let layers = case
                .layers(variant)
                .ok_or_else(|| unknown_variant(case, variant.unwrap_or_default()))?;
            let layers: Vec<(&str, &str)> =
                layers.iter().map(|(name, text)| (&**name, *text)).collect();
            let name = self.scene.replace('/', "-");
            return Ok(load((&layers, &name, Path::new("")))?);
        }
        if !path.exists() && !looks_like_path(&self.scene) {
            return Err(unknown_case(&self.scene));
        }
        Ok(scene::with_layers(path, |layers, base| {
            // What changes another file is named after the case, as a bundled variant is.
            load((layers, &case_name(path, layers.len() > 1), base))
        })?)
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
    /// Resolves a scene for the processes that were started.
    ///
    /// # Errors
    /// [`SceneErrors`].
    pub(super) fn resolve(
        loaded: LoadedScene,
        case: &str,
        follows: bool,
    ) -> Result<Self, SceneErrors> {
        let plan = resolve_for(&loaded, case, Processes::started().size)?;
        Ok(Planned {
            loaded,
            plan,
            follows,
        })
    }

    /// What the plan will do and cost.
    ///
    /// # Errors
    /// [`Failure::Scene`] for what a run would refuse at its start and estimates can tell.
    pub(super) fn explain(&self) -> Result<Explanation, Failure> {
        let processes = Processes::started().size;
        schemes::check(&self.plan, processes)
            .map_err(|error| self.failure(RunError::refused(&self.plan, error)))?;
        explain(&self.plan).map_err(|error| self.locate(&error))
    }

    /// What the plan will do and cost, with model and scheme built where that is quick.
    ///
    /// # Errors
    /// [`Failure`] for what a run would refuse at its start.
    pub(super) fn examine(&self) -> Result<Examined, Failure> {
        let processes = Processes::started().size;
        let plan = self.startable();
        examine(&plan, processes).map_err(|error| self.failure(error))
    }

    /// The plan without a start that only the stage before will have made.
    fn startable(&self) -> Cow<'_, Plan> {
        match self.follows {
            true => Cow::Owned(Plan {
                start: None,
                ..self.plan.clone()
            }),
            false => Cow::Borrowed(&self.plan),
        }
    }

    /// An error of a run, underlined in the scene where it has a place there.
    pub(super) fn failure(&self, error: RunError) -> Failure {
        match (error, &self.loaded.scene.start) {
            (RunError::Model(error), _) => self.locate(&error),
            (RunError::Start(error), Some(start)) if !self.follows => {
                let fault = Diagnostic::new(error.to_string()).at(start.from.span);
                let fault = match error {
                    CheckpointError::Output(_) => fault.help(
                        "name the folder of a run with checkpoints, or one of them, relative to the scene file",
                    ),
                    _ => fault,
                };
                self.loaded.errors(vec![fault]).into()
            }
            (other, _) => other.into(),
        }
    }

    /// An error of the model, underlined in the scene where it has a place there.
    pub(super) fn locate(&self, error: &ModelError) -> Failure {
        locate(&self.loaded, error).into()
    }
}
