//! In place of drawing, in a library built without the feature `plots`: nothing is drawn.

use std::path::Path;

use super::{FieldPlot, LinePlot, Multiples, PathPlot};
use crate::output::OutputError;

/// Draws nothing.
///
/// # Errors
/// None.
pub fn field_png(_path: impl AsRef<Path>, _plot: &FieldPlot<'_>) -> Result<(), OutputError> {
    Ok(())
}

/// Draws nothing.
///
/// # Errors
/// None.
pub fn multiples_png(_path: impl AsRef<Path>, _plot: &Multiples<'_>) -> Result<(), OutputError> {
    Ok(())
}

/// Draws nothing.
///
/// # Errors
/// None.
pub fn animation_png(
    _path: impl AsRef<Path>,
    _plot: &Multiples<'_>,
    _seconds_per_frame: f64,
) -> Result<(), OutputError> {
    Ok(())
}

/// Draws nothing.
///
/// # Errors
/// None.
pub fn lines_svg(_path: impl AsRef<Path>, _plot: &LinePlot<'_>) -> Result<(), OutputError> {
    Ok(())
}

/// Draws nothing.
///
/// # Errors
/// None.
pub fn paths_svg(_path: impl AsRef<Path>, _plot: &PathPlot<'_>) -> Result<(), OutputError> {
    Ok(())
}
