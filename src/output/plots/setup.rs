//! What is drawn of a model before it runs: points by material, conditions on its sides, wells and cracks.

/// Points in the colours of their materials, with what holds, loads and feeds them.
#[derive(Debug, Clone, Copy)]
pub struct SetupPlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Names of the axes.
    pub axes: [&'a str; 2],
    /// Coordinates point by point, m. Shape `(points · 2,)`.
    pub positions: &'a [f64],
    /// Edge of the square cell of each point, m. Shape `(points,)`.
    pub sizes: &'a [f64],
    /// Corners of the cell of each point, m, where cells are no squares; empty otherwise.
    pub outlines: &'a [Vec<[f64; 2]>],
    /// Number in `groups` of each point. Shape `(points,)`.
    pub group: &'a [usize],
    /// Names of the groups of points, such as materials.
    pub groups: &'a [String],
    /// What holds on sides.
    pub sides: &'a [SideSign],
    /// Named places.
    pub marks: &'a [SetupMark],
    /// Lines such as cracks, corner by corner, m.
    pub lines: &'a [Vec<[f64; 2]>],
    /// Remarks below the picture.
    pub notes: &'a [String],
    /// Width of the picture, px.
    pub width_px: u32,
}

/// A condition on a side or a part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideSign {
    /// Axis of the picture that the side is normal to, 0 or 1.
    pub axis: usize,
    /// Whether it is the upper end of that axis.
    pub upper: bool,
    /// From where to where along the side, m.
    pub span: [f64; 2],
    /// What is drawn.
    pub sign: Sign,
    /// What the condition is about, which tells the colour.
    pub about: About,
}

/// What is drawn along a side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sign {
    /// A bar: all is held.
    Bar,
    /// A row of circles: points move along the side.
    Circles,
    /// Arrows in a direction; its length does not matter.
    Arrows([f64; 2]),
}

/// What a condition is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum About {
    /// Displacements that are held: dark.
    Support,
    /// Displacements that change: orange.
    Motion,
    /// Forces: green.
    Load,
    /// Pressure or flux of the fluid: blue.
    Fluid,
}

/// A named place.
#[derive(Debug, Clone, PartialEq)]
pub struct SetupMark {
    /// Where, m.
    pub at: [f64; 2],
    /// Its name.
    pub label: String,
    /// What it is about: a well or an injection is [`About::Fluid`], a probe [`About::Support`].
    pub about: About,
}
