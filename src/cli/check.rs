//! `perifrac check`.

use super::common::{Planned, SceneArgs};
use super::exit::{Failure, print, warn};
use super::memory;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
}

/// Checks a scene: its text, its files, its regions, horizon and wells against its points, and whether
/// its scheme can run it. What is too large to be built in about a second is judged by estimates.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let asked = args.scene.ask()?;
    for (stage, planned) in asked.all() {
        check(stage, planned)?;
    }
    Ok(())
}

fn check(stage: Option<&str>, planned: &Planned) -> Result<(), Failure> {
    let examined = planned.examine()?;
    let explanation = &examined.explanation;
    explanation
        .warnings
        .iter()
        .for_each(|warning| warn(warning));
    memory::shortage(&explanation.memory, None)
        .iter()
        .for_each(|shortage| warn(shortage));
    let how = match examined.built {
        true => "",
        false => ", by estimates: regions, wells and cracks meet the points only in the run",
    };
    let stage = stage.map_or(String::new(), |name| format!(", stage {name}"));
    print(&format!(
        "{}{stage}: no faults found ({} points{how})",
        planned.plan.case, explanation.points
    ))
}
