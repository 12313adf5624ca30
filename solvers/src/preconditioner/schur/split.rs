//! The four blocks of an interleaved matrix whose last unknown of each point is another field.

use crate::matrix::Rows;
use crate::{CsrMatrix, CsrView};

/// K, −Bᵀ, −B and C of the matrix [K, −Bᵀ; −B, −C].
pub(super) struct Blocks {
    /// Unknowns per point of the whole matrix.
    size: usize,
    pub(super) stiffness: CsrMatrix,
    pub(super) gradient: CsrMatrix,
    pub(super) divergence: CsrMatrix,
    /// C, with the sign that makes it positive.
    pub(super) storage: CsrMatrix,
}

/// Columns of a block as they are found.
#[derive(Default)]
struct Pattern {
    starts: Vec<u32>,
    columns: Vec<u32>,
}

impl Pattern {
    fn end_row(&mut self) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.starts.push(self.columns.len() as u32);
    }

    fn finish(self, columns: usize) -> CsrMatrix {
        let Self {
            starts,
            columns: indices,
        } = self;
        let (rows, values) = (starts.len().saturating_sub(1), vec![0.0; indices.len()]);
        let starts = if rows == 0 { vec![0] } else { starts };
        CsrMatrix::new((rows, columns), starts, indices, values)
    }
}

impl Blocks {
    /// Takes the pattern of a matrix with `size` unknowns per point; all values are zero.
    pub(super) fn analyse(matrix: CsrView<'_>, size: usize) -> Self {
        let (rows, inner) = (Rows::new(&matrix), size - 1);
        let mut patterns: [Pattern; 4] = std::array::from_fn(|_| Pattern::default());
        for row in 0..matrix.rows() {
            let last = row % size == inner;
            let (first, second) = if last { (2, 3) } else { (0, 1) };
            for column in rows.row(row).0 {
                let (point, local) = (column / size as u32, column % size as u32);
                if local as usize == inner {
                    patterns[second].columns.push(point);
                } else {
                    patterns[first].columns.push(point * inner as u32 + local);
                }
            }
            patterns[first].end_row();
            patterns[second].end_row();
        }
        let points = matrix.rows() / size;
        let [stiffness, gradient, divergence, storage] = patterns;
        Self {
            size,
            stiffness: stiffness.finish(points * inner),
            gradient: gradient.finish(points),
            divergence: divergence.finish(points * inner),
            storage: storage.finish(points),
        }
    }

    /// Copies the values of a matrix of the same pattern.
    pub(super) fn fill(&mut self, matrix: CsrView<'_>) {
        let (rows, size) = (Rows::new(&matrix), self.size as u32);
        let mut stiffness = self.stiffness.data_mut().iter_mut();
        let mut gradient = self.gradient.data_mut().iter_mut();
        let mut divergence = self.divergence.data_mut().iter_mut();
        let mut storage = self.storage.data_mut().iter_mut();
        for row in 0..matrix.rows() {
            let (columns, values) = rows.row(row);
            let last = row as u32 % size == size - 1;
            for (column, value) in columns.iter().zip(values) {
                let slot = match (last, column % size == size - 1) {
                    (false, false) => stiffness.next(),
                    (false, true) => gradient.next(),
                    (true, false) => divergence.next(),
                    (true, true) => storage.next(),
                };
                if let Some(slot) = slot {
                    *slot = if last && column % size == size - 1 {
                        -value
                    } else {
                        *value
                    };
                }
            }
        }
    }

    /// Stored entries of all blocks.
    pub(super) fn nonzeros(&self) -> usize {
        let blocks = [
            &self.stiffness,
            &self.gradient,
            &self.divergence,
            &self.storage,
        ];
        blocks.iter().map(|block| block.nnz()).sum()
    }

    /// Separates a vector of the whole matrix into its two fields.
    pub(super) fn separate(&self, whole: &[f64], inner: &mut [f64], last: &mut [f64]) {
        let count = self.size - 1;
        let points = whole
            .chunks_exact(self.size)
            .zip(inner.chunks_exact_mut(count))
            .zip(last);
        for ((whole, inner), last) in points {
            inner.copy_from_slice(&whole[..count]);
            *last = whole[count];
        }
    }

    /// The reverse of [`Self::separate`].
    pub(super) fn join(&self, inner: &[f64], last: &[f64], whole: &mut [f64]) {
        let count = self.size - 1;
        let points = whole
            .chunks_exact_mut(self.size)
            .zip(inner.chunks_exact(count))
            .zip(last);
        for ((whole, inner), last) in points {
            whole[..count].copy_from_slice(inner);
            whole[count] = *last;
        }
    }
}
