//! Which points and cells a file of fields holds.

use crate::geometry::{CellKind, Cutter, DualCells};
use crate::model::{Model, cut_cracks};
use crate::output::Cells;
use crate::plan::{GeometryPlan, Plan};

/// Points and cells of one file.
#[derive(Debug, PartialEq, Default)]
pub(super) struct Grid {
    /// The points in the order of the file: those of this process, then those of others that its cells need.
    pub(super) points: Vec<u32>,
    /// How many are those of others; `None` in a single process.
    pub(super) ghosts: Option<usize>,
    corners: Vec<u32>,
    ends: Vec<u64>,
    faces: Vec<u64>,
    face_ends: Vec<i64>,
    /// Numbers that VTK gives to the kinds of the cells.
    pub(super) kinds: Vec<u8>,
}

/// Number that VTK gives to polyhedra.
const POLYHEDRON: u8 = 42;

impl Grid {
    /// The points and cells of this process. Where the geometry does not tell cells, and where a crack leaves a
    /// point none, the point is a cell of its own.
    pub(super) fn of<const D: usize>(plan: &Plan, model: &Model<D>) -> Self {
        let cells = between(plan, model);
        let count = model.cloud.len();
        let Some(partition) = model.subdomain().partition() else {
            let points = (0..count as u32).collect();
            return Grid::new(points, None, &cells, count);
        };
        let own = partition.mask();
        // Every cell is written once, by the owner of its first point.
        let owned = |first: Option<&u32>| first.is_some_and(|first| own[*first as usize]);
        let mut kept = DualCells::default();
        for (kind, corners) in cells.iter() {
            if owned(corners.iter().min()) {
                kept.push(kind, corners.iter().copied());
            }
        }
        let solids = cells.solids.into_iter();
        kept.solids = solids
            .filter(|faces| owned(faces.iter().flatten().min()))
            .collect();
        let corners = kept
            .corners
            .iter()
            .chain(kept.solids.iter().flatten().flatten());
        let mut needed: Vec<u32> = corners
            .copied()
            .filter(|corner| !own[*corner as usize])
            .collect();
        needed.sort_unstable();
        needed.dedup();
        let mut points = partition.own().to_vec();
        points.extend(&needed);
        Grid::new(points, Some(needed.len()), &kept, count)
    }

    /// Points alone.
    pub(super) fn of_points(points: &[u32]) -> Self {
        let count = points.iter().max().map_or(0, |most| *most as usize + 1);
        Grid::new(points.to_vec(), None, &DualCells::default(), count)
    }

    /// Numbers corners by the places of their points in the file, and adds points without a cell.
    fn new(points: Vec<u32>, ghosts: Option<usize>, cells: &DualCells, count: usize) -> Self {
        let mut place = vec![u32::MAX; count];
        for (number, point) in (0_u32..).zip(&points) {
            place[*point as usize] = number;
        }
        let mut grid = Grid {
            points,
            ghosts,
            ..Grid::default()
        };
        for (kind, corners) in cells.iter() {
            grid.push(
                kind as u8,
                corners.iter().map(|corner| place[*corner as usize]),
            );
        }
        for solid in &cells.solids {
            grid.push_solid(solid, &place);
        }
        let mut alone = vec![true; grid.points.len()];
        grid.corners
            .iter()
            .for_each(|corner| alone[*corner as usize] = false);
        for (number, _) in (0_u32..).zip(alone).filter(|(_, alone)| *alone) {
            grid.push(CellKind::Vertex as u8, [number]);
        }
        grid
    }

    fn push(&mut self, kind: u8, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len() as u64);
        self.face_ends.push(-1);
        self.kinds.push(kind);
    }

    /// Adds a polyhedron; `place` has the numbers of its points in the file.
    fn push_solid(&mut self, solid: &[Vec<u32>], place: &[u32]) {
        let mut corners: Vec<u32> = solid.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        self.push(
            POLYHEDRON,
            corners.iter().map(|corner| place[*corner as usize]),
        );
        self.faces.push(solid.len() as u64);
        for face in solid {
            self.faces.push(face.len() as u64);
            let corners = face.iter().map(|corner| place[*corner as usize]);
            self.faces.extend(corners.map(u64::from));
        }
        if let Some(end) = self.face_ends.last_mut() {
            *end = self.faces.len() as i64;
        }
    }

    /// The cells by their corners.
    pub(super) fn cells(&self) -> Cells<'_> {
        Cells {
            corners: &self.corners,
            ends: &self.ends,
            faces: &self.faces,
            face_ends: &self.face_ends,
        }
    }
}

/// The cells between all points that no crack runs through.
fn between<const D: usize>(plan: &Plan, model: &Model<D>) -> DualCells {
    let whole = match (&plan.geometry, plan.geometry.cells()) {
        (GeometryPlan::Points { mesh, .. }, _) => match mesh {
            Some(mesh) => mesh.dual.clone(),
            None => DualCells::default(),
        },
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
