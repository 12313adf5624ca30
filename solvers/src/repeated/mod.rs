//! Products with matrices of which many rows are the same but for their place, as on lattices.
//!
//! Every distinct row is kept once, its columns as distances from the diagonal. A product reads these few rows
//! again and again instead of streaming all entries of the matrix, and has the same bits.

mod planes;

use std::collections::HashMap;

use crate::CsrView;
use crate::matrix::{Rows, four_sums};
use crate::parallel;

use self::planes::Planes;

/// Rows per parallel task, as in other products.
const ROWS_PER_TASK: usize = 512;
/// Entries of the matrix for each that is kept, at least. Where rows repeat less often the matrix itself serves:
/// its entries are read once either way, and a row for every entry kept makes up for the search.
const WORTHWHILE: usize = 4;

/// The distinct rows of a matrix.
#[derive(Debug, Clone)]
pub struct RepeatedRows {
    /// Which of the distinct rows each row is, shape `(rows,)`.
    kinds: Vec<u32>,
    /// The first row of each kind, shape `(kinds,)`.
    first: Vec<u32>,
    /// Start of each distinct row, shape `(kinds + 1,)`.
    starts: Vec<u32>,
    /// Columns less the row.
    distances: Vec<i32>,
    values: Vec<f64>,
    /// Runs of rows that are the same, where they are long.
    planes: Option<Planes>,
}

impl RepeatedRows {
    /// Finds the rows of a matrix that repeat to the last bit; `None` where too few do.
    #[must_use]
    pub fn of(matrix: CsrView<'_>) -> Option<Self> {
        let rows = Rows::new(&matrix);
        let most = matrix.nnz() / WORTHWHILE;
        let mut found = RepeatedRows {
            kinds: Vec::with_capacity(matrix.rows()),
            first: Vec::new(),
            starts: vec![0],
            distances: Vec::new(),
            values: Vec::new(),
            planes: None,
        };
        let mut known: HashMap<u64, u32> = HashMap::new();
        for row in 0..matrix.rows() {
            let next = found.starts.len() as u32 - 1;
            let kind = *known.entry(hash(&rows, row)).or_insert(next);
            if kind == next {
                found.keep(&rows, row);
                if found.values.len() > most {
                    return None;
                }
            } else if !found.is(kind, &rows, row) {
                return None;
            }
            found.kinds.push(kind);
        }
        found.planes = Planes::of(&found);
        Some(found)
    }

    /// Takes the values of a matrix with the pattern of the one these rows are from; false, and of no use any more, where
    /// rows that were the same are not now.
    #[must_use]
    pub(crate) fn refill(&mut self, matrix: CsrView<'_>) -> bool {
        let rows = Rows::new(&matrix);
        let same = |row: usize| {
            let first = self.first[self.kinds[row] as usize] as usize;
            first == row || is_same(rows.row(first).1, rows.row(row).1)
        };
        let count = self.kinds.len();
        if matrix.rows() != count || !parallel::all(count, ROWS_PER_TASK, same) {
            return false;
        }
        let ranges = self.starts.windows(2).zip(&self.first);
        for (range, first) in ranges {
            let own = &mut self.values[range[0] as usize..range[1] as usize];
            let values = rows.row(*first as usize).1;
            if own.len() != values.len() {
                return false;
            }
            own.copy_from_slice(values);
        }
        true
    }

    /// Diagonal of the matrix.
    pub(crate) fn diagonal(&self) -> Vec<f64> {
        let of_kind = |kind: u32| {
            let (distances, values) = self.kind(kind);
            let found = distances.binary_search(&0);
            found.map_or(0.0, |place| values[place])
        };
        let kinds: Vec<f64> = (0..self.first.len() as u32).map(of_kind).collect();
        self.kinds
            .iter()
            .map(|kind| kinds[*kind as usize])
            .collect()
    }

    /// Whether a row is the first of its kind.
    pub(crate) fn is_first(&self, row: usize) -> bool {
        self.first[self.kinds[row] as usize] as usize == row
    }

    /// Bytes kept.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let indices = [&self.kinds, &self.first, &self.starts].map(Vec::len);
        4 * (indices.iter().sum::<usize>() + self.distances.len())
            + 8 * self.values.len()
            + self.planes.as_ref().map_or(0, Planes::bytes)
    }

    /// Computes `y = A x`, parallel over rows, with the bits of [`crate::multiply`].
    ///
    /// # Panics
    /// If `x` or `y` have not as many entries as the matrix has rows.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        if let Some(planes) = &self.planes {
            return planes.multiply(self, x, y);
        }
        parallel::each(y, ROWS_PER_TASK, |row, value| *value = self.times(row, x));
    }

    /// Computes `r = b − A x`, parallel over rows, with the bits of [`crate::residual`].
    ///
    /// # Panics
    /// As [`Self::multiply`].
    pub(crate) fn residual(&self, x: &[f64], b: &[f64], r: &mut [f64]) {
        self.multiply(x, r);
        r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
    }

    fn kind(&self, kind: u32) -> (&[i32], &[f64]) {
        let kind = kind as usize;
        let range = self.starts[kind] as usize..self.starts[kind + 1] as usize;
        (&self.distances[range.clone()], &self.values[range])
    }

    fn times(&self, row: usize, x: &[f64]) -> f64 {
        let (distances, values) = self.kind(self.kinds[row]);
        four_sums(distances, values, |distance| {
            x[row.wrapping_add_signed(*distance as isize)]
        })
    }

    fn keep(&mut self, rows: &Rows<'_>, row: usize) {
        let (columns, values) = rows.row(row);
        let distances = columns.iter().map(|column| distance(*column, row));
        self.first.push(row as u32);
        self.distances.extend(distances);
        self.values.extend_from_slice(values);
        self.starts.push(self.values.len() as u32);
    }

    /// Whether a row is one of these.
    fn is(&self, kind: u32, rows: &Rows<'_>, row: usize) -> bool {
        let ((distances, own), (columns, values)) = (self.kind(kind), rows.row(row));
        let near = |(own, column): (&i32, &u32)| *own == distance(*column, row);
        is_same(own, values) && distances.iter().zip(columns).all(near)
    }
}

/// Whether two rows have the same bits. All are looked at, which is faster than to stop at the first that differ.
fn is_same(one: &[f64], other: &[f64]) -> bool {
    let pairs = one.iter().zip(other);
    let differ = pairs.fold(0, |bits, (a, b)| bits | (a.to_bits() ^ b.to_bits()));
    one.len() == other.len() && differ == 0
}

fn distance(column: u32, row: usize) -> i32 {
    column.wrapping_sub(row as u32) as i32
}

/// Of distances and values to the last bit (the multiplier of FNV-1a, by words). Rows of one hash are compared, so
/// that a poor one costs time only.
fn hash(rows: &Rows<'_>, row: usize) -> u64 {
    let (columns, values) = rows.row(row);
    let pairs = columns.iter().zip(values);
    pairs.fold(0xcbf2_9ce4_8422_2325, |hash: u64, (column, value)| {
        let distance = u64::from(distance(*column, row) as u32).rotate_left(40);
        let word = value.to_bits() ^ distance;
        (hash ^ word)
            .wrapping_mul(0x0000_0100_0000_01b3)
            .rotate_left(23)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::noise;
    use crate::{CsrMatrix, multiply, residual};

    /// Springs between neighbours of a lattice, and to those two away along the rows.
    fn lattice_matrix([along, across]: [usize; 2]) -> CsrMatrix {
        let points = along * across;
        let mut triplets = sprs::TriMatI::<f64, u32>::new((points, points));
        for row in 0..points {
            triplets.add_triplet(row, row, 4.1);
            for (step, value) in [(1, -0.7), (2, -0.3), (along, -1.1)] {
                if row + step < points {
                    triplets.add_triplet(row, row + step, value);
                    triplets.add_triplet(row + step, row, value);
                }
            }
        }
        triplets.to_csr()
    }

    fn vector(length: usize, seed: usize) -> Vec<f64> {
        (0..length).map(|k| noise(k + seed * length)).collect()
    }

    #[test]
    fn products_have_the_bits_of_the_whole_matrix() {
        let matrix = lattice_matrix([40, 30]);
        let repeated = RepeatedRows::of(matrix.view()).unwrap();
        assert!(10 * repeated.bytes() < 12 * matrix.nnz());
        let (x, b) = (vector(matrix.rows(), 1), vector(matrix.rows(), 2));
        let (mut slow, mut fast) = (vec![0.0; x.len()], vec![1.0; x.len()]);
        multiply(matrix.view(), &x, &mut slow);
        repeated.multiply(&x, &mut fast);
        assert_eq!(slow, fast);
        residual(matrix.view(), &x, &b, &mut slow);
        repeated.residual(&x, &b, &mut fast);
        assert_eq!(slow, fast);
    }

    /// Three unknowns a point, all coupled to those of the next points, with rows of any length.
    fn coupled_matrix([along, across]: [usize; 2], others: usize) -> CsrMatrix {
        let points = along * across;
        let mut triplets = sprs::TriMatI::<f64, u32>::new((3 * points, 3 * points));
        for (row, unknown) in (0..points).flat_map(|row| (0..3).map(move |unknown| (row, unknown)))
        {
            for step in [0, 1, 2, along] {
                for (other, back) in (0..others).flat_map(|other| [(other, false), (other, true)]) {
                    let column = if back {
                        row.wrapping_sub(step)
                    } else {
                        row + step
                    };
                    if column < points && !(back && step == 0) {
                        let value = noise(100 * step + 10 * unknown + other);
                        triplets.add_triplet(3 * row + unknown, 3 * column + other, value);
                    }
                }
            }
        }
        triplets.to_csr()
    }

    #[test]
    fn products_of_several_unknowns_have_the_bits_of_the_whole_matrix() {
        for (size, others) in [([61, 5], 3), ([24, 11], 2), ([9, 40], 1)] {
            let matrix = coupled_matrix(size, others);
            let repeated = RepeatedRows::of(matrix.view()).unwrap();
            let x = vector(matrix.rows(), 4);
            let (mut slow, mut fast) = (vec![0.0; x.len()], vec![1.0; x.len()]);
            multiply(matrix.view(), &x, &mut slow);
            for threads in [1, 3] {
                crate::test_support::in_pool(threads, || repeated.multiply(&x, &mut fast));
                assert_eq!(slow, fast);
            }
        }
    }

    #[test]
    fn new_values_are_taken_where_the_same_rows_repeat_and_refused_elsewhere() {
        let mut matrix = lattice_matrix([40, 30]);
        let mut repeated = RepeatedRows::of(matrix.view()).unwrap();
        for value in matrix.data_mut() {
            *value *= 1.0 + *value;
        }
        assert!(repeated.refill(matrix.view()));
        assert_eq!(repeated.diagonal(), crate::matrix::diagonal(matrix.view()));
        let x = vector(matrix.rows(), 5);
        let (mut slow, mut fast) = (vec![0.0; x.len()], vec![1.0; x.len()]);
        multiply(matrix.view(), &x, &mut slow);
        repeated.multiply(&x, &mut fast);
        assert_eq!(slow, fast);
        let middle = matrix.nnz() / 2;
        let value = &mut matrix.data_mut()[middle];
        *value = value.next_up();
        assert!(!repeated.refill(matrix.view()));
        assert!(!repeated.refill(lattice_matrix([40, 31]).view()));
    }

    #[test]
    fn rows_that_differ_in_the_last_bit_are_not_the_same() {
        let mut matrix = lattice_matrix([40, 30]);
        let kinds = |matrix: &CsrMatrix| RepeatedRows::of(matrix.view()).unwrap().starts.len();
        let before = kinds(&matrix);
        let middle = matrix.nnz() / 2;
        let value = &mut matrix.data_mut()[middle];
        *value = value.next_up();
        assert_eq!(kinds(&matrix), before + 1);
    }

    #[test]
    fn a_matrix_without_repetition_keeps_its_rows() {
        let mut matrix = lattice_matrix([20, 20]);
        let values = vector(matrix.nnz(), 3);
        matrix.data_mut().copy_from_slice(&values);
        assert!(RepeatedRows::of(matrix.view()).is_none());
    }
}
