//! Clouds that are too large to be made for an estimate: their counts and sizes, and a small cloud that
//! looks like them.

use crate::effects::vector;
use crate::geometry::generate::{Refinement, check_count, lattice};
use crate::geometry::{Cloud, Horizon, Shape, Vector};
use crate::model::ModelError;
use crate::plan::{GeometryPlan, Plan};

/// Points up to which a cloud is made for an estimate: a lattice of this size is sampled in about
/// 0.2 s, and one of a million points in a second.
const MOST_POINTS: f64 = 300_000.0;
/// Points of the cloud that stands for a larger one.
const MODEL_POINTS: f64 = 20_000.0;

/// A cloud that is not made.
pub(super) struct CloudOutline<const D: usize> {
    /// Number of points.
    pub count: f64,
    /// Points along each axis, whole for lattices and tensor grids.
    along: [f64; D],
    /// Lowest corner, m.
    origin: Vector<D>,
    /// Edges, m.
    size: Vector<D>,
    /// Smallest and largest over the mean spacing.
    spread: [f64; 2],
    irregular: bool,
}

/// A small cloud in place of a large one.
pub(super) struct StandIn<const D: usize> {
    /// Points of the true domain, for what depends on the place.
    pub places: Cloud<D>,
    /// The same points with cells of the true shape, for families.
    pub cells: Cloud<D>,
    /// Horizon over these cells.
    pub horizon: Horizon,
    /// Spacing of these cells over the true one.
    pub coarser: f64,
}

impl<const D: usize> CloudOutline<D> {
    /// The outline of a plan's cloud if it is too large to be made; `None` for points from a file, which
    /// are there already.
    ///
    /// # Errors
    /// [`ModelError::Generate`] for more points than can be numbered.
    pub(crate) fn of_large(plan: &Plan) -> Result<Option<Self>, ModelError> {
        let Some(outline) = Self::of(&plan.geometry) else {
            return Ok(None);
        };
        check_count(outline.count)?;
        Ok((outline.count > MOST_POINTS).then_some(outline))
    }

    fn of(geometry: &GeometryPlan) -> Option<Self> {
        let (origin, size, along, finest) = match geometry {
            GeometryPlan::Lattice {
                origin,
                size,
                cells,
                ..
            } => {
                let along = std::array::from_fn(|axis| cells[axis] as f64);
                (vector(origin), vector(size), along, [1.0, 1.0])
            }
            GeometryPlan::Graded { origin, axes } => {
                let cells = geometry.cells()?;
                let size = Vector::from_fn(|axis, _| axes[axis].iter().map(|s| s.length).sum());
                let along: [f64; D] = std::array::from_fn(|axis| cells[axis] as f64);
                let mut spread = [1.0, 1.0];
                for (axis, segments) in axes.iter().enumerate() {
                    let mean = size[axis] / along[axis];
                    let widths = segments.iter().flat_map(|s| [s.first, s.last]);
                    let (least, most) = widths.fold((mean, mean), |(low, high), width| {
                        (f64::min(low, width), f64::max(high, width))
                    });
                    spread[0] *= (least / mean).powf(1.0 / D as f64);
                    spread[1] *= (most / mean).powf(1.0 / D as f64);
                }
                (vector(origin), size, along, spread)
            }
            GeometryPlan::Blocks {
                origin,
                size,
                spacing,
                refinements,
            } => {
                let size: Vector<D> = vector(size);
                let cells = size.iter().map(|edge| edge / spacing).product::<f64>();
                let count = cells + refined(refinements, *spacing, &vector(origin), &size);
                let deepest = refinements.iter().map(|r| r.levels).max().unwrap_or(0);
                let finer = (count / cells).powf(1.0 / D as f64);
                let along = std::array::from_fn(|axis| size[axis] / spacing * finer);
                let spread = [finer / 2.0_f64.powi(deepest as i32), finer];
                (vector(origin), size, along, spread)
            }
            GeometryPlan::Points { .. } => return None,
        };
        Some(Self {
            count: along.iter().product(),
            irregular: finest.iter().any(|share| (share - 1.0).abs() > 1e-12)
                || matches!(geometry, GeometryPlan::Lattice { jitter, .. } if *jitter > 0.0),
            along,
            origin,
            size,
            spread: finest,
        })
    }

    /// Mean spacing, m.
    pub(crate) fn spacing(&self) -> f64 {
        (self.size.iter().product::<f64>() / self.count).powf(1.0 / D as f64)
    }

    /// Smallest and largest spacing, m.
    pub(crate) fn extremes(&self) -> [f64; 2] {
        self.spread.map(|share| share * self.spacing())
    }

    /// A small cloud with cells of the same shape in the same domain.
    ///
    /// # Errors
    /// [`ModelError::Generate`].
    pub(crate) fn stand_in(&self, horizon: Horizon) -> Result<StandIn<D>, ModelError> {
        let coarser = self.coarsening();
        let cells: [usize; D] =
            std::array::from_fn(|axis| (self.along[axis] / coarser).round().max(1.0) as usize);
        let edge = |axis: usize| self.size[axis] / self.along[axis] * coarser;
        let reach = Vector::from_fn(|axis, _| edge(axis) * cells[axis] as f64);
        let mut shaped = lattice(self.origin, reach, cells)?;
        shaped.irregular = self.irregular;
        Ok(StandIn {
            places: lattice(self.origin, self.size, cells)?,
            cells: shaped,
            horizon: match horizon {
                Horizon::Radius(radius) => Horizon::Radius(radius * coarser),
                other => other,
            },
            coarser,
        })
    }
}

impl<const D: usize> CloudOutline<D> {
    /// Factor by which spacings must grow for about [`MODEL_POINTS`]; no axis has less than one point.
    fn coarsening(&self) -> f64 {
        let points = |factor: f64| -> f64 {
            let along = self.along.iter().map(|count| (count / factor).max(1.0));
            along.product()
        };
        let (mut low, mut high) = (1.0, self.count.max(2.0));
        for _ in 0..60 {
            let middle = f64::sqrt(low * high);
            match points(middle) > MODEL_POINTS {
                true => low = middle,
                false => high = middle,
            }
        }
        high
    }
}

/// Cells that refinements add to those of the coarsest spacing: an upper estimate, in which regions
/// count by their bounding boxes and those that overlap count twice.
fn refined<const D: usize>(
    refinements: &[Refinement],
    spacing: f64,
    origin: &Vector<D>,
    size: &Vector<D>,
) -> f64 {
    let halved = |refinement: &Refinement, level: u32| {
        let edge = spacing / 2.0_f64.powi(level as i32);
        let cells = (0..D).map(|axis| {
            let [low, high] = extent(&refinement.region, axis);
            let inside = high.min(origin[axis] + size[axis]) - low.max(origin[axis]);
            // Cells that the region only touches are halved too, and those that these are too small for.
            match inside < 0.0 {
                true => 0.0,
                false => (inside + 4.0 * edge).min(size[axis]) / edge,
            }
        });
        cells.product::<f64>()
    };
    // A cell that is halved becomes 2^D cells.
    let more = 2.0_f64.powi(D as i32) - 1.0;
    (refinements.iter())
        .flat_map(|refinement| (0..refinement.levels).map(move |level| (refinement, level)))
        .map(|(refinement, level)| more * halved(refinement, level))
        .sum()
}

/// Lowest and highest coordinate of a shape along an axis, m.
fn extent(shape: &Shape, axis: usize) -> [f64; 2] {
    let endless = [f64::NEG_INFINITY, f64::INFINITY];
    match shape {
        Shape::Box { min, max } => [min[axis], max[axis]],
        Shape::Disc { centre, radius } => [centre[axis] - radius, centre[axis] + radius],
        Shape::Polygon { vertices } if axis < 2 => {
            let along = vertices.iter().map(|vertex| vertex[axis]);
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            })
        }
        Shape::Polygon { .. } | Shape::HalfPlane { .. } | Shape::Set { .. } => endless,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;
    use crate::geometry::generate::Segment;

    fn lattice_of(cells: [usize; 2]) -> GeometryPlan {
        GeometryPlan::Lattice {
            origin: vec![0.0, 0.0],
            size: vec![cells[0] as f64, cells[1] as f64],
            cells: cells.to_vec(),
            jitter: 0.0,
            seed: 0,
        }
    }

    #[test]
    fn a_slender_lattice_keeps_its_points_few_and_its_cells_square() {
        for cells in [[1_000_000, 1], [1000, 1000], [3, 500_000]] {
            let outline = CloudOutline::<2>::of(&lattice_of(cells)).unwrap();
            let small = outline.stand_in(Horizon::Radius(3.0)).unwrap();
            let points = small.cells.len() as f64;
            assert!(
                (0.9..1.1).contains(&(points / MODEL_POINTS)),
                "{cells:?}: {points}"
            );
            let cell = small.cells.cell[0];
            assert!((cell[0] / cell[1] - 1.0).abs() < 1e-9, "{cells:?}: {cell}");
            assert!((cell[0] / small.coarser - 1.0).abs() < 1e-9);
            assert_eq!(small.horizon, Horizon::Radius(3.0 * small.coarser));
        }
    }

    /// A uniform half of cells of 1 and one of cells of 1/4: 2 · 8 in x, 4 · 4 in y.
    #[test]
    fn a_tensor_grid_has_the_spacings_of_its_segments() {
        let segment = |length: f64, spacing: f64| Segment {
            length,
            first: spacing,
            last: spacing,
        };
        let axes = vec![
            vec![segment(2.0, 1.0), segment(2.0, 0.25)],
            vec![segment(4.0, 0.4)],
        ];
        let graded = GeometryPlan::Graded {
            origin: vec![0.0, 0.0],
            axes,
        };
        let outline = CloudOutline::<2>::of(&graded).unwrap();
        assert_eq!(outline.count, 100.0);
        let [least, most] = outline.extremes();
        assert!((least - f64::sqrt(0.25 * 0.4)).abs() < 1e-9, "{least}");
        assert!((most - f64::sqrt(1.0 * 0.4)).abs() < 1e-9, "{most}");
    }

    fn blocks(spacing: f64, max: f64, levels: u32) -> GeometryPlan {
        let region = Shape::Box {
            min: vec![0.0, 0.0],
            max: vec![max, max],
        };
        GeometryPlan::Blocks {
            origin: vec![0.0, 0.0],
            size: vec![1.0, 1.0],
            spacing,
            refinements: vec![Refinement { region, levels }],
        }
    }

    /// A quarter of the square halved twice: 16 times as many cells there, and those it touches.
    #[test]
    fn refined_blocks_are_counted_from_above() {
        let outline = CloudOutline::<2>::of(&blocks(0.01, 0.5, 2)).unwrap();
        let exact = 7500.0 + 2500.0 * 16.0;
        let over = outline.count / exact;
        assert!((1.0..1.15).contains(&over), "{over}");
        assert!((outline.extremes()[0] - 0.0025).abs() < 1e-4);
    }

    /// Around a tiny region every level adds a few cells, not four times as many as the one before.
    #[test]
    fn deep_blocks_around_a_place_are_few() {
        let outline = CloudOutline::<2>::of(&blocks(0.1, 1e-4, 10)).unwrap();
        assert!(outline.count < 1000.0, "{}", outline.count);
    }
}
