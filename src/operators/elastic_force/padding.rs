//! A lattice with the layers of images around it, so that every point has the same stencil.
//!
//! Sites beyond a mirrored side stand for images, with the signs of their continuation; beyond a one-sided side
//! there is nothing, and values there stay zero.

use crate::geometry::{Lattice, Side, Vector};
use crate::operators::{Elastic, Parity};

/// Where an image lies, and what it is the image of.
#[derive(Debug, Clone)]
pub(super) struct Ghost<const D: usize> {
    /// Its site.
    pub site: u32,
    /// Site of the point.
    pub source: u32,
    /// Signs with which the components of the displacement continue.
    pub sign: Vector<D>,
    /// −1 along axes that are turned round.
    pub turn: Vector<D>,
}

/// Sites of a lattice and of the layers around it, in lines along the first axis.
#[derive(Debug, Clone)]
pub(super) struct Padding<const D: usize> {
    /// Points along each axis.
    pub counts: [usize; D],
    /// Layers on both sides of each axis.
    pub reach: [usize; D],
    /// Images that exist.
    pub ghosts: Vec<Ghost<D>>,
    /// First point of every line of sites; `NONE` for lines of images.
    pub first: Vec<u32>,
}

/// No point.
pub(super) const NONE: u32 = u32::MAX;

impl<const D: usize> Padding<D> {
    /// The points of a cloud as a lattice, first axis fastest, with `horizon` metres around it; `None` if they are none.
    pub(crate) fn of(elastic: &Elastic<D>, horizon: f64) -> Option<Self> {
        let cloud = &elastic.around.cloud;
        let counts = Lattice::of(cloud)?.counts;
        let reach = std::array::from_fn(|axis| {
            (horizon / cloud.cell[0][axis] * (1.0 + ROUNDING)).floor() as usize
        });
        let mut padding = Padding {
            counts,
            reach,
            ghosts: Vec::new(),
            first: Vec::new(),
        };
        padding.first = vec![NONE; padding.lines()];
        for point in (0..cloud.len()).step_by(counts[0]) {
            let line = padding.site_of(point) / padding.length();
            padding.first[line] = point as u32;
        }
        padding.ghosts = padding.images(elastic);
        Some(padding)
    }

    /// Sites of a line.
    pub(crate) fn length(&self) -> usize {
        self.extent(0)
    }

    /// Lines of sites.
    pub(crate) fn lines(&self) -> usize {
        (1..D).map(|axis| self.extent(axis)).product()
    }

    fn extent(&self, axis: usize) -> usize {
        self.counts[axis] + 2 * self.reach[axis]
    }

    /// Site of a point.
    pub(crate) fn site_of(&self, mut point: usize) -> usize {
        let (mut site, mut stride) = (0, 1);
        for axis in 0..D {
            site += stride * (point % self.counts[axis] + self.reach[axis]);
            point /= self.counts[axis];
            stride *= self.extent(axis);
        }
        site
    }

    /// Lines and sites along a line by which a step on the lattice moves.
    pub(crate) fn shift(&self, step: [i64; D]) -> (i64, i64) {
        let (mut lines, mut stride) = (0, 1);
        for (axis, own) in step.iter().enumerate().skip(1) {
            lines += own * stride;
            stride *= self.extent(axis) as i64;
        }
        (lines, step[0])
    }

    fn images(&self, elastic: &Elastic<D>) -> Vec<Ghost<D>> {
        let sites = self.length() * self.lines();
        let planes = elastic.around.cloud.domain.planes;
        let inside = |place: &[i64; D]| {
            (0..D).all(|axis| (0..self.counts[axis] as i64).contains(&place[axis]))
        };
        let places = (0..sites).map(|site| (site, self.place(site)));
        places
            .filter(|(_, place)| planes && !inside(place))
            .filter_map(|(site, place)| self.image(elastic, site, place))
            .collect()
    }

    /// Place of a site on the lattice.
    fn place(&self, mut site: usize) -> [i64; D] {
        std::array::from_fn(|axis| {
            let place = site % self.extent(axis);
            site /= self.extent(axis);
            place as i64 - self.reach[axis] as i64
        })
    }

    /// The image at a site, if sides let it exist.
    fn image(&self, elastic: &Elastic<D>, site: usize, place: [i64; D]) -> Option<Ghost<D>> {
        let (mut sign, mut turn) = (Vector::repeat(1.0), Vector::repeat(1.0));
        let (mut source, mut stride) = (0, 1);
        for axis in 0..D {
            let (mut at, count) = (place[axis], self.counts[axis] as i64);
            while !(0..count).contains(&at) {
                let side = Side {
                    axis,
                    upper: at >= count,
                };
                at = if side.upper {
                    2 * count - 1 - at
                } else {
                    -1 - at
                };
                turn[axis] = -turn[axis];
                for (component, extension) in elastic.extension.iter().enumerate() {
                    match extension.parity(side) {
                        Parity::Even => {}
                        Parity::Odd => sign[component] = -sign[component],
                        Parity::OneSided => return None,
                    }
                }
            }
            source += stride * (at as usize + self.reach[axis]);
            stride *= self.extent(axis);
        }
        Some(Ghost {
            site: site as u32,
            source: source as u32,
            sign,
            turn,
        })
    }
}

/// Part of a spacing that is rounding.
pub(super) const ROUNDING: f64 = 1e-6;
