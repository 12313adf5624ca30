//! `perifrac schema`.

use serde_json::{Value, json};

use crate::run::COLUMNS;
use crate::scene::json_schema;

use super::exit::{Failure, print};

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Print every column of every table that runs and studies write instead: file, name, unit, what a scene must have
    /// for it, and meaning, as JSON
    #[arg(long)]
    columns: bool,
}

/// Prints the JSON Schema of scenes, or the columns of tables.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let told: Value = match args.columns {
        true => json!(columns()),
        false => json!(json_schema()),
    };
    print(&serde_json::to_string_pretty(&told).unwrap_or_default())
}

fn columns() -> Vec<crate::run::Column> {
    #[cfg(feature = "study")]
    return [COLUMNS, crate::study::COLUMNS].concat();
    #[cfg(not(feature = "study"))]
    COLUMNS.to_vec()
}
