//! `perifrac report`.

use std::path::PathBuf;

use crate::study::report_run;

use super::exit::{Failure, print};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder that a run left, such as out/terzaghi
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Puts what a run left on one page.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let page = report_run(&args.folder)?;
    print(&format!("report in {}", page.display()))
}
