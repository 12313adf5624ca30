//! Sparse matrices of small dense blocks, one block row per point or aggregate.

use super::kernel::{Entry, row_kernel};
use crate::matrix::Rows;
use crate::parallel;

/// Block rows per parallel task.
pub(in crate::preconditioner) const ROWS_PER_TASK: usize = 256;

/// Which blocks are stored: the columns of each row in ascending order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(in crate::preconditioner) struct BlockPattern {
    pub(in crate::preconditioner) starts: Vec<usize>,
    pub(in crate::preconditioner) columns: Vec<u32>,
}

impl BlockPattern {
    pub(in crate::preconditioner) fn from_rows(rows: impl Iterator<Item = Vec<u32>>) -> Self {
        let mut pattern = Self {
            starts: vec![0],
            columns: Vec::new(),
        };
        for row in rows {
            pattern.columns.extend(row);
            pattern.starts.push(pattern.columns.len());
        }
        pattern
    }

    /// Blocks of points that hold the entries of a matrix with `size` unknowns per point.
    pub(in crate::preconditioner) fn of_points(
        matrix: Rows<'_>,
        points: usize,
        size: usize,
    ) -> Self {
        let row_of = |point: usize| -> Vec<u32> {
            let first = matrix.row(point * size).0;
            let others = (point * size + 1..(point + 1) * size).map(|row| matrix.row(row).0);
            let mut blocks: Vec<u32> = Vec::with_capacity(first.len());
            blocks.extend(first.iter().map(|column| column / size as u32));
            // The rows of a point are mostly alike.
            for other in others.filter(|other| *other != first) {
                blocks.extend(other.iter().map(|column| column / size as u32));
            }
            // A row without its diagonal block would leave the smoother without an inverse.
            if blocks.binary_search(&(point as u32)).is_err() {
                blocks.push(point as u32);
            }
            // Cheap where the blocks are sorted already.
            blocks.sort();
            blocks.dedup();
            blocks
        };
        let rows: Vec<Vec<u32>> = parallel::map(points, row_of);
        Self::from_rows(rows.into_iter())
    }

    pub(in crate::preconditioner) fn rows(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    pub(in crate::preconditioner) fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    pub(in crate::preconditioner) fn row(&self, row: usize) -> &[u32] {
        &self.columns[self.range(row)]
    }

    /// Position of a block among all stored ones.
    pub(in crate::preconditioner) fn find(&self, row: usize, column: usize) -> Option<usize> {
        let found = self.row(row).binary_search(&(column as u32));
        found.ok().map(|offset| self.starts[row] + offset)
    }

    /// The pattern of the transposed matrix, and for each of its blocks the position here.
    pub(in crate::preconditioner) fn transposed(&self, columns: usize) -> (Self, Vec<usize>) {
        let mut starts = vec![0; columns + 1];
        for column in &self.columns {
            starts[*column as usize + 1] += 1;
        }
        for column in 0..columns {
            starts[column + 1] += starts[column];
        }
        let mut next = starts.clone();
        let mut rows = vec![0; self.columns.len()];
        let mut positions = vec![0; self.columns.len()];
        for row in 0..self.rows() {
            for position in self.range(row) {
                let slot = &mut next[self.columns[position] as usize];
                (rows[*slot], positions[*slot]) = (row as u32, position);
                *slot += 1;
            }
        }
        let transposed = Self {
            starts,
            columns: rows,
        };
        (transposed, positions)
    }
}

/// What a product does to the vector it is written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::preconditioner) enum Update {
    Set,
    Add,
    Subtract,
}

/// A block matrix; each block is stored by rows.
#[derive(Debug, Clone)]
pub(in crate::preconditioner) struct BlockMatrix<T> {
    pub(in crate::preconditioner) pattern: BlockPattern,
    /// Rows of a block.
    pub(in crate::preconditioner) height: usize,
    /// Columns of a block.
    pub(in crate::preconditioner) width: usize,
    pub(in crate::preconditioner) values: Vec<T>,
}

impl<T: Entry> BlockMatrix<T> {
    pub(in crate::preconditioner) fn zeros(
        pattern: BlockPattern,
        height: usize,
        width: usize,
    ) -> Self {
        let values = vec![T::from_f64(0.0); pattern.columns.len() * height * width];
        Self {
            pattern,
            height,
            width,
            values,
        }
    }

    pub(in crate::preconditioner) fn rows(&self) -> usize {
        self.pattern.rows()
    }

    /// Number of entries of a block.
    pub(in crate::preconditioner) fn area(&self) -> usize {
        self.height * self.width
    }

    pub(in crate::preconditioner) fn row_values(&self, row: usize) -> &[T] {
        let range = self.pattern.range(row);
        &self.values[range.start * self.area()..range.end * self.area()]
    }

    pub(in crate::preconditioner) fn bytes(&self) -> usize {
        self.values.len() * size_of::<T>()
            + self.pattern.columns.len() * size_of::<u32>()
            + self.pattern.starts.len() * size_of::<usize>()
    }

    /// Product with a vector, parallel over rows; every row is summed by one thread.
    pub(in crate::preconditioner) fn apply(&self, x: &[f64], out: &mut [f64], update: Update) {
        self.apply_where(|_| true, x, out, update);
    }

    /// As [`Self::apply`], in the chosen rows only; the others of `out` stay.
    pub(in crate::preconditioner) fn apply_where(
        &self,
        chosen: impl Fn(usize) -> bool + Sync,
        x: &[f64],
        out: &mut [f64],
        update: Update,
    ) {
        let kernel = row_kernel::<T>(self.height, self.width);
        let sign = if update == Update::Subtract {
            -1.0
        } else {
            1.0
        };
        let task = |task: usize, out: &mut [f64]| {
            let first = task * ROWS_PER_TASK;
            let rows = out.chunks_exact_mut(self.height).enumerate();
            for (row, out) in rows.map(|(offset, out)| (first + offset, out)) {
                if !chosen(row) {
                    continue;
                }
                if update == Update::Set {
                    out.fill(0.0);
                }
                kernel(self.pattern.row(row), self.row_values(row), x, sign, out);
            }
        };
        let out = &mut out[..self.rows() * self.height];
        parallel::chunks(out, ROWS_PER_TASK * self.height, 1, task);
    }

    /// The transposed matrix; `columns` is the number of block columns.
    pub(in crate::preconditioner) fn transposed(&self, columns: usize) -> Self {
        let (pattern, positions) = self.pattern.transposed(columns);
        let area = self.area();
        let mut values = Vec::with_capacity(self.values.len());
        for position in positions {
            let block = &self.values[position * area..][..area];
            for column in 0..self.width {
                values.extend((0..self.height).map(|row| block[row * self.width + column]));
            }
        }
        Self {
            pattern,
            height: self.width,
            width: self.height,
            values,
        }
    }
}

/// The blocks of each row, to be written in parallel.
pub(in crate::preconditioner) fn rows_of<'a, T>(
    pattern: &BlockPattern,
    values: &'a mut [T],
    area: usize,
) -> Vec<&'a mut [T]> {
    let mut rest = values;
    let mut rows = Vec::with_capacity(pattern.rows());
    for row in 0..pattern.rows() {
        let (values, tail) = rest.split_at_mut(pattern.range(row).len() * area);
        rows.push(values);
        rest = tail;
    }
    rows
}

/// Blocks of a matrix that can be read row by row in double precision.
pub(in crate::preconditioner) trait BlockRows: Sync {
    fn pattern(&self) -> &BlockPattern;

    /// Rows and columns of a block.
    fn shape(&self) -> (usize, usize);

    /// Replaces the buffer by the blocks of a row.
    fn load(&self, row: usize, buffer: &mut Vec<f64>);
}

impl<T: Entry> BlockRows for BlockMatrix<T> {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn shape(&self) -> (usize, usize) {
        (self.height, self.width)
    }

    fn load(&self, row: usize, buffer: &mut Vec<f64>) {
        buffer.clear();
        buffer.extend(self.row_values(row).iter().map(|value| value.to_f64()));
    }
}

/// The matrix of the user, seen as blocks and multiplied by a factor.
pub(in crate::preconditioner) struct PointBlocks<'a> {
    pub(in crate::preconditioner) matrix: Rows<'a>,
    pub(in crate::preconditioner) pattern: &'a BlockPattern,
    pub(in crate::preconditioner) size: usize,
    pub(in crate::preconditioner) scale: f64,
}

impl BlockRows for PointBlocks<'_> {
    fn pattern(&self) -> &BlockPattern {
        self.pattern
    }

    fn shape(&self) -> (usize, usize) {
        (self.size, self.size)
    }

    fn load(&self, point: usize, buffer: &mut Vec<f64>) {
        let (blocks, size) = (self.pattern.row(point), self.size);
        buffer.clear();
        buffer.resize(blocks.len() * size * size, 0.0);
        for local in 0..size {
            let (columns, values) = self.matrix.row(point * size + local);
            if size == 1 && values.len() == blocks.len() {
                let entries = buffer.iter_mut().zip(values);
                entries.for_each(|(entry, value)| *entry = self.scale * value);
                continue;
            }
            if values.len() == blocks.len() * size {
                // All blocks are full: the entries follow each other.
                let rows = buffer.chunks_exact_mut(size).skip(local).step_by(size);
                for (row, values) in rows.zip(values.chunks_exact(size)) {
                    for (entry, value) in row.iter_mut().zip(values) {
                        *entry = self.scale * value;
                    }
                }
                continue;
            }
            let mut block = 0;
            for (column, value) in columns.iter().zip(values) {
                while blocks[block] < column / size as u32 {
                    block += 1;
                }
                let entry = (block * size + local) * size + *column as usize % size;
                buffer[entry] = self.scale * value;
            }
        }
    }
}
