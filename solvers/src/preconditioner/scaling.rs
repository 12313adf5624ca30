//! Scaling of the rows and columns of a matrix, so that pivots can be judged by their size.

use crate::CsrView;
use crate::matrix::{self, Rows};

/// Share of the largest entry of its row below which a diagonal entry does not stand for the row.
const INSIGNIFICANT: f64 = 1e-12;
/// Sweeps that balance the rows of a matrix with eigenvalues of both signs.
const SWEEPS: usize = 4;

/// Size of every row: |a_ii|, or its largest entry where the diagonal is (nearly) zero.
pub(super) fn magnitudes(matrix: CsrView<'_>) -> Vec<f64> {
    let rows = Rows::new(&matrix);
    let sizes = matrix::diagonal(matrix).into_iter().enumerate();
    let magnitude = |(row, diagonal): (usize, f64)| {
        let (_, values) = rows.row(row);
        let largest = values
            .iter()
            .fold(0.0_f64, |size, value| size.max(value.abs()));
        let significant = diagonal.abs() > INSIGNIFICANT * largest;
        if significant { diagonal.abs() } else { largest }
    };
    sizes.map(magnitude).collect()
}

/// s with s_i² = 1/|a_ii|: the scaled matrix s_i a_ij s_j has the diagonal ±1.
pub(super) fn by_diagonal(matrix: CsrView<'_>) -> Vec<f64> {
    let sizes = magnitudes(matrix);
    sizes.into_iter().map(|size| 1.0 / size.sqrt()).collect()
}

/// s for which the largest entry of every row of s_i a_ij s_j is about 1 (Ruiz 2001, RAL-TR-2001-034).
/// For a positive definite matrix that is the scaling by the diagonal.
pub(super) fn by_largest(matrix: CsrView<'_>) -> Vec<f64> {
    let rows = Rows::new(&matrix);
    let mut scale = vec![1.0; matrix.rows()];
    for _ in 0..SWEEPS {
        let largest = |row: usize| {
            let (columns, values) = rows.row(row);
            let entries = columns.iter().zip(values);
            let sizes = entries.map(|(column, value)| (value * scale[*column as usize]).abs());
            scale[row] * sizes.fold(0.0_f64, f64::max)
        };
        let sizes: Vec<f64> = (0..matrix.rows()).map(largest).collect();
        for (scale, size) in scale.iter_mut().zip(sizes) {
            *scale /= size.sqrt();
        }
    }
    scale
}
