//! Approximations of the Schur complement C + B K⁻¹ Bᵀ.

use super::split::Blocks;
use crate::CsrMatrix;
use crate::matrix::Rows;
use crate::preconditioner::amg::block::{BlockMatrix, BlockPattern};
use crate::preconditioner::amg::dense::invert;
use crate::preconditioner::amg::product::{multiply_rows, product_pattern};

/// C + B D⁻¹ Bᵀ, D being the diagonal blocks of K.
pub(super) struct SelfComplement {
    /// −B by points.
    divergence: BlockMatrix<f64>,
    /// −D⁻¹ Bᵀ by points.
    gradient: BlockMatrix<f64>,
    product: BlockMatrix<f64>,
}

impl SelfComplement {
    pub(super) fn analyse(blocks: &Blocks) -> Self {
        let (divergence, points) = (blocks.divergence.view(), blocks.storage.rows());
        let inner = divergence.cols() / points.max(1);
        let rows = Rows::new(&divergence);
        let pattern = BlockPattern::from_rows((0..points).map(|point| {
            let mut columns: Vec<u32> = rows
                .row(point)
                .0
                .iter()
                .map(|column| column / inner as u32)
                .collect();
            columns.dedup();
            columns
        }));
        let (transposed, _) = pattern.transposed(points);
        let square = product_pattern(&pattern, &transposed, points);
        let square = union(&square, blocks.storage.view());
        Self {
            divergence: BlockMatrix::zeros(pattern, 1, inner),
            gradient: BlockMatrix::zeros(transposed, inner, 1),
            product: BlockMatrix::zeros(square, 1, 1),
        }
    }

    /// The matrix with the values of the blocks.
    pub(super) fn matrix(&mut self, blocks: &Blocks) -> CsrMatrix {
        self.fill_divergence(blocks);
        self.fill_gradient(blocks);
        let points = self.product.rows();
        multiply_rows(
            &self.divergence,
            &self.gradient,
            &mut self.product,
            points,
            |_| true,
        );
        let storage = blocks.storage.view();
        let rows = Rows::new(&storage);
        for point in 0..points {
            let (columns, values) = rows.row(point);
            for (column, value) in columns.iter().zip(values) {
                if let Some(position) = self.product.pattern.find(point, *column as usize) {
                    self.product.values[position] += value;
                }
            }
        }
        let pattern = &self.product.pattern;
        let starts = pattern.starts.iter().map(|start| *start as u32).collect();
        let values = self.product.values.clone();
        CsrMatrix::new((points, points), starts, pattern.columns.clone(), values)
    }

    fn fill_divergence(&mut self, blocks: &Blocks) {
        let view = blocks.divergence.view();
        let (rows, inner) = (Rows::new(&view), self.divergence.width);
        self.divergence.values.fill(0.0);
        for point in 0..self.divergence.rows() {
            let (columns, values) = rows.row(point);
            let mut position = self.divergence.pattern.starts[point];
            for (column, value) in columns.iter().zip(values) {
                let block = column / inner as u32;
                while self.divergence.pattern.columns[position] < block {
                    position += 1;
                }
                self.divergence.values[position * inner + *column as usize % inner] = *value;
            }
        }
    }

    /// Bᵀ is taken from B, which keeps the product symmetric.
    fn fill_gradient(&mut self, blocks: &Blocks) {
        let view = blocks.stiffness.view();
        let (rows, inner) = (Rows::new(&view), self.divergence.width);
        let mut gradient = self.divergence.transposed(self.divergence.rows());
        let mut block = vec![0.0; inner * inner];
        let mut inverse = block.clone();
        let mut scaled = vec![0.0; inner];
        for point in 0..gradient.rows() {
            for (entry, value) in block.iter_mut().enumerate() {
                *value = rows.get(point * inner + entry / inner, point * inner + entry % inner);
            }
            invert(&block, inner, &mut inverse);
            let range = gradient.pattern.range(point);
            for column in
                gradient.values[range.start * inner..range.end * inner].chunks_exact_mut(inner)
            {
                for (row, scaled) in scaled.iter_mut().enumerate() {
                    let terms = inverse[row * inner..].iter().zip(&*column);
                    *scaled = terms.map(|(a, b)| a * b).sum();
                }
                column.copy_from_slice(&scaled);
            }
        }
        self.gradient = gradient;
    }
}

/// C + diag(given).
pub(super) fn with_diagonal(storage: &CsrMatrix, given: &[f64]) -> CsrMatrix {
    let mut matrix = storage.clone();
    for (row, mut vector) in matrix.outer_iterator_mut().enumerate() {
        if let Some(diagonal) = vector.get_mut(row) {
            *diagonal += given[row];
        }
    }
    matrix
}

/// Blocks of both patterns and the diagonal.
fn union(a: &BlockPattern, b: crate::CsrView<'_>) -> BlockPattern {
    let rows = Rows::new(&b);
    BlockPattern::from_rows((0..a.rows()).map(|row| {
        let mut columns = [a.row(row), rows.row(row).0].concat();
        columns.push(row as u32);
        columns.sort_unstable();
        columns.dedup();
        columns
    }))
}
