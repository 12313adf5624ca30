//! Sparsity of an assembled operator, built row by row without triplets.

use perifrac_solvers::CsrMatrix;

use crate::geometry::Families;
use crate::operators::BondForm;
use crate::parallel;

/// Column indices of every row, sorted, diagonal included; symmetric. Rows that other processes hold
/// are empty.
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
        Self::of_families(&form.neighbourhood().families, |owner| form.couples(owner))
    }

    /// Pattern of an operator on `families` whose family of `owner` couples all its bonds where
    /// `couples(owner)`.
    ///
    /// # Errors
    /// [`PatternError`] beyond 2³² nonzeros.
    pub fn of_families<const D: usize>(
        families: &Families<D>,
        couples: impl Fn(usize) -> bool + Sync,
    ) -> Result<Self, PatternError> {
        let rows = families.len();
        let start = || Marker::new(rows);
        let chunk_of = |marker: &mut Marker, chunk: usize| {
            let (mut counts, mut columns) = (Vec::with_capacity(CHUNK), Vec::new());
            for row in chunk * CHUNK..((chunk + 1) * CHUNK).min(rows) {
                let before = columns.len();
                if families.share.owns(row) {
                    marker.row(families, &couples, row, &mut columns);
                }
                columns[before..].sort_unstable();
                counts.push((columns.len() - before) as u32);
            }
            (counts, columns)
        };
        let chunks: Vec<(Vec<u32>, Vec<u32>)> =
            parallel::map_with(rows.div_ceil(CHUNK), 1, start, chunk_of);
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

    /// The pattern with `unknowns` per point, all of a point's unknowns coupled to all of another's.
    ///
    /// # Errors
    /// [`PatternError`] beyond 2³² nonzeros.
    pub fn expanded(&self, unknowns: usize) -> Result<Self, PatternError> {
        let nonzeros = self.nonzeros() * unknowns * unknowns;
        if nonzeros > u32::MAX as usize {
            return Err(PatternError { nonzeros });
        }
        let mut expanded = Pattern {
            offsets: Vec::with_capacity(self.rows() * unknowns + 1),
            columns: Vec::with_capacity(nonzeros),
        };
        expanded.offsets.push(0);
        for row in 0..self.rows() {
            for _ in 0..unknowns {
                for &column in &self.columns[self.row(row)] {
                    let first = column * unknowns as u32;
                    expanded.columns.extend(first..first + unknowns as u32);
                }
                expanded.offsets.push(expanded.columns.len() as u32);
            }
        }
        Ok(expanded)
    }

    /// A matrix of this pattern, filled with zeros.
    pub fn into_matrix(self) -> CsrMatrix {
        let (rows, nonzeros) = (self.rows(), self.nonzeros());
        CsrMatrix::new(
            (rows, rows),
            self.offsets,
            self.columns,
            vec![0.0; nonzeros],
        )
    }

    /// Everything that is in this pattern or in `other`, which has as many rows.
    ///
    /// # Errors
    /// [`PatternError`] beyond 2³² nonzeros.
    pub fn union(&self, other: &Pattern) -> Result<Self, PatternError> {
        let mut union = Pattern {
            offsets: vec![0],
            columns: Vec::with_capacity(self.nonzeros().max(other.nonzeros())),
        };
        for row in 0..self.rows() {
            let before = union.columns.len();
            union
                .columns
                .extend_from_slice(&self.columns[self.row(row)]);
            union
                .columns
                .extend_from_slice(&other.columns[other.row(row)]);
            union.columns[before..].sort_unstable();
            let mut end = before;
            for k in before..union.columns.len() {
                if end == before || union.columns[k] != union.columns[end - 1] {
                    union.columns[end] = union.columns[k];
                    end += 1;
                }
            }
            union.columns.truncate(end);
            union.offsets.push(end as u32);
        }
        match union.nonzeros() {
            nonzeros if nonzeros > u32::MAX as usize => Err(PatternError { nonzeros }),
            _ => Ok(union),
        }
    }

    /// Place of `column` in the columns and values, if it is in the pattern.
    pub fn find(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.row(row);
        let place = self.columns[range.clone()].binary_search(&(column as u32));
        place.ok().map(|k| range.start + k)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Rows that are stored here, with the place of their diagonal entry.
    pub fn diagonals(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let stored = |row: &usize| !self.row(*row).is_empty();
        (0..self.rows())
            .filter(stored)
            .map(|row| (row, self.diagonal(row)))
    }

    /// Number of stored entries.
    pub fn nonzeros(&self) -> usize {
        self.columns.len()
    }

    /// Range of a row in the columns and values.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.offsets[row] as usize..self.offsets[row + 1] as usize
    }

    /// Place of the diagonal entry of a row that is stored here.
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

/// Bytes of a matrix and its pattern.
pub(crate) fn matrix_bytes(matrix: &CsrMatrix) -> usize {
    12 * matrix.nnz() + 4 * (matrix.rows() + 1)
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

    fn row<const D: usize>(
        &mut self,
        families: &Families<D>,
        couples: &(impl Fn(usize) -> bool + Sync),
        row: usize,
        columns: &mut Vec<u32>,
    ) {
        self.mark(row, row, columns);
        for bond in families.family(row) {
            self.mark(row, families.neighbour(bond), columns);
        }
        for (owner, _) in families.dual(row) {
            self.mark(row, owner, columns);
            if couples(owner) {
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
