//! What is drawn: fields, curves and crack paths, as plain slices.

/// Width of drawings, px.
pub const WIDE: f64 = 900.0;
/// Width of drawings whose numbers can be read on a phone, px.
pub const NARROW: f64 = 520.0;

/// How values are spread over the colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their decimal logarithm; values that are not positive are grey.
    Log10,
}

/// A field over the plane, drawn as one coloured cell per point.
#[derive(Debug, Clone, Copy)]
pub struct FieldPlot<'a> {
    /// Title, such as `pressure`.
    pub title: &'a str,
    /// SI unit of the values, such as `Pa`; empty for pure numbers.
    pub unit: &'a str,
    /// Coordinates point by point, m. Shape `(points · dimension,)`.
    pub positions: &'a [f64],
    /// Coordinates per point, 2 or 3; only the first two are drawn, so that points in space should be
    /// those of one slice.
    pub dimension: usize,
    /// Edge of the square cell of each point, m. Shape `(points,)`.
    pub sizes: &'a [f64],
    /// Corners of the cell of each point, m, where cells are no squares; empty otherwise.
    pub outlines: &'a [Vec<[f64; 2]>],
    /// Values. Shape `(points,)`. Those that are not finite are drawn in grey.
    pub values: &'a [f64],
    /// Simulated time, s.
    pub time: Option<f64>,
    /// Linear or logarithmic colours.
    pub scale: Scale,
    /// Values at the ends of the colour bar, in `unit`; by default the extremes of the values.
    pub range: Option<(f64, f64)>,
    /// Width of the picture, px; 400 to 8000, the height follows.
    pub width_px: u32,
    /// Names of the two axes, such as `x` and `y`.
    pub axes: [&'a str; 2],
    /// Lines over the field, corner by corner, m, such as cracks. Parts outside the picture are not drawn.
    pub lines: &'a [Vec<[f64; 2]>],
    /// File beside the picture that has the values; the picture then tells it with the place of its frame.
    pub source: Option<&'a str>,
}

/// What stands in a PNG picture beside its pixels, as JSON under [`PICTURE_KEY`]: which place is which pixel.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PictureFacts {
    /// Title.
    pub title: String,
    /// SI unit of the values.
    pub unit: String,
    /// Simulated time, s; none in a steady state.
    pub time: Option<f64>,
    /// Names of the axes.
    pub axes: [String; 2],
    /// Width and height of the picture, px.
    pub size: [f64; 2],
    /// Left and upper end, width and height of the frame, px.
    pub frame: [f64; 4],
    /// Left, right, lower and upper end of what the frame shows, m.
    pub window: [f64; 4],
    /// Values at the ends of the colour bar.
    pub range: [f64; 2],
    /// Lines over the field, corner by corner, m.
    pub lines: Vec<Vec<[f64; 2]>>,
    /// File with the values.
    pub source: String,
}

/// Keyword of [`PictureFacts`] in a PNG file.
pub const PICTURE_KEY: &str = "perifrac";

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineStyle {
    /// A solid curve.
    #[default]
    Line,
    /// A dashed curve, for instance an exact solution.
    Dashed,
    /// One mark per value, for instance measurements.
    Markers,
    /// A thin solid curve that never has marks, for instance between measurements.
    Thin,
}

/// One set of values over a coordinate.
#[derive(Debug, Clone, Copy)]
pub struct Series<'a> {
    /// Name in the legend; empty for none: the series then looks as the one before it.
    pub label: &'a str,
    /// Coordinates, in the unit of the axis label.
    pub x: &'a [f64],
    /// Values, as many as `x`; those that are not finite are gaps.
    pub y: &'a [f64],
    /// How the series is drawn.
    pub style: LineStyle,
}

/// Curves over a common axis.
///
/// Labels may end in a unit in brackets, such as `time [s]` or `pressure [Pa]`; the numbers of linear
/// axes are then shown in a handy multiple of it.
#[derive(Debug, Clone, Copy)]
pub struct LinePlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Label of the horizontal axis, with the unit in brackets.
    pub x_label: &'a str,
    /// Label of the vertical axis, with the unit in brackets.
    pub y_label: &'a str,
    /// Logarithmic horizontal axis; values that are not positive become gaps.
    pub x_log: bool,
    /// Logarithmic vertical axis; values that are not positive become gaps.
    pub y_log: bool,
    /// The curves, from back to front.
    pub series: &'a [Series<'a>],
    /// A remark below the plot.
    pub note: Option<&'a str>,
}

/// One field over the plane at several times, all with the same colours.
#[derive(Debug, Clone, Copy)]
pub struct Multiples<'a> {
    /// Title, such as `pressure`.
    pub title: &'a str,
    /// SI unit of the values, such as `Pa`; empty for pure numbers.
    pub unit: &'a str,
    /// Coordinates point by point, m. Shape `(points · 2,)`.
    pub positions: &'a [f64],
    /// Edge of the square cell of each point, m. Shape `(points,)`.
    pub sizes: &'a [f64],
    /// Corners of the cell of each point, m, where cells are no squares; empty otherwise.
    pub outlines: &'a [Vec<[f64; 2]>],
    /// Simulated time, s, and values of each frame in the order shown. Shape of the values:
    /// `(points,)`. Those that are not finite are drawn in grey.
    pub frames: &'a [(f64, Vec<f64>)],
    /// Linear or logarithmic colours.
    pub scale: Scale,
    /// Values at the ends of the colour bar, in `unit`; by default the extremes over all frames.
    pub range: Option<[f64; 2]>,
    /// Width of the picture, px; 400 to 8000, the height follows.
    pub width_px: u32,
    /// Names of the two axes, such as `x` and `y`.
    pub axes: [&'a str; 2],
    /// Lines over all frames, corner by corner, m, such as cracks.
    pub lines: &'a [Vec<[f64; 2]>],
}

/// Cracks in a plane domain: those there from the start, and where the material broke later.
#[derive(Debug, Clone, Copy)]
pub struct PathPlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Lower left and upper right corner of the domain, m.
    pub bounds: [[f64; 2]; 2],
    /// Cracks that are there from the start, corner by corner, m. Parts outside the domain are not
    /// drawn.
    pub initial: &'a [Vec<[f64; 2]>],
    /// Broken places in any order: x and y, m, and the time at which the place broke, s. Those
    /// outside the domain are counted below the plot.
    pub points: &'a [[f64; 3]],
    /// A remark below the plot.
    pub note: Option<&'a str>,
}
