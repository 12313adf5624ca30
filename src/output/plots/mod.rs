//! Plots: fields as PNG pictures ([`field_png`]), also over time ([`multiples_png`],
//! [`animation_png`]); curves ([`lines_svg`]) and crack paths ([`paths_svg`]) as SVG drawings.
//!
//! All draw through the backends of plotters. Text in pictures is set in `DejaVu Sans`, which is
//! embedded (Bitstream Vera licence, changes in the public domain); drawings ask the viewer for it or
//! for another sans-serif. Colour maps are safe for colour-blind readers: viridis, red–white–blue for
//! signed values, and the palette of Okabe and Ito for curves.

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
mod layout;
mod legend;
mod lines;
mod multiples;
mod page;
mod paths;
mod raster;
mod ticks;
mod units;

pub use animation::animation_png;
pub use field::{FieldPlot, Scale, field_png};
pub use lines::{LinePlot, LineStyle, NARROW, Series, WIDE, lines_svg, lines_text};
pub use multiples::{Multiples, multiples_png};
pub use paths::{PathPlot, paths_svg};
pub use units::readable_time;

/// Result of a drawing step; the text is the reason for [`super::OutputError::Drawing`].
type Drawn<T> = Result<T, String>;

/// A place on the picture in pixels, x to the right and y downwards.
type Place = (f64, f64);
