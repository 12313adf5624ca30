//! What is drawn of space seen from a corner.

/// Pieces of sections and broken places in a box, seen from its corner of the largest coordinates so that all three
/// axes are shortened alike.
#[derive(Debug, Clone, Copy)]
pub struct IsometricPlot<'a> {
    /// Title.
    pub title: &'a str,
    /// SI unit of the values.
    pub unit: &'a str,
    /// Lowest and highest corner of the box, m.
    pub bounds: [[f64; 3]; 2],
    /// Pieces of sections.
    pub tiles: &'a [Tile],
    /// Places with a value, drawn as discs of the size given, m: x, y, z, value.
    pub places: &'a [[f64; 4]],
    /// Diameter of the discs, m.
    pub size: f64,
    /// Lines such as rims of cracks, corner by corner, m. Parts outside the box are not drawn.
    pub lines: &'a [Vec<[f64; 3]>],
    /// Simulated time, s.
    pub time: Option<f64>,
    /// Values at the ends of the colour bar; by default the extremes.
    pub range: Option<[f64; 2]>,
    /// Remarks below the picture.
    pub notes: &'a [String],
    /// Width of the picture, px.
    pub width_px: u32,
}

/// A square piece of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tile {
    /// Its middle, m.
    pub at: [f64; 3],
    /// Axis that it is normal to.
    pub normal: usize,
    /// Its edge, m.
    pub size: f64,
    /// Its value.
    pub value: f64,
}
