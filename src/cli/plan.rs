//! `perifrac plan`.

use crate::explain::explain;

use super::common::SceneArgs;
use super::exit::{Failure, print};

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// Explains a scene.
pub fn run(args: &Args) -> Result<(), Failure> {
    let planned = args.scene.plan()?;
    let explanation = match planned.plan.dimension {
        2 => explain::<2>(&planned.plan),
        _ => explain::<3>(&planned.plan),
    };
    let explanation = explanation.map_err(|error| planned.locate(&error))?;
    if args.json {
        return print(&serde_json::to_string_pretty(&explanation).unwrap_or_default());
    }
    print(&explanation.to_string())
}
