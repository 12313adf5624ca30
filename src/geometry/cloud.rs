//! The cloud of material points and the box it fills.

use super::{Side, Vector};

/// The region the points fill, and which of its sides are planes that can mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain<const D: usize> {
    /// Corner with the smallest coordinates, in metres.
    pub lower: Vector<D>,
    /// Corner with the largest coordinates, in metres.
    pub upper: Vector<D>,
    /// Whether the sides are known planes; a cloud read from a file without bounds has none.
    pub planes: bool,
}

impl<const D: usize> Domain<D> {
    /// Lengths of the edges in metres.
    pub fn size(&self) -> Vector<D> {
        self.upper - self.lower
    }

    /// Coordinate of a side along its own axis, in metres.
    pub fn plane(&self, side: Side) -> f64 {
        if side.upper {
            self.upper[side.axis]
        } else {
            self.lower[side.axis]
        }
    }

    /// Area of a side (length in 2-D), in metres to the power `D − 1`.
    pub fn area(&self, side: Side) -> f64 {
        let size = self.size();
        (0..D)
            .filter(|&axis| axis != side.axis)
            .map(|axis| size[axis])
            .product()
    }
}

/// Cell-centred material points: each stands for a cell of volume `volume`, and the boundary lies
/// half a cell outside the outermost points.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud<const D: usize> {
    /// The region filled.
    pub domain: Domain<D>,
    /// Positions in metres, shape `(n,)`.
    pub position: Vec<Vector<D>>,
    /// Cell volumes in m^D, shape `(n,)`.
    pub volume: Vec<f64>,
    /// Cell edges in metres, shape `(n,)`, for pictures and length scales.
    pub cell: Vec<Vector<D>>,
    /// Whether neighbouring cells differ in size or place, so that operators need the
    /// divergence-consistent correction.
    pub irregular: bool,
    /// Whether the cells are known to fill the domain, as those of generated clouds do; points that
    /// were read may leave voids.
    pub filled: bool,
    /// What a mesh tells of the border of its cells.
    pub outline: Option<Outline<D>>,
}

/// The border of the cells of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline<const D: usize> {
    /// Area of the cells on each side, m^(D−1), shape `(2D,)` in the order of [`Side::index`].
    pub side_area: Vec<f64>,
    /// Balls that touch the free surfaces from outside, one for each face: centre and radius, m.
    pub surface: Vec<(Vector<D>, f64)>,
}

impl<const D: usize> Cloud<D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Spacing of a point, the edge of a cube of its volume, in metres.
    pub fn spacing(&self, point: usize) -> f64 {
        edge(self.volume[point], D)
    }

    /// Positions one after another, shape `(n × D,)`, in metres.
    pub fn flat_positions(&self) -> Vec<f64> {
        self.position
            .iter()
            .flat_map(|x| x.iter().copied())
            .collect()
    }

    /// Index of the point nearest to `target` (metres); the lowest index where several tie.
    pub fn nearest(&self, target: &Vector<D>) -> Option<usize> {
        (0..self.len()).min_by(|&a, &b| {
            let distance = |i: usize| (self.position[i] - target).norm_squared();
            distance(a).total_cmp(&distance(b))
        })
    }
}

/// Edge of a cube of the given volume in `dimension` dimensions.
pub(crate) fn edge(volume: f64, dimension: usize) -> f64 {
    match dimension {
        2 => volume.sqrt(),
        3 => volume.cbrt(),
        _ => volume,
    }
}
