//! `perifrac plan --for-error`: a forecast from a calibration.

use std::time::Duration;

use crate::run::Snapshot;
use crate::study::{self, Campaign, Options};

use super::common::SceneArgs;
use super::exit::{Failure, print};
use super::interrupt::handled;
use super::study::subject;

/// Time of the calibration, and of its longest run.
const CALIBRATION: (Duration, Duration) = (Duration::from_secs(40), Duration::from_secs(5));

/// Says which scheme, solver and step reach an error, and what that will cost.
pub(super) fn run(scene: &SceneArgs, error: f64, json: bool) -> Result<(), Failure> {
    let subject = subject(&scene.scene, &scene.sets())?;
    let options = Options {
        schemes: scene.scheme.iter().cloned().collect(),
        solvers: scene.solver.iter().cloned().collect(),
        ..Options::default()
    };
    let variants = study::calibration(&subject, &options)?;
    let folder = tempfile::tempdir().map_err(study::StudyError::Program)?;
    let interrupt = handled(&Snapshot::default());
    let mut campaign = Campaign::new(&subject, folder.path(), 1, CALIBRATION, &interrupt)?;
    let (mut runs, _) = campaign.run(&variants, &mut ())?;
    if interrupt.is_raised() {
        return Err(Failure::Interrupted("during the calibration".to_owned()));
    }
    study::compare_costs(&mut runs);
    let forecast = study::forecast(&subject, &runs, error)?;
    match json {
        true => print(&serde_json::to_string_pretty(&forecast).unwrap_or_default()),
        false => print(&forecast.to_string()),
    }
}

/// An error, relative to the solution.
pub(super) fn error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error < 1.0 => Ok(error),
        _ => Err("a number between 0 and 1, such as 1e-3".to_owned()),
    }
}
