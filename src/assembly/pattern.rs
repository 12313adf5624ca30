//! Sparsity of an assembled operator, built row by row without triplets.

use rayon::prelude::*;

use crate::operators::BondForm;

/// Column indices of every row, sorted, diagonal included; symmetric.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// Start of every row in `columns`, shape `(n + 1,)`.
    pub offsets: Vec<u32>,
    /// Columns, shape `(nonzeros,)`.
    pub columns: Vec<u32>,
}

/// The matrix is too large for 32-bit indices.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the matrix would have {nonzeros} nonzeros, more than 32-bit indices can number; use the bond \
     operator, a smaller horizon or a coarser cloud"
)]
pub struct PatternError {
    /// Nonzeros counted.
    pub nonzeros: usize,
}

const CHUNK: usize = 512;

impl Pattern {
    /// Pattern of `form`: one hop, and two hops around points whose families couple.
    ///
    /// # Errors
    /// [`PatternError`] beyond 2³² nonzeros.
    pub fn new<const D: usize, F: BondForm<D>>(form: &F) -> Result<Self, PatternError> {
        let rows = form.neighbourhood().len();
        let chunks: Vec<(Vec<u32>, Vec<u32>)> = (0..rows.div_ceil(CHUNK))
            .into_par_iter()
            .map_init(
                || Marker::new(rows),
                |marker, chunk| {
                    let (mut counts, mut columns) = (Vec::with_capacity(CHUNK), Vec::new());
                    for row in chunk * CHUNK..((chunk + 1) * CHUNK).min(rows) {
                        let before = columns.len();
                        marker.row(form, row, &mut columns);
                        columns[before..].sort_unstable();
                        counts.push((columns.len() - before) as u32);
                    }
                    (counts, columns)
                },
            )
            .collect();
        let nonzeros: usize = chunks.iter().map(|(_, columns)| columns.len()).sum();
        if nonzeros > u32::MAX as usize {
            return Err(PatternError { nonzeros });
        }
        let mut pattern = Pattern {
            offsets: vec![0],
            columns: Vec::with_capacity(nonzeros),
        };
        let mut end = 0;
        for (counts, columns) in chunks {
            for count in counts {
                end += count;
                pattern.offsets.push(end);
            }
            pattern.columns.extend_from_slice(&columns);
        }
        Ok(pattern)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of stored entries.
    pub fn nonzeros(&self) -> usize {
        self.columns.len()
    }

    /// Range of a row in the columns and values.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.offsets[row] as usize..self.offsets[row + 1] as usize
    }

    /// Place of the diagonal entry of a row.
    pub fn diagonal(&self, row: usize) -> usize {
        let range = self.row(row);
        let start = range.start;
        start + self.columns[range].partition_point(|&column| (column as usize) < row)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        4 * (self.offsets.len() + self.columns.len())
    }
}

/// Remembers which columns of the current row have been seen.
struct Marker {
    seen: Vec<u32>,
}

impl Marker {
    fn new(rows: usize) -> Self {
        Marker {
            seen: vec![u32::MAX; rows],
        }
    }

    fn row<const D: usize, F: BondForm<D>>(
        &mut self,
        form: &F,
        row: usize,
        columns: &mut Vec<u32>,
    ) {
        let families = &form.neighbourhood().families;
        self.mark(row, row, columns);
        for bond in families.family(row) {
            self.mark(row, families.neighbour(bond), columns);
        }
        for (owner, _) in families.dual(row) {
            self.mark(row, owner, columns);
            if form.couples(owner) {
                for bond in families.family(owner) {
                    self.mark(row, families.neighbour(bond), columns);
                }
            }
        }
    }

    fn mark(&mut self, row: usize, column: usize, columns: &mut Vec<u32>) {
        if self.seen[column] != row as u32 {
            self.seen[column] = row as u32;
            columns.push(column as u32);
        }
    }
}
