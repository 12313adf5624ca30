//! A field over time as an animated picture.

use std::path::Path;

use super::Multiples;
use super::field::draw_in;
use super::multiples::unsupported;
use super::raster::encode_animation;
use crate::output::{OutputError, write_atomically};

/// Limits of the time each frame is shown, s.
const DELAYS: (f64, f64) = (0.01, 60.0);

/// Draws all frames of a field as an animated PNG picture (APNG) that runs without end, written
/// atomically. Every frame looks as [`super::field_png`] draws it, with the time under the title and
/// the same colours throughout. Viewers that do not know animations show the first frame.
///
/// `seconds_per_frame` is the time each frame is shown, 0.01 to 60 s, rounded to milliseconds.
///
/// # Errors
/// [`OutputError::Shape`] for arrays that do not fit together, [`OutputError::Unsupported`] without
/// points or frames, for times that are not finite and for other times per frame,
/// [`OutputError::Drawing`] if the picture fails, else those of [`write_atomically`].
pub fn animation_png(
    path: impl AsRef<Path>,
    plot: &Multiples<'_>,
    seconds_per_frame: f64,
) -> Result<(), OutputError> {
    let path = path.as_ref();
    plot.check(path)?;
    if !(DELAYS.0..=DELAYS.1).contains(&seconds_per_frame) {
        let found = format!("{seconds_per_frame} s");
        return Err(unsupported(
            path,
            "the time per frame",
            found,
            "0.01 to 60 s",
        ));
    }
    let colours = plot.colours();
    // The same notes below every frame keep all frames at one size.
    let notes = plot.notes(&colours);
    let pictures = plot
        .frames
        .iter()
        .map(|frame| draw_in(&plot.field(frame), &colours, &notes));
    let milliseconds = (1000.0 * seconds_per_frame).round() as u16;
    let bytes =
        encode_animation(pictures, milliseconds).map_err(|reason| OutputError::Drawing {
            path: path.to_path_buf(),
            reason,
        })?;
    write_atomically(path, |writer| writer.write_all(&bytes))
}

#[cfg(test)]
#[path = "animation_tests.rs"]
mod tests;
