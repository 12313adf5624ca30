//! `perifrac plan`.

use crate::explain::Choices;
use crate::plan::Plan;

use super::common::SceneArgs;
use super::exit::{Failure, print};
#[cfg(feature = "study")]
use super::forecast;
use super::memory;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[cfg(feature = "study")]
    /// Say which scheme, solver and step reach this error, and what that will cost, from a calibration
    /// of some seconds on this machine
    #[arg(long, value_name = "ERROR", value_parser = forecast::error)]
    for_error: Option<f64>,
    /// Print what to choose for which problem instead, with the row of this scene marked
    #[cfg_attr(feature = "study", arg(long, conflicts_with = "for_error"))]
    #[cfg_attr(not(feature = "study"), arg(long))]
    choices: bool,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// Explains a scene.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    #[cfg(feature = "study")]
    if let Some(error) = args.for_error {
        return forecast::run(&args.scene, error, args.json);
    }
    let asked = args.scene.ask()?;
    for (stage, planned) in asked.all() {
        if args.choices {
            tell_choices(args, stage, &planned.plan)?;
            continue;
        }
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

/// Prints what to choose, for a scene or a stage of it.
fn tell_choices(args: &Args, stage: Option<&str>, plan: &Plan) -> Result<(), Failure> {
    let choices = Choices::of(plan);
    if args.json {
        return print(&serde_json::to_string_pretty(&choices).unwrap_or_default());
    }
    if let Some(stage) = stage {
        print(&format!("stage {stage}"))?;
    }
    print(&choices.to_string())
}
