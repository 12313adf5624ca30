//! The tentative prolongation: an orthonormal basis of the near-nullspace on each aggregate.

use super::aggregation::{Aggregates, NONE};
use super::block::{BlockMatrix, BlockPattern};
use super::modes::Modes;
use crate::parallel;

/// A mode that the others of an aggregate explain up to this part is left out: rotations of
/// single points, one rotation of collinear points.
const DEPENDENT: f64 = 1e-8;

/// Prolongation before smoothing, with what the next level needs.
pub(super) struct Tentative {
    /// One block for each point of an aggregate.
    pub(super) matrix: BlockMatrix<f64>,
    /// The near-nullspace of the coarse level: `matrix` times these modes gives the fine ones.
    pub(super) coarse: Modes,
    /// Coarse unknowns without a basis function.
    pub(super) missing: Vec<usize>,
}

/// Orthonormal factors of the modes on one aggregate.
struct Factors {
    /// Values of the basis, member after member, unknown after unknown.
    basis: Vec<f64>,
    /// Upper triangle, by rows.
    triangle: Vec<f64>,
}

/// Builds the tentative prolongation. Unknowns that are not free get rows of zeros.
pub(super) fn tentative(
    aggregates: &Aggregates,
    modes: &Modes,
    free: &[bool],
    size: usize,
) -> Tentative {
    let count = modes.count;
    let members = aggregates.members();
    let factors: Vec<Factors> = parallel::map(members.len(), |aggregate| {
        factorise(&members[aggregate], modes, free, size)
    });
    let rows = aggregates.of.iter().map(|aggregate| match *aggregate {
        NONE => Vec::new(),
        aggregate => vec![aggregate],
    });
    let mut matrix = BlockMatrix::zeros(BlockPattern::from_rows(rows), size, count);
    let mut coarse = Vec::with_capacity(members.len() * count * count);
    let mut missing = Vec::new();
    for (aggregate, (members, factors)) in members.iter().zip(&factors).enumerate() {
        for (point, block) in members.iter().zip(factors.basis.chunks_exact(size * count)) {
            let start = matrix.pattern.starts[*point as usize] * size * count;
            matrix.values[start..][..size * count].copy_from_slice(block);
        }
        let dropped = |mode: &usize| factors.triangle[mode * count + mode] <= 0.0;
        missing.extend(
            (0..count)
                .filter(dropped)
                .map(|mode| aggregate * count + mode),
        );
        coarse.extend(&factors.triangle);
    }
    let coarse = Modes {
        count,
        values: coarse,
    };
    Tentative {
        matrix,
        coarse,
        missing,
    }
}

/// Gram–Schmidt, each projection done twice, which makes the basis orthonormal to rounding.
fn factorise(members: &[u32], modes: &Modes, free: &[bool], size: usize) -> Factors {
    let count = modes.count;
    let unknowns: Vec<usize> = members
        .iter()
        .flat_map(|point| *point as usize * size..(*point as usize + 1) * size)
        .collect();
    let mut triangle = vec![0.0; count * count];
    let mut columns: Vec<Vec<f64>> = Vec::with_capacity(count);
    for mode in 0..count {
        let value = |unknown: &usize| {
            let value = modes.values[*unknown * count + mode];
            if free[*unknown] { value } else { 0.0 }
        };
        let mut column: Vec<f64> = unknowns.iter().map(value).collect();
        let before = length(&column);
        for (other, basis) in columns.iter().enumerate().chain(columns.iter().enumerate()) {
            let part: f64 = basis.iter().zip(&column).map(|(a, b)| a * b).sum();
            triangle[other * count + mode] += part;
            column
                .iter_mut()
                .zip(basis)
                .for_each(|(value, basis)| *value -= part * basis);
        }
        let left = length(&column);
        if left > DEPENDENT * before {
            triangle[mode * count + mode] = left;
            column.iter_mut().for_each(|value| *value /= left);
        } else {
            column.fill(0.0);
        }
        columns.push(column);
    }
    let rows = 0..unknowns.len();
    let basis = rows
        .flat_map(|row| columns.iter().map(move |column| column[row]))
        .collect();
    Factors { basis, triangle }
}

fn length(column: &[f64]) -> f64 {
    column.iter().map(|value| value * value).sum::<f64>().sqrt()
}
