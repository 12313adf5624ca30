//! Products, norms and checks on CSR matrices with bits that do not depend on the threads.

use crate::SolveError;
use crate::parallel;

/// A borrowed matrix in full row storage with sorted columns and 32-bit indices.
pub type CsrView<'a> = sprs::CsMatViewI<'a, f64, u32>;
/// An owned matrix in full row storage with sorted columns and 32-bit indices.
pub type CsrMatrix = sprs::CsMatI<f64, u32>;

/// Rows per parallel task: large enough to hide the cost of a task.
const ROWS_PER_TASK: usize = 512;
/// Terms per partial sum. Fixed, so that the order of summation never depends on the threads.
const SUM_CHUNK: usize = 4096;

/// Columns and values of every row of a matrix, without the indirection of the container.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    starts: &'a [u32],
    columns: &'a [u32],
    values: &'a [f64],
}

impl<'a> Rows<'a> {
    pub(crate) fn new(matrix: &'a CsrView<'_>) -> Self {
        Self {
            starts: matrix.indptr().into_raw_storage(),
            columns: matrix.indices(),
            values: matrix.data(),
        }
    }

    pub(crate) fn starts(&self) -> &'a [u32] {
        self.starts
    }

    pub(crate) fn columns(&self) -> &'a [u32] {
        self.columns
    }

    pub(crate) fn values(&self) -> &'a [f64] {
        self.values
    }

    pub(crate) fn row(&self, row: usize) -> (&'a [u32], &'a [f64]) {
        let base = self.starts[0];
        let range = (self.starts[row] - base) as usize..(self.starts[row + 1] - base) as usize;
        (&self.columns[range.clone()], &self.values[range])
    }

    pub(crate) fn get(&self, row: usize, column: usize) -> f64 {
        let (columns, values) = self.row(row);
        let found = columns.binary_search_by(|entry| (*entry as usize).cmp(&column));
        found.map_or(0.0, |position| values[position])
    }

    fn times(&self, row: usize, x: &[f64]) -> f64 {
        let (columns, values) = self.row(row);
        four_sums(columns, values, |column| x[*column as usize])
    }
}

/// Σ value · x over a row, `at` giving what stands in x for a column. Four independent sums keep the floating-point
/// units busy.
#[inline]
pub(crate) fn four_sums<C>(columns: &[C], values: &[f64], at: impl Fn(&C) -> f64) -> f64 {
    let mut sums = [0.0; 4];
    let (column_blocks, value_blocks) = (columns.chunks_exact(4), values.chunks_exact(4));
    let tail_columns = column_blocks.remainder();
    let tail_values = value_blocks.remainder();
    for (columns, values) in column_blocks.zip(value_blocks) {
        for lane in 0..4 {
            sums[lane] += values[lane] * at(&columns[lane]);
        }
    }
    let mut tail = 0.0;
    for (column, value) in tail_columns.iter().zip(tail_values) {
        tail += value * at(column);
    }
    ((sums[0] + sums[1]) + (sums[2] + sums[3])) + tail
}

/// Computes `y = A x`, parallel over rows; every row is summed by one thread.
///
/// # Panics
/// If `x` is shorter than the columns or `y` longer than the rows of `matrix`.
pub fn multiply(matrix: CsrView<'_>, x: &[f64], y: &mut [f64]) {
    let rows = Rows::new(&matrix);
    parallel::each(y, ROWS_PER_TASK, |row, value| *value = rows.times(row, x));
}

/// Computes `r = b − A x`, parallel over rows.
///
/// # Panics
/// If `x` is shorter than the columns, or `r` longer than `b` or the rows of `matrix`.
pub fn residual(matrix: CsrView<'_>, x: &[f64], b: &[f64], r: &mut [f64]) {
    let rows = Rows::new(&matrix);
    parallel::each(r, ROWS_PER_TASK, |row, value| {
        *value = b[row] - rows.times(row, x);
    });
}

/// Sum of `term(i)` for `i < length`, in chunks of fixed length that are added in order.
fn ordered_sum(length: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    let partial = |chunk: usize| -> f64 {
        let start = chunk * SUM_CHUNK;
        (start..length.min(start + SUM_CHUNK)).map(&term).sum()
    };
    let sums = parallel::map(length.div_ceil(SUM_CHUNK), partial);
    sums.iter().sum()
}

/// Scalar product of the common length of `a` and `b`, summed in a fixed order.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    ordered_sum(a.len().min(b.len()), |i| a[i] * b[i])
}

/// Root of the sum of squares, rescaled where the squares leave the range of numbers.
pub(crate) fn ordered_norm(length: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    let square = ordered_sum(length, |i| term(i).powi(2));
    if square.is_nan() || (1e-280..1e280).contains(&square) {
        return square.sqrt();
    }
    let largest = (0..length).fold(0.0_f64, |largest, i| largest.max(term(i).abs()));
    if largest <= 0.0 || largest.is_infinite() {
        return largest;
    }
    largest * ordered_sum(length, |i| (term(i) / largest).powi(2)).sqrt()
}

/// Euclidean norm, summed in a fixed order; safe against overflow and underflow.
#[must_use]
pub fn norm2(a: &[f64]) -> f64 {
    ordered_norm(a.len(), |i| a[i])
}

/// Σ |a_ij| |x_j| over all stored entries, summed in a fixed order: ε times it is the size of the
/// rounding errors in A x.
#[must_use]
pub fn magnitude(matrix: CsrView<'_>, x: &[f64]) -> f64 {
    let rows = Rows::new(&matrix);
    ordered_sum(matrix.rows(), |row| {
        let (columns, values) = rows.row(row);
        let pairs = columns.iter().zip(values);
        pairs.map(|(j, value)| (value * x[*j as usize]).abs()).sum()
    })
}

/// Size of the rounding errors no solution can go below: ε ‖ |A||x| + |b| ‖₂ / ‖b‖₂.
pub(crate) fn rounding_floor(matrix: CsrView<'_>, x: &[f64], b: &[f64]) -> f64 {
    let size = ordered_norm(b.len(), rounding_sizes(&matrix, x, b));
    f64::EPSILON * size / norm2(b)
}

/// Entries of |A||x| + |b| by row.
pub(crate) fn rounding_sizes<'a>(
    matrix: &'a CsrView<'_>,
    x: &'a [f64],
    b: &'a [f64],
) -> impl Fn(usize) -> f64 + Sync + 'a {
    let rows = Rows::new(matrix);
    move |row| {
        let (columns, values) = rows.row(row);
        let terms = columns
            .iter()
            .zip(values)
            .map(|(j, value)| (value * x[*j as usize]).abs());
        terms.sum::<f64>() + b[row].abs()
    }
}

/// Whether |a_ij − a_ji| ≤ `tolerance` · max|a| for every stored entry; entries not stored are 0.
#[must_use]
pub fn is_symmetric(matrix: CsrView<'_>, tolerance: f64) -> bool {
    let rows = Rows::new(&matrix);
    let largest = rows
        .values
        .iter()
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let row_is_symmetric = |row: usize| {
        let (columns, values) = rows.row(row);
        columns.iter().zip(values).all(|(column, value)| {
            (value - rows.get(*column as usize, row)).abs() <= tolerance * largest
        })
    };
    matrix.rows() == matrix.cols() && parallel::all(matrix.rows(), ROWS_PER_TASK, row_is_symmetric)
}

/// Refuses rows with NaN or infinity, and rows of zeros. Rows of other processes are not looked at.
pub(crate) fn check_rows(
    matrix: CsrView<'_>,
    owns: impl Fn(usize) -> bool + Sync,
) -> Result<(), SolveError> {
    let rows = Rows::new(&matrix);
    let check = |row: usize| -> Option<SolveError> {
        let (_, values) = rows.row(row);
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Some(SolveError::NotFinite {
                what: "the matrix",
                row,
                value: *value,
            });
        }
        let empty = values.iter().all(|value| value.abs() == 0.0);
        empty.then_some(SolveError::Singular { row })
    };
    let faults = parallel::gather(matrix.rows(), |row, found| {
        if found.is_empty() && owns(row) {
            found.extend(check(row));
        }
    });
    faults.into_iter().next().map_or(Ok(()), Err)
}

/// Refuses NaN and infinity in a vector.
pub(crate) fn check_vector(what: &'static str, vector: &[f64]) -> Result<(), SolveError> {
    let fault = vector.iter().position(|value| !value.is_finite());
    fault.map_or(Ok(()), |row| {
        Err(SolveError::NotFinite {
            what,
            row,
            value: vector[row],
        })
    })
}

/// Diagonal of a square matrix.
pub(crate) fn diagonal(matrix: CsrView<'_>) -> Vec<f64> {
    let rows = Rows::new(&matrix);
    parallel::map(matrix.rows(), |row| rows.get(row, row))
}

/// Identity of a sparsity pattern: its sizes and a hash of its indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fingerprint {
    pub(crate) rows: usize,
    pub(crate) nonzeros: usize,
    hash: u64,
}

impl Fingerprint {
    pub(crate) fn of(matrix: CsrView<'_>) -> Self {
        let rows = Rows::new(&matrix);
        let hash = hash_indices(rows.starts) ^ hash_indices(rows.columns).rotate_left(1);
        Self {
            rows: matrix.rows(),
            nonzeros: matrix.nnz(),
            hash,
        }
    }
}

/// FNV-1a over blocks of indices, then over the hashes of the blocks.
fn hash_indices(indices: &[u32]) -> u64 {
    let block = |number: usize| {
        let first = number * INDICES_PER_BLOCK;
        hash_block(&indices[first..indices.len().min(first + INDICES_PER_BLOCK)])
    };
    let blocks = parallel::map(indices.len().div_ceil(INDICES_PER_BLOCK), block);
    blocks
        .iter()
        .fold(FNV_OFFSET, |hash, block| mix(hash, *block))
}

const INDICES_PER_BLOCK: usize = 1 << 16;
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// Both halves of a product of 128 bits, one instruction each on any processor of 64 bits.
fn mix(hash: u64, value: u64) -> u64 {
    const ODD: u128 = 0x9e37_79b9_7f4a_7c15;
    let product = u128::from(hash ^ value) * ODD;
    (product as u64) ^ ((product >> 64) as u64)
}

/// Four independent hashes of pairs hide the latency of the products.
fn hash_block(block: &[u32]) -> u64 {
    let mut lanes = [FNV_OFFSET; 4];
    let (eights, tail) = block.as_chunks::<8>();
    let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
    for own in eights {
        lanes = [
            mix(lanes[0], pair(own[0], own[1])),
            mix(lanes[1], pair(own[2], own[3])),
            mix(lanes[2], pair(own[4], own[5])),
            mix(lanes[3], pair(own[6], own[7])),
        ];
    }
    let tail = tail.iter().map(|index| u64::from(*index));
    lanes.into_iter().chain(tail).fold(FNV_OFFSET, mix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{grid_laplacian, in_pool, jittered_grid, wide_stencil};

    #[test]
    fn product_and_residual_match_the_container() {
        let cloud = jittered_grid(9, 7, 0.3);
        let a = wide_stencil(&cloud, 2, 2.3, 2);
        let x: Vec<f64> = (0..a.rows()).map(|i| (i as f64 * 0.7).sin()).collect();
        let mut y = vec![f64::NAN; a.rows()];
        multiply(a.view(), &x, &mut y);
        for (row, vector) in a.outer_iterator().enumerate() {
            let exact: f64 = vector.iter().map(|(j, value)| value * x[j]).sum();
            assert!((y[row] - exact).abs() <= 1e-12 * norm2(&y));
        }
        let mut r = vec![f64::NAN; a.rows()];
        residual(a.view(), &x, &y, &mut r);
        assert!(norm2(&r) <= 1e-14 * norm2(&y));
    }

    #[test]
    fn sums_have_the_same_bits_for_any_number_of_threads() {
        let a: Vec<f64> = (0..50_001).map(|i| (i as f64).sin() * 1e3).collect();
        let b: Vec<f64> = (0..50_001).map(|i| (i as f64).cos()).collect();
        let bits = |threads| in_pool(threads, || (dot(&a, &b).to_bits(), norm2(&a).to_bits()));
        assert_eq!(bits(1), bits(2));
        assert_eq!(bits(1), bits(3));
    }

    #[test]
    fn asymmetry_is_measured_against_the_largest_entry() {
        let mut a = grid_laplacian(6, 5, 0.0);
        assert!(is_symmetric(a.view(), 0.0));
        a.data_mut()[1] += 4e-6;
        assert!(!is_symmetric(a.view(), 0.9e-6));
        assert!(is_symmetric(a.view(), 1.1e-6));
        let one_sided = CsrMatrix::new((2, 2), vec![0, 2, 3], vec![0, 1, 1], vec![1.0; 3]);
        assert!(!is_symmetric(one_sided.view(), 0.5));
    }

    #[test]
    fn fingerprints_see_a_moved_entry_but_not_a_new_value() {
        let pattern = |column: u32| {
            CsrMatrix::new(
                (3, 3),
                vec![0, 1, 2, 3],
                vec![0, column, 2],
                vec![1.0, 2.0, 3.0],
            )
        };
        let print = Fingerprint::of(pattern(1).view());
        assert_ne!(print, Fingerprint::of(pattern(2).view()));
        let mut other = pattern(1);
        other.data_mut()[0] = 7.0;
        assert_eq!(print, Fingerprint::of(other.view()));
    }
}
