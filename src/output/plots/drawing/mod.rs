//! What draws.

mod animation;
mod axes;
mod bar;
mod canvas;
mod clip;
mod colours;
mod curves;
mod decimate;
mod field;
mod font;
mod grid;
mod isometric;
mod layout;
mod legend;
mod lines;
mod multiples;
mod numbers;
mod overlay;
mod page;
mod paths;
mod raster;
mod setup;
mod ticks;

use super::units;
use super::{About, IsometricPlot, SetupMark, SetupPlot, SideSign, Sign};
use super::{
    FieldPlot, LinePlot, LineStyle, Multiples, PICTURE_KEY, PathPlot, PictureFacts, Scale, Series,
    WIDE,
};

pub use animation::animation_png;
pub use field::field_png;
pub use isometric::isometric_png;
pub use lines::{lines_svg, lines_text};
pub use multiples::multiples_png;
pub use paths::paths_svg;
pub use setup::setup_png;

/// Result of a drawing step; the text is the reason for [`OutputError::Drawing`](crate::output::OutputError).
type Drawn<T> = Result<T, String>;

/// A place on the picture in pixels, x to the right and y downwards.
type Place = (f64, f64);
