use super::support::*;
use crate::CsrMatrix;
use crate::matrix::Rows;
use crate::preconditioner::amg::aggregation::{Aggregates, Couplings, NONE, aggregate};
use crate::preconditioner::amg::block::{
    BlockMatrix, BlockPattern, BlockRows, PointBlocks, Update,
};
use crate::preconditioner::amg::dense;
use crate::preconditioner::amg::modes::Modes;
use crate::preconditioner::amg::smoother::Smoother;
use crate::preconditioner::amg::tentative::{Tentative, tentative};
use crate::preconditioner::amg::transfer::Transfer;
use crate::test_support::*;

/// The blocks of a matrix with `size` unknowns per point.
fn blocks(matrix: &CsrMatrix, size: usize) -> BlockMatrix<f64> {
    let view = matrix.view();
    let rows = Rows::new(&view);
    let pattern = BlockPattern::of_points(rows, matrix.rows() / size, size);
    let source = PointBlocks {
        matrix: rows,
        pattern: &pattern,
        size,
        scale: 1.0,
    };
    let mut blocks = BlockMatrix::zeros(pattern.clone(), size, size);
    let (mut buffer, mut values) = (Vec::new(), Vec::new());
    for row in 0..pattern.rows() {
        source.load(row, &mut buffer);
        values.extend(&buffer);
    }
    blocks.values = values;
    blocks
}

/// The step from one level to the next.
fn coarsened(source: &BlockMatrix<f64>, modes: &Modes) -> (Tentative, Transfer) {
    let mut single = BlockMatrix::zeros(source.pattern.clone(), source.height, source.width);
    single.values = source.values.iter().map(|value| *value as f32).collect();
    let couplings = Couplings::of(source);
    let aggregates = aggregate(&source.pattern, &couplings, 0.2);
    let smoother = Smoother::new(source, &single);
    let tentative = tentative(&aggregates, modes, &couplings.free, source.height);
    let transfer = Transfer::new(source, &tentative, &smoother);
    (tentative, transfer)
}

/// A block matrix as rows of numbers.
fn dense(matrix: &dyn BlockRows, block_columns: usize) -> Vec<Vec<f64>> {
    let (height, width) = matrix.shape();
    let mut rows = vec![vec![0.0; block_columns * width]; matrix.pattern().rows() * height];
    let mut buffer = Vec::new();
    for row in 0..matrix.pattern().rows() {
        matrix.load(row, &mut buffer);
        let blocks = buffer.chunks_exact(height * width);
        for (column, block) in matrix.pattern().row(row).iter().zip(blocks) {
            for (entry, value) in block.iter().enumerate() {
                let (i, j) = (entry / width, entry % width);
                rows[row * height + i][*column as usize * width + j] = *value;
            }
        }
    }
    rows
}

fn times(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let entry = |row: &Vec<f64>, j: usize| row.iter().zip(b).map(|(a, b)| a * b[j]).sum();
    let row = |row| (0..b[0].len()).map(|j| entry(row, j)).collect();
    a.iter().map(row).collect()
}

fn transposed(a: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..a[0].len())
        .map(|j| a.iter().map(|row| row[j]).collect())
        .collect()
}

fn mode(modes: &Modes, index: usize) -> Vec<f64> {
    modes
        .values
        .iter()
        .skip(index)
        .step_by(modes.count)
        .copied()
        .collect()
}

#[test]
fn prolongations_carry_the_rigid_modes_of_free_bodies_to_every_level() {
    for cloud in [square(30), jittered_cube(8, 0.2)] {
        let matrix = free_body(&cloud, 2.3, |_, _| 1.0);
        let mut modes = Modes::of(&elastic(&matrix, &cloud));
        let mut source = blocks(&matrix, cloud.dimension);
        for _ in 0..2 {
            let (tentative, transfer) = coarsened(&source, &modes);
            for index in 0..modes.count {
                let (fine, coarse) = (mode(&modes, index), mode(&tentative.coarse, index));
                let mut carried = vec![0.0; fine.len()];
                tentative.matrix.apply(&coarse, &mut carried, Update::Set);
                assert!(relative_error(&carried, &fine) < 1e-12);
                // The prolongation is stored in single precision.
                transfer
                    .prolongation
                    .apply(&coarse, &mut carried, Update::Set);
                assert!(relative_error(&carried, &fine) < 1e-6);
            }
            (modes, source) = (tentative.coarse, transfer.coarse);
        }
    }
}

#[test]
fn the_coarse_matrix_is_that_of_dense_products() {
    let cloud = square(14);
    let fine = blocks(&held_body(&cloud, 3.1, |_, _| 1.0), 2);
    let matrix = free_body(&cloud, 3.1, |_, _| 1.0);
    let (tentative, transfer) = coarsened(&fine, &Modes::of(&elastic(&matrix, &cloud)));
    assert!(tentative.missing.is_empty());
    let count = transfer.coarse.rows();
    let prolongation = dense(&transfer.prolongation, count);
    let product = times(&dense(&fine, fine.rows()), &prolongation);
    let exact = times(&transposed(&prolongation), &product).concat();
    let found = dense(&transfer.coarse, count);
    assert_eq!(found, transposed(&found));
    assert!(relative_error(&found.concat(), &exact) < 1e-12);
}

#[test]
fn a_partial_refresh_gives_the_bits_of_a_full_one() {
    let cloud = square(24);
    let matrix = held_body(&cloud, 3.1, |_, _| 1.0);
    let before = blocks(&matrix, 2);
    let after = blocks(&held_body(&cloud, 3.1, band(&cloud, 24, 0.3)), 2);
    let (_, mut transfer) = coarsened(&before, &Modes::of(&elastic(&matrix, &cloud)));
    let differs = |row: usize| before.row_values(row) != after.row_values(row);
    let changed: Vec<bool> = (0..after.rows()).map(differs).collect();
    assert!(changed.contains(&true) && changed.contains(&false));
    transfer.refresh(&after, Some(&changed));
    let partial = transfer.coarse.values.clone();
    transfer.refresh(&after, None);
    assert_eq!(partial, transfer.coarse.values);
}

#[test]
fn aggregates_hold_all_coupled_points_and_do_not_cross_weak_bonds() {
    let cloud = square(20);
    let left = |point: usize| cloud.coordinates[2 * point] < 9.5;
    let across = |a, b| if left(a) == left(b) { 1.0 } else { 1e-6 };
    let mut matrix = free_body(&cloud, 3.1, across);
    fix(&mut matrix, |unknown| unknown < 4);
    let blocks = blocks(&matrix, 2);
    let aggregates = aggregate(&blocks.pattern, &Couplings::of(&blocks), 0.2);
    let members = aggregates.members();
    assert!(aggregates.of[..2].iter().all(|of| *of == NONE));
    assert_eq!(members.iter().map(Vec::len).sum::<usize>(), 398);
    assert!(members.len() < 40);
    for members in members {
        assert!(
            members
                .iter()
                .all(|point| left(*point as usize) == left(members[0] as usize))
        );
    }
}

#[test]
fn single_and_collinear_points_get_as_many_modes_as_they_have() {
    let missing = |coordinates: &[f64]| {
        let points = coordinates.len() / 2;
        let cloud = Cloud {
            dimension: 2,
            coordinates: coordinates.to_vec(),
        };
        let matrix = free_body(&cloud, 1e3, |_, _| 1.0);
        let all = Aggregates {
            of: vec![0; points],
            count: 1,
        };
        let modes = Modes::of(&elastic(&matrix, &cloud));
        tentative(&all, &modes, &vec![true; 2 * points], 2).missing
    };
    assert_eq!(missing(&[3.0, 4.0]), [2]);
    assert!(missing(&[0.0, 0.0, 1.0, 0.0, 2.0, 0.0]).is_empty());
    assert_eq!(missing(&[5.0, 5.0, 5.0, 5.0]), [2]);
}

#[test]
fn the_bound_holds_the_spectrum_and_is_not_much_too_large() {
    let cloud = square(16);
    let matrix = held_body(&cloud, 3.1, |_, _| 1.0);
    let source = blocks(&matrix, 2);
    let mut single = BlockMatrix::zeros(source.pattern.clone(), 2, 2);
    single.values = source.values.iter().map(|value| *value as f32).collect();
    let smoother = Smoother::new(&source, &single);
    // Power iterations in the thousands as an independent way to the largest eigenvalue.
    let mut x = noisy_vector(matrix.rows());
    let (mut product, mut growth) = (x.clone(), 0.0);
    for _ in 0..3000 {
        source.apply(&x, &mut product, Update::Set);
        let before = crate::norm2(&x);
        smoother.scale(&product, &mut x);
        growth = crate::norm2(&x) / before;
        x.iter_mut().for_each(|value| *value /= growth);
    }
    assert!(growth < smoother.bound && smoother.bound < 1.15 * growth);
}

#[test]
fn inverses_of_blocks_leave_out_directions_without_stiffness() {
    let mut inverse = [0.0; 4];
    dense::invert(&[4.0, 1.0, 1.0, 2.0], 2, &mut inverse);
    let exact = [2.0 / 7.0, -1.0 / 7.0, -1.0 / 7.0, 4.0 / 7.0];
    assert!(relative_error(&inverse, &exact) < 1e-15);
    dense::invert(&[4.0, 0.0, 0.0, 0.0], 2, &mut inverse);
    assert!(relative_error(&inverse, &[0.25, 0.0, 0.0, 0.0]) < 1e-15);
}
