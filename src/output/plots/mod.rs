//! Plots: fields as PNG pictures ([`field_png`]), also over time ([`multiples_png`],
//! [`animation_png`]); curves ([`lines_svg`]) and crack paths ([`paths_svg`]) as SVG drawings.
//!
//! All draw through the backends of plotters. Text in pictures is set in `DejaVu Sans`, which is
//! embedded (Bitstream Vera licence, changes in the public domain); drawings ask the viewer for it or
//! for another sans-serif. Colour maps are safe for colour-blind readers: viridis, red–white–blue for
//! signed values, and the palette of Okabe and Ito for curves.
//!
//! All this takes the feature `plots`; without it the same functions draw nothing, and
//! [`DRAWS`] says so.

#[cfg(feature = "plots")]
mod animation;
#[cfg(feature = "plots")]
mod axes;
#[cfg(feature = "plots")]
mod bar;
#[cfg(not(feature = "plots"))]
mod blank;
#[cfg(feature = "plots")]
mod canvas;
#[cfg(feature = "plots")]
mod clip;
#[cfg(feature = "plots")]
mod colours;
#[cfg(feature = "plots")]
mod curves;
#[cfg(feature = "plots")]
mod decimate;
#[cfg(feature = "plots")]
mod field;
#[cfg(feature = "plots")]
mod font;
#[cfg(feature = "plots")]
mod grid;
#[cfg(feature = "plots")]
mod layout;
#[cfg(feature = "plots")]
mod legend;
#[cfg(feature = "plots")]
mod lines;
#[cfg(feature = "plots")]
mod multiples;
#[cfg(feature = "plots")]
mod page;
#[cfg(feature = "plots")]
mod paths;
#[cfg(feature = "plots")]
mod raster;
mod subject;
#[cfg(feature = "plots")]
mod ticks;
#[cfg_attr(not(feature = "plots"), allow(dead_code))]
mod units;

#[cfg(feature = "plots")]
pub use animation::animation_png;
#[cfg(not(feature = "plots"))]
pub use blank::{animation_png, field_png, lines_svg, multiples_png, paths_svg};
#[cfg(feature = "plots")]
pub use field::field_png;
#[cfg(feature = "plots")]
pub use lines::{lines_svg, lines_text};
#[cfg(feature = "plots")]
pub use multiples::multiples_png;
#[cfg(feature = "plots")]
pub use paths::paths_svg;
pub use subject::{
    FieldPlot, LinePlot, LineStyle, Multiples, NARROW, PathPlot, Scale, Series, WIDE,
};
pub use units::readable_time;

/// Whether this build draws.
pub const DRAWS: bool = cfg!(feature = "plots");

/// Result of a drawing step; the text is the reason for [`super::OutputError::Drawing`].
#[cfg(feature = "plots")]
type Drawn<T> = Result<T, String>;

/// A place on the picture in pixels, x to the right and y downwards.
#[cfg(feature = "plots")]
type Place = (f64, f64);
