//! Which points and cells a file of fields holds.

use crate::geometry::{CellKind, Cutter, DualCells};
use crate::model::{Model, cut_cracks};
use crate::output::Cells;
use crate::plan::{GeometryPlan, Plan};

/// Points and cells of one file.
#[derive(Debug, PartialEq)]
pub(super) struct Grid {
    /// The points in the order of the file: those of this process, then those of others that its cells need.
    pub(super) points: Vec<u32>,
    /// How many are those of others; `None` in a single process.
    pub(super) ghosts: Option<usize>,
    cells: DualCells,
    /// Numbers that VTK gives to the kinds of the cells.
    pub(super) kinds: Vec<u8>,
}

impl Grid {
    /// The points and cells of this process. Where the geometry does not tell cells, and where a crack leaves a
    /// point none, the point is a cell of its own.
    pub(super) fn of<const D: usize>(plan: &Plan, model: &Model<D>) -> Self {
        let cells = between(plan, model);
        let count = model.cloud.len();
        let Some(partition) = model.subdomain().partition() else {
            let points = (0..count as u32).collect();
            return Grid::new(points, None, cells, count);
        };
        let own = partition.mask();
        let (mut points, mut kept) = (partition.own().to_vec(), DualCells::default());
        let mut needed = Vec::new();
        // Every cell is written once, by the owner of its first point.
        let owned = |corners: &[u32]| {
            corners
                .iter()
                .min()
                .is_some_and(|first| own[*first as usize])
        };
        for (kind, corners) in cells.iter().filter(|(_, corners)| owned(corners)) {
            let others = corners.iter().filter(|corner| !own[**corner as usize]);
            needed.extend(others.copied());
            kept.push(kind, corners.iter().copied());
        }
        needed.sort_unstable();
        needed.dedup();
        points.extend(&needed);
        Grid::new(points, Some(needed.len()), kept, count)
    }

    /// Numbers corners by the places of their points in the file, and adds points without a cell.
    fn new(points: Vec<u32>, ghosts: Option<usize>, mut cells: DualCells, count: usize) -> Self {
        let mut place = vec![u32::MAX; count];
        for (number, point) in (0_u32..).zip(&points) {
            place[*point as usize] = number;
        }
        let mut alone = vec![true; points.len()];
        for corner in &mut cells.corners {
            *corner = place[*corner as usize];
            alone[*corner as usize] = false;
        }
        for (number, _) in (0_u32..).zip(alone).filter(|(_, alone)| *alone) {
            cells.push(CellKind::Vertex, [number]);
        }
        Grid {
            kinds: cells.kinds.iter().map(|kind| *kind as u8).collect(),
            points,
            ghosts,
            cells,
        }
    }

    /// The cells by their corners.
    pub(super) fn cells(&self) -> Cells<'_> {
        Cells {
            corners: &self.cells.corners,
            ends: &self.cells.ends,
        }
    }
}

/// The cells between all points that no crack runs through.
fn between<const D: usize>(plan: &Plan, model: &Model<D>) -> DualCells {
    let whole = match (&plan.geometry, plan.geometry.cells()) {
        (GeometryPlan::Blocks { .. }, _) => DualCells::blocks(&model.cloud),
        (_, Some(counts)) => DualCells::tensor(&counts),
        (_, None) => DualCells::default(),
    };
    let cracks = cut_cracks(plan);
    match cracks.is_empty() {
        true => whole,
        false => whole.cut(&model.cloud, &Cutter::without_images(&cracks)),
    }
}
