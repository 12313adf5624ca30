//! `perifrac man`.

use std::path::PathBuf;

use crate::output::OutputError;

use super::exit::{Failure, print};

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder for the pages, made if it is not there
    #[arg(value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    folder: PathBuf,
}

/// Writes a page for the program and one for each of its verbs, from the same words as `--help`.
pub(super) fn run(args: &Args, command: clap::Command) -> Result<(), Failure> {
    let folder = &args.folder;
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(command, folder))
        .map_err(|error| OutputError::from_io(folder, "write the pages", error))?;
    let folder = folder.display();
    print(&format!(
        "pages in {folder}; read one with: man {folder}/perifrac.1"
    ))
}
