//! Scenes: from the texts and changes that Python keeps to a plan.

use std::path::{Path, PathBuf};

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use perifrac::cases::{CASES, find};
use perifrac::prelude::{Checkpoint, LoadedScene, Plan, PointTable, Setup, TableError, examine};
use perifrac::scene::{Override, load_stages, with_layers};
use pyo3::prelude::*;

use crate::errors::{Fault, raised};

/// Texts of a scene, each after its name for messages.
type Layers = Vec<(String, String)>;

/// Points of a program: coordinates, volumes, permeabilities and names of materials.
type Points<'py> = (
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    Option<PyReadonlyArray1<'py, f64>>,
    Option<Vec<String>>,
);

/// What becomes a plan: texts, each of which changes those before it, changes of single keys, and points.
#[pyclass(frozen)]
pub(crate) struct Recipe {
    case: String,
    layers: Layers,
    base: PathBuf,
    changes: Vec<(String, String)>,
    points: Option<PointTable>,
}

/// A scene in stages as texts of its own: name, text and folder of each.
type Stages = Vec<(String, String)>;

#[pymethods]
impl Recipe {
    #[new]
    #[pyo3(signature = (case, layers, base, changes, points=None))]
    fn new(
        py: Python<'_>,
        case: String,
        layers: Layers,
        base: PathBuf,
        changes: Vec<(String, String)>,
        points: Option<Points<'_>>,
    ) -> PyResult<Self> {
        let points = points.map(table).transpose();
        Ok(Recipe {
            case,
            layers,
            base,
            changes,
            points: raised(py, points)?,
        })
    }

    /// The scene with its changes as TOML.
    fn resolved(&self, py: Python<'_>) -> PyResult<String> {
        let loaded = raised(py, self.setup().load())?;
        Ok(loaded.resolved_toml())
    }

    /// The same as JSON.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        let text = self.resolved(py)?;
        let value: Result<serde_json::Value, _> = toml::from_str(&text);
        let value = raised(py, value.map_err(|error| Fault::new("SceneError", error)))?;
        Ok(value.to_string())
    }

    /// What the plan will do and cost: as text and as JSON, its warnings, and whether the model was built.
    fn plan(&self, py: Python<'_>) -> PyResult<(String, String, Vec<String>, bool)> {
        let examined = py.detach(|| {
            let (loaded, plan) = self.planned()?;
            examine(&plan, 1).map_err(|error| Fault::of_run(&loaded, &error))
        });
        let examined = raised(py, examined)?;
        let explanation = &examined.explanation;
        let json = serde_json::to_string(explanation).unwrap_or_default();
        let warnings = explanation.warnings.clone();
        Ok((explanation.to_string(), json, warnings, examined.built))
    }

    /// Names and texts of the stages, if the scene has stages.
    fn stages(&self, py: Python<'_>) -> PyResult<Option<Stages>> {
        let layers = self.layers.iter();
        let layers: Vec<(&str, &str)> = layers.map(|(name, text)| (&**name, &**text)).collect();
        let changes = self.changes.iter().map(joined).map(Override::from);
        let changes: Vec<Override> = changes.collect();
        let stages = raised(py, load_stages(&layers, &self.base, &changes, &[]))?;
        Ok(stages.map(|stages| {
            let text = |stage: perifrac::scene::Stage| (stage.name, stage.loaded.resolved_toml());
            stages.into_iter().map(text).collect()
        }))
    }
}

impl Recipe {
    /// The scene as the library takes it.
    pub(crate) fn setup(&self) -> Setup {
        let layers = self.layers.clone();
        let mut setup = Setup::layers(&*self.case, layers, &*self.base);
        for (key, value) in &self.changes {
            setup = setup.set(key, value);
        }
        match &self.points {
            Some(points) => setup.points(points.clone()),
            None => setup,
        }
    }

    fn planned(&self) -> Result<(LoadedScene, Plan), Fault> {
        let setup = self.setup();
        let loaded = setup.load()?;
        let plan = setup.plan_of(&loaded)?;
        Ok((loaded, plan))
    }
}

fn joined((key, value): &(String, String)) -> String {
    format!("{key}={value}")
}

/// Points as the library takes them.
fn table((position, volume, permeability, material): Points<'_>) -> Result<PointTable, Fault> {
    let unfit = |error: TableError| Fault::new("CloudError", error);
    let slice = |error: numpy::AsSliceError| Fault::new("CloudError", error);
    let dimension = position.as_array().ncols();
    let mut table = PointTable::new(
        dimension,
        position.as_slice().map_err(slice)?,
        volume.as_slice().map_err(slice)?,
    )
    .map_err(unfit)?;
    if let Some(own) = permeability {
        let own = own.as_slice().map_err(slice)?;
        table = table.with_permeability(own).map_err(unfit)?;
    }
    match material {
        Some(names) => table.with_materials(&names).map_err(unfit),
        None => Ok(table),
    }
}

/// Name, summary, README and variants of all bundled cases.
#[pyfunction]
pub(crate) fn cases() -> Vec<(&'static str, &'static str, &'static str, Vec<&'static str>)> {
    let variants = |case: &perifrac::cases::Case| {
        let names = case.variants.iter().map(|(name, _)| *name);
        names.collect()
    };
    let told = CASES.iter();
    told.map(|case| (case.name, case.summary, case.readme, variants(case)))
        .collect()
}

/// Texts of a bundled case, or of a variant of it; nothing if there is none.
#[pyfunction]
#[pyo3(signature = (name, variant=None))]
pub(crate) fn case_layers(name: &str, variant: Option<&str>) -> Option<Layers> {
    let layers = find(name)?.layers(variant)?;
    let owned = |(name, text): (String, &str)| (name, text.to_owned());
    Some(layers.into_iter().map(owned).collect())
}

/// Texts of a scene file and of those that it changes, and the folder that its paths are relative to.
#[pyfunction]
pub(crate) fn file_layers(py: Python<'_>, path: PathBuf) -> PyResult<(Layers, PathBuf)> {
    let read = with_layers(&path, |layers, base| {
        let owned = |(name, text): &(&str, &str)| ((*name).to_owned(), (*text).to_owned());
        Ok((layers.iter().map(owned).collect(), base.to_owned()))
    });
    raised(py, read)
}

/// What a checkpoint, or the newest one in a folder, says of its run: file, case, scene, folder of its paths, time,
/// steps, and whether the run had reached its end.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub(crate) fn checkpoint(
    py: Python<'_>,
    path: PathBuf,
) -> PyResult<(PathBuf, String, String, PathBuf, f64, u64, bool)> {
    let opened = Checkpoint::open(&path).map_err(|error| Fault::new("CheckpointError", error));
    let Checkpoint {
        path,
        header,
        record,
    } = raised(py, opened)?;
    let (time, steps, finished) = (header.time, header.steps, header.finished);
    Ok((
        path,
        header.case,
        record.scene,
        record.base,
        time,
        steps,
        finished,
    ))
}

/// Puts what a run left in a folder on one page.
#[pyfunction]
pub(crate) fn report(py: Python<'_>, folder: PathBuf) -> PyResult<PathBuf> {
    let page = py.detach(|| perifrac::report_run(Path::new(&folder)));
    raised(py, page.map_err(|error| Fault::new("OutputError", error)))
}
