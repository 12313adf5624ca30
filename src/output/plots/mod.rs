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

#[cfg(not(feature = "plots"))]
mod blank;
#[cfg(feature = "plots")]
mod drawing;
mod isometric;
mod setup;
mod subject;
#[cfg_attr(not(feature = "plots"), allow(dead_code))]
mod units;

#[cfg(not(feature = "plots"))]
pub use blank::{
    animation_png, field_png, isometric_png, lines_svg, multiples_png, paths_svg, setup_png,
};
#[cfg(feature = "plots")]
pub use drawing::{
    animation_png, field_png, isometric_png, lines_svg, lines_text, multiples_png, paths_svg,
    setup_png,
};
pub use isometric::{IsometricPlot, Tile};
pub use setup::{About, SetupMark, SetupPlot, SideSign, Sign};
pub use subject::{
    FieldPlot, LinePlot, LineStyle, Multiples, NARROW, PICTURE_KEY, PathPlot, PictureFacts, Scale,
    Series, WIDE,
};
pub use units::readable_time;

/// Whether this build draws.
pub const DRAWS: bool = cfg!(feature = "plots");
