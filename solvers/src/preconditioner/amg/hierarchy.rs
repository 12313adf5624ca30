//! The levels: built once, refreshed where values changed.

use super::aggregation::{Aggregates, Couplings, aggregate};
use super::block::{BlockMatrix, BlockPattern, BlockRows, ROWS_PER_TASK, rows_of};
use super::coarsest::Coarsest;
use super::modes::Modes;
use super::smoother::{Polynomial, Smoother};
use super::tentative::tentative;
use super::transfer::Transfer;
use crate::SolveError;
use crate::parallel;

/// Coarsening that leaves more than this part of the points has come to its end.
const STALLED: f64 = 0.7;

/// What shapes a hierarchy.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Couplings up to this strength do not join points.
    pub(super) threshold: f64,
    pub(super) polynomial: Polynomial,
    /// Unknowns that are solved directly.
    pub(super) coarsest: usize,
}

/// One level above the coarsest.
pub(super) struct Level {
    pub(super) matrix: BlockMatrix<f32>,
    pub(super) smoother: Smoother,
    pub(super) transfer: Transfer,
    pub(super) work: Work,
}

/// Vectors of a level: solution, residual and two for the smoother.
pub(super) struct Work {
    pub(super) x: Vec<f64>,
    pub(super) r: Vec<f64>,
    pub(super) direction: Vec<f64>,
    pub(super) scaled: Vec<f64>,
}

impl Work {
    fn new(length: usize) -> Self {
        let [x, r, direction, scaled] = std::array::from_fn(|_| vec![0.0; length]);
        Self {
            x,
            r,
            direction,
            scaled,
        }
    }
}

/// All levels of one matrix.
pub(super) struct Hierarchy {
    pub(super) levels: Vec<Level>,
    pub(super) coarsest: Coarsest,
    pub(super) coarsest_x: Vec<f64>,
    pub(super) polynomial: Polynomial,
}

impl Hierarchy {
    /// Builds every level for a matrix and its near-nullspace.
    pub(super) fn build(
        finest: &dyn BlockRows,
        modes: &Modes,
        shape: Shape,
    ) -> Result<Self, SolveError> {
        let mut levels: Vec<Level> = Vec::new();
        let mut modes = modes.clone();
        loop {
            let source = source_of(&levels, finest);
            let (size, _) = source.shape();
            if source.pattern().rows() * size <= shape.coarsest {
                break;
            }
            let couplings = Couplings::of(source);
            let Some(aggregates) = coarsen(source.pattern(), &couplings, shape.threshold) else {
                break;
            };
            let level = Level::build(source, &aggregates, &couplings.free, &mut modes);
            levels.push(level);
        }
        let coarsest = Coarsest::new(source_of(&levels, finest))?;
        Ok(Self {
            coarsest_x: vec![0.0; coarsest.unknowns()],
            levels,
            coarsest,
            polynomial: shape.polynomial,
        })
    }

    /// Takes new values with the aggregates and prolongations as they are. Returns how many
    /// points of the finest level have other values than before.
    pub(super) fn refresh(&mut self, finest: &dyn BlockRows) -> Result<usize, SolveError> {
        let mut count = 0;
        for index in 0..self.levels.len() {
            let (above, rest) = self.levels.split_at_mut(index);
            let (source, level) = (source_of(above, finest), &mut rest[0]);
            let changed = fill(&mut level.matrix, source);
            let found = changed.iter().filter(|changed| **changed).count();
            if index == 0 {
                count = found;
            }
            if found == 0 {
                return Ok(count);
            }
            let changed = (2 * found < changed.len()).then_some(changed.as_slice());
            level.smoother.refresh(source, &level.matrix, changed);
            level.transfer.refresh(source, changed);
        }
        self.coarsest.refresh(source_of(&self.levels, finest))?;
        Ok(count)
    }

    /// Stored entries of all levels over those of the finest.
    pub(super) fn complexity(&self) -> f64 {
        let entries = |level: &Level| level.matrix.values.len() as f64;
        let Some(first) = self.levels.first() else {
            return 1.0;
        };
        let last = self
            .levels
            .last()
            .map_or(0, |level| level.transfer.coarse.values.len());
        (self.levels.iter().map(entries).sum::<f64>() + last as f64) / entries(first)
    }

    /// Stored entries of all levels and the coarsest factor.
    pub(super) fn nonzeros(&self) -> u64 {
        let entries = |level: &Level| level.matrix.values.len() as u64;
        self.levels.iter().map(entries).sum::<u64>() + self.coarsest.nonzeros()
    }

    pub(super) fn bytes(&self) -> usize {
        let level = |level: &Level| {
            level.matrix.bytes()
                + level.smoother.bytes()
                + level.transfer.bytes()
                + 32 * level.work.x.len()
        };
        self.levels.iter().map(level).sum::<usize>() + self.coarsest.bytes()
    }
}

impl Level {
    /// Builds one level and replaces the modes by those of the next.
    fn build(
        source: &dyn BlockRows,
        aggregates: &Aggregates,
        free: &[bool],
        modes: &mut Modes,
    ) -> Self {
        let (size, _) = source.shape();
        let mut matrix = BlockMatrix::zeros(source.pattern().clone(), size, size);
        fill(&mut matrix, source);
        let smoother = Smoother::new(source, &matrix);
        let tentative = tentative(aggregates, modes, free, size);
        let transfer = Transfer::new(source, &tentative, &smoother);
        *modes = tentative.coarse;
        let work = Work::new(matrix.rows() * size);
        Self {
            matrix,
            smoother,
            transfer,
            work,
        }
    }
}

/// The matrix of the level below the given ones.
fn source_of<'a>(levels: &'a [Level], finest: &'a dyn BlockRows) -> &'a dyn BlockRows {
    match levels.last() {
        Some(level) => &level.transfer.coarse,
        None => finest,
    }
}

/// Aggregates that leave clearly fewer points; weak couplings count if it takes them. `None` if
/// nothing helps.
fn coarsen(pattern: &BlockPattern, couplings: &Couplings, threshold: f64) -> Option<Aggregates> {
    let useful = |aggregates: &Aggregates| {
        (aggregates.count as f64) < STALLED * pattern.rows() as f64 && aggregates.count > 0
    };
    let with = |threshold| Some(aggregate(pattern, couplings, threshold)).filter(useful);
    with(threshold).or_else(|| with(0.0).filter(|_| threshold > 0.0))
}

/// Copies a matrix in single precision. Returns which rows have other values than before.
fn fill(matrix: &mut BlockMatrix<f32>, source: &dyn BlockRows) -> Vec<bool> {
    let area = matrix.area();
    let rows = rows_of(&matrix.pattern, &mut matrix.values, area);
    let mut rows: Vec<(&mut [f32], bool)> = rows.into_iter().map(|own| (own, false)).collect();
    parallel::each_with(&mut rows, ROWS_PER_TASK, Vec::new, |buffer, row, own| {
        source.load(row, buffer);
        let (out, changed) = own;
        for (out, value) in out.iter_mut().zip(buffer.iter()) {
            let value = *value as f32;
            *changed |= out.to_bits() != value.to_bits();
            *out = value;
        }
    });
    rows.into_iter().map(|(_, changed)| changed).collect()
}
