//! `perifrac check`.

use crate::model::sample;

use super::common::SceneArgs;
use super::exit::{Failure, print};

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
}

/// Checks a scene: its text, its files, its regions and wells against its points.
pub fn run(args: &Args) -> Result<(), Failure> {
    let planned = args.scene.plan()?;
    let sampled = match planned.plan.dimension {
        2 => sample::<2>(&planned.plan),
        _ => sample::<3>(&planned.plan),
    };
    let sampled = sampled.map_err(|error| planned.locate(&error))?;
    planned
        .plan
        .warnings
        .iter()
        .for_each(|warning| eprintln!("warning: {warning}"));
    print(&format!(
        "{}: no faults found ({} points)",
        planned.plan.case, sampled.points
    ))
}
