//! The cells of all points, with families that hold every face of them.

use super::cells::{Arm, Cell, Cells, cell_faces, grid_families, grid_reach, runs_along_axes};
use crate::geometry::{Cloud, Families, GeometryError};
use crate::parallel;

/// Families, and the cell of every point that is held here.
#[derive(Debug, Clone)]
pub(crate) struct Tessellation<const D: usize> {
    /// The families given, or wider ones where these do not hold every face.
    pub families: Families<D>,
    /// How the cells are known.
    pub(super) kind: Cells,
    /// Empty ones for points of other processes.
    cells: Vec<Cell<D>>,
    /// Which of the cells each point has, shape `(n,)`; empty where every point has its own.
    kinds: Vec<u32>,
}

/// Points that a search for the faces of a cell may meet; cells of 2:1 blocks have some hundred.
const MOST: f64 = 20_000.0;

impl<const D: usize> Tessellation<D> {
    /// Finds the cells.
    ///
    /// # Errors
    /// As [`Families::search`].
    pub(crate) fn new(
        cloud: &Cloud<D>,
        families: Families<D>,
        kind: Cells,
    ) -> Result<Self, GeometryError> {
        if kind != Cells::Scattered {
            let reach = grid_reach(cloud, kind);
            let families = match enough(&families, &reach) {
                true => families,
                false if !runs_along_axes(cloud) => searched(cloud, &families, &reach)?,
                false => {
                    let (images, share) = (families.images.clone(), families.share.clone());
                    grid_families(cloud, images, share, families.horizon)?
                }
            };
            return Ok(Self::over(cloud, families, kind));
        }
        // What a family leaves of a cell bounds the cell, and so the distance of all neighbours.
        let first = Self::over(cloud, families, kind);
        let mut reach: Vec<f64> = first.cells.iter().map(|cell| cell.reach).collect();
        first.families.share.complete(&mut reach, 1);
        if enough(&first.families, &reach) {
            return Ok(first);
        }
        let ball = |point: usize| reach[point].powi(D as i32) / cloud.volume[point];
        match (0..cloud.len()).find(|point| ball(*point) > MOST) {
            Some(point) => Err(GeometryError::FlatCell {
                point,
                count: ball(point) as usize,
            }),
            None => {
                let families = searched(cloud, &first.families, &reach)?;
                Ok(Self::over(cloud, families, kind))
            }
        }
    }

    fn over(cloud: &Cloud<D>, families: Families<D>, kind: Cells) -> Self {
        let cell = |owner: usize| {
            let arm = |bond| {
                let end = families.neighbour(bond);
                (end, families.bond_vector(cloud, owner, bond))
            };
            let arms: Vec<Arm<D>> = families.family(owner).map(arm).collect();
            match families.share.holds(owner) {
                true => cell_faces(cloud, kind, owner, &arms),
                false => Cell::default(),
            }
        };
        let equal = matches!(kind, Cells::Lattice | Cells::Oblique);
        let Some(alike) = equal.then(|| families.alike(cloud)).flatten() else {
            let cells = parallel::map(families.len(), cell);
            return Tessellation {
                families,
                kind,
                cells,
                kinds: Vec::new(),
            };
        };
        let (mut cells, mut kinds) = (Vec::new(), Vec::with_capacity(alike.len()));
        for (point, &first) in alike.iter().enumerate() {
            if first as usize == point {
                kinds.push(cells.len() as u32);
                cells.push(cell(point));
            } else {
                kinds.push(kinds[first as usize]);
            }
        }
        Tessellation {
            families,
            kind,
            cells,
            kinds,
        }
    }

    /// The cell of a point.
    pub(super) fn cell(&self, point: usize) -> &Cell<D> {
        let kind = self.kinds.get(point).map(|kind| *kind as usize);
        &self.cells[kind.unwrap_or(point)]
    }

    /// Volumes of all cells, m^D. All processes must call this together.
    pub(super) fn volumes(&self) -> Vec<f64> {
        let mut volume: Vec<f64> = (0..self.families.len())
            .map(|point| self.cell(point).volume)
            .collect();
        self.families.share.complete(&mut volume, 1);
        volume
    }
}

/// Whether every family reaches as far as it should.
fn enough<const D: usize>(families: &Families<D>, reach: &[f64]) -> bool {
    let mut pairs = reach.iter().zip(&families.horizon);
    pairs.all(|(reach, horizon)| reach <= horizon)
}

/// The families, searched anew as far as they should reach.
fn searched<const D: usize>(
    cloud: &Cloud<D>,
    families: &Families<D>,
    reach: &[f64],
) -> Result<Families<D>, GeometryError> {
    let pairs = reach.iter().zip(&families.horizon);
    let horizon: Vec<f64> = pairs.map(|(reach, own)| reach.max(*own)).collect();
    let share = &families.share;
    match share.partition() {
        None => Families::search(cloud, horizon),
        Some(partition) => {
            let held = (0..families.len()).filter(|point| share.holds(*point));
            let watched: Vec<usize> = held.collect();
            Families::search_share(cloud, horizon, Some(partition.clone()), &watched)
        }
    }
}
