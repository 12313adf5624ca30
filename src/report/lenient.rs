//! Figures that are no numbers.

use serde::{Deserialize, Deserializer};

/// Reads a figure that may be infinite or no number, which JSON has no words for but `null`.
///
/// # Errors
/// Those of the deserialiser.
pub fn lenient<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    match deserializer.is_human_readable() {
        true => Option::deserialize(deserializer).map(|figure| figure.unwrap_or(f64::NAN)),
        false => f64::deserialize(deserializer),
    }
}
