//! Strength of coupling and aggregates of points.

use super::block::{BlockPattern, BlockRows, ROWS_PER_TASK};
use crate::parallel;

/// A point of no aggregate: coupled to nothing, solved by the smoother.
pub(super) const NONE: u32 = u32::MAX;

/// What the values of a matrix say about its graph.
pub(super) struct Couplings {
    /// Norm of each block relative to the diagonal blocks of its row and column.
    strength: Vec<f32>,
    /// Unknowns coupled to another one; the rest would only disturb the coarse levels.
    pub(super) free: Vec<bool>,
    /// Points coupled to another one.
    coupled: Vec<bool>,
}

impl Couplings {
    pub(super) fn of(matrix: &dyn BlockRows) -> Self {
        let rows = matrix.pattern().rows();
        let norms_of = |buffer: &mut Vec<f64>, row: usize| row_norms(matrix, row, buffer);
        let rows = parallel::map_with(rows, ROWS_PER_TASK, Vec::new, norms_of);
        let (norms, free): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        let coupled = free.iter().map(|free: &RowFreedom| free.coupled).collect();
        let free = free.into_iter().flat_map(|row| row.free).collect();
        let strength = relative(matrix.pattern(), &norms);
        Self {
            strength,
            free,
            coupled,
        }
    }
}

struct RowFreedom {
    free: Vec<bool>,
    coupled: bool,
}

/// Frobenius norms of the blocks of a row, and which of its unknowns are coupled.
fn row_norms(matrix: &dyn BlockRows, row: usize, buffer: &mut Vec<f64>) -> (Vec<f64>, RowFreedom) {
    matrix.load(row, buffer);
    let (size, _) = matrix.shape();
    let mut norms = Vec::with_capacity(buffer.len() / (size * size));
    let mut freedom = RowFreedom {
        free: vec![false; size],
        coupled: false,
    };
    let blocks = buffer.chunks_exact(size * size);
    for (column, block) in matrix.pattern().row(row).iter().zip(blocks) {
        let own = *column as usize == row;
        norms.push(block.iter().map(|value| value * value).sum::<f64>().sqrt());
        for (entry, value) in block.iter().enumerate() {
            let (local, other) = (entry / size, entry % size);
            if value.abs() > 0.0 && !(own && local == other) {
                freedom.free[local] = true;
                freedom.coupled |= !own;
            }
        }
    }
    if !freedom.coupled {
        freedom.free.fill(false);
    }
    (norms, freedom)
}

/// |a_ij| / √(m_i m_j) for every block, where m is the largest coupling of a row; 0 on the
/// diagonal. Relative to the diagonal, no coupling of a wide stencil would look strong.
fn relative(pattern: &BlockPattern, norms: &[Vec<f64>]) -> Vec<f32> {
    let couplings = |row: usize| {
        let entries = pattern.row(row).iter().zip(&norms[row]);
        entries.map(move |(column, norm)| {
            let column = *column as usize;
            (column, if column == row { 0.0 } else { *norm })
        })
    };
    let largest: Vec<f64> = (0..pattern.rows())
        .map(|row| couplings(row).fold(0.0, |largest, (_, norm)| norm.max(largest)))
        .collect();
    let row_of = |row: usize| -> Vec<f32> {
        let relative = couplings(row).map(|(column, norm)| {
            if norm <= 0.0 {
                return 0.0;
            }
            // The smallest positive number keeps a tiny coupling distinct from none.
            let size = (largest[row] * largest[column]).sqrt();
            ((norm / size) as f32).clamp(f32::MIN_POSITIVE, f32::MAX)
        });
        relative.collect()
    };
    let rows: Vec<Vec<f32>> = parallel::map(pattern.rows(), row_of);
    rows.concat()
}

/// A partition of the coupled points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Aggregates {
    /// Aggregate of each point, or [`NONE`].
    pub(super) of: Vec<u32>,
    pub(super) count: usize,
}

impl Aggregates {
    /// The points of each aggregate in ascending order.
    pub(super) fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.count];
        for (point, aggregate) in self.of.iter().enumerate() {
            if *aggregate != NONE {
                members[*aggregate as usize].push(point as u32);
            }
        }
        members
    }
}

/// Greedy aggregation (Vaněk, Mandel & Brezina 1996, Computing 56, 179): whole neighbourhoods of
/// strong couplings first, then each point left over to the aggregate it is coupled to most, then
/// the rest among themselves. A coupling is strong above `threshold`.
pub(super) fn aggregate(
    pattern: &BlockPattern,
    couplings: &Couplings,
    threshold: f64,
) -> Aggregates {
    let strong = |row: usize| {
        let range = pattern.range(row);
        let entries = pattern.columns[range.clone()].iter();
        entries
            .zip(&couplings.strength[range])
            .filter(|(_, strength)| **strength > threshold as f32)
            .map(|(column, strength)| (*column as usize, *strength))
    };
    let mut of = vec![NONE; pattern.rows()];
    let mut count = 0;
    for point in (0..pattern.rows()).filter(|point| couplings.coupled[*point]) {
        let mut neighbours = strong(point).peekable();
        let alone = neighbours.peek().is_none();
        if of[point] == NONE && !alone && neighbours.all(|(other, _)| of[other] == NONE) {
            of[point] = count;
            strong(point).for_each(|(other, _)| of[other] = count);
            count += 1;
        }
    }
    join(&mut of, |point| strong(point).collect());
    for point in (0..pattern.rows()).filter(|point| couplings.coupled[*point]) {
        if of[point] == NONE {
            of[point] = count;
            for (other, _) in strong(point) {
                if of[other] == NONE {
                    of[other] = count;
                }
            }
            count += 1;
        }
    }
    Aggregates {
        of,
        count: count as usize,
    }
}

/// Gives each point without aggregate to the one of its strongest neighbour that had one.
fn join(of: &mut [u32], strong: impl Fn(usize) -> Vec<(usize, f32)>) {
    let before = of.to_vec();
    for point in (0..of.len()).filter(|point| before[*point] == NONE) {
        let mut best = 0.0;
        for (other, strength) in strong(point) {
            if before[other] != NONE && strength > best {
                (of[point], best) = (before[other], strength);
            }
        }
    }
}
