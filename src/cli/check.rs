//! `perifrac check`.

use crate::model::{Model, ModelError, sample};
use crate::plan::Plan;
use crate::report::Timers;

use super::common::SceneArgs;
use super::exit::{Failure, print, warn};

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
}

/// Checks a scene: its text, its files, its regions, horizon and wells against its points.
pub fn run(args: &Args) -> Result<(), Failure> {
    let planned = args.scene.plan()?;
    let built = match planned.plan.dimension {
        2 => build::<2>(&planned.plan),
        _ => build::<3>(&planned.plan),
    };
    let (points, warnings) = built.map_err(|error| planned.locate(&error))?;
    planned
        .plan
        .warnings
        .iter()
        .chain(&warnings)
        .for_each(|warning| warn(warning));
    print(&format!(
        "{}: no faults found ({points} points)",
        planned.plan.case
    ))
}

/// Builds all that a run would build; the sample comes first because it fails fast.
fn build<const D: usize>(plan: &Plan) -> Result<(usize, Vec<String>), ModelError> {
    sample::<D>(plan)?;
    let model = Model::<D>::build(plan, &mut Timers::default())?;
    Ok((model.cloud.len(), model.warnings))
}
