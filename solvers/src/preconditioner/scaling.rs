//! Scaling of the rows and columns of a matrix, so that pivots can be judged by their size.

use crate::CsrView;
use crate::matrix::{self, Rows};

/// Share of the largest entry of its row below which a diagonal entry does not stand for the row.
const INSIGNIFICANT: f64 = 1e-12;

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
