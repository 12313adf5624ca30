//! `perifrac plan`.

use std::time::Duration;

use crate::run::Snapshot;
use crate::study::{self, Campaign, Options};

use super::common::SceneArgs;
use super::exit::{Failure, print};
use super::interrupt::handled;
use super::memory;
use super::study::subject;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Say which scheme, solver and step reach this error, and what that will cost, from a calibration
    /// of some seconds on this machine
    #[arg(long, value_name = "ERROR", value_parser = error)]
    for_error: Option<f64>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// Explains a scene.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(error) = args.for_error {
        return forecast(args, error);
    }
    let asked = args.scene.ask()?;
    for (stage, planned) in asked.all() {
        let mut explanation = planned.examine()?.explanation;
        let shortage = memory::shortage(&explanation.memory, None);
        explanation.warnings.extend(shortage);
        if let (Some(stage), false) = (stage, args.json) {
            print(&format!("stage {stage}"))?;
        }
        match args.json {
            true => print(&serde_json::to_string_pretty(&explanation).unwrap_or_default())?,
            false => print(&explanation.to_string())?,
        }
    }
    Ok(())
}

/// Time of the calibration, and of its longest run.
const CALIBRATION: (Duration, Duration) = (Duration::from_secs(40), Duration::from_secs(5));

fn forecast(args: &Args, error: f64) -> Result<(), Failure> {
    let subject = subject(&args.scene.scene, &args.scene.overrides)?;
    let options = Options {
        schemes: args.scene.scheme.iter().cloned().collect(),
        solvers: args.scene.solver.iter().cloned().collect(),
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
    match args.json {
        true => print(&serde_json::to_string_pretty(&forecast).unwrap_or_default()),
        false => print(&forecast.to_string()),
    }
}

fn error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error < 1.0 => Ok(error),
        _ => Err("a number between 0 and 1, such as 1e-3".to_owned()),
    }
}
