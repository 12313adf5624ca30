//! In place of drawing, in a library built without the feature `plots`: nothing is drawn.

use std::path::Path;

use super::{FieldPlot, IsometricPlot, LinePlot, Multiples, PathPlot, SetupPlot};
use crate::output::OutputError;

/// Functions that draw nothing, whatever they are given.
macro_rules! draw_nothing {
    ($($name:ident($plot:ty $(, $more:ty)?)),*) => {$(
        /// Draws nothing.
        ///
        /// # Errors
        /// None.
        pub fn $name(_: impl AsRef<Path>, _: &$plot $(, _: $more)?) -> Result<(), OutputError> {
            Ok(())
        }
    )*};
}

draw_nothing!(
    field_png(FieldPlot<'_>),
    multiples_png(Multiples<'_>),
    animation_png(Multiples<'_>, f64),
    lines_svg(LinePlot<'_>),
    paths_svg(PathPlot<'_>),
    isometric_png(IsometricPlot<'_>),
    setup_png(SetupPlot<'_>)
);
