//! `perifrac report`.

use std::path::PathBuf;

use crate::study::{draw_frames, report_run};

use super::exit::{Failure, print};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder that a run left, such as out/terzaghi
    #[arg(value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    folder: PathBuf,
    /// Draw a field at all outputs, and an animation of it, such as velocity, effective_stress_xy or displacement_x;
    /// may be given several times
    #[arg(long, value_name = "FIELD")]
    frames: Vec<String>,
}

/// Puts what a run left on one page.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    for field in &args.frames {
        let pictures = draw_frames(&args.folder, field)?;
        print(&format!("{} pictures of {field}", pictures.len()))?;
    }
    let page = report_run(&args.folder)?;
    print(&format!("report in {}", page.display()))
}
