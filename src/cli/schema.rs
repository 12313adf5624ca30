//! `perifrac schema`.

use crate::scene::json_schema;

use super::exit::{Failure, print};

/// Prints the JSON Schema of scenes.
pub(super) fn run() -> Result<(), Failure> {
    print(&serde_json::to_string_pretty(&json_schema()).unwrap_or_default())
}
