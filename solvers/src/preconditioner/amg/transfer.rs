//! From one level to the next: smoothed prolongation and Galerkin product.

use super::block::{BlockMatrix, BlockRows, ROWS_PER_TASK, Update, rows_of};
use super::product::{multiply_rows, product_pattern};
use super::smoother::Smoother;
use super::tentative::Tentative;
use crate::parallel;

/// Damping of the Jacobi step that smooths the prolongation, in units of 1 / λ_max.
const DAMPING: f64 = 4.0 / 3.0;

/// Prolongation P, restriction Pᵀ and coarse matrix Pᵀ A P between two levels.
pub(super) struct Transfer {
    pub(super) prolongation: BlockMatrix<f32>,
    restriction: BlockMatrix<f32>,
    /// A P: the residual after a coarse correction costs no product with A.
    product: BlockMatrix<f64>,
    pub(super) coarse: BlockMatrix<f64>,
    /// Coarse unknowns without a basis function.
    missing: Vec<usize>,
}

impl Transfer {
    /// Chooses the prolongation (1 − ω D⁻¹ A) T and computes the coarse matrix.
    pub(super) fn new(source: &dyn BlockRows, tentative: &Tentative, smoother: &Smoother) -> Self {
        let (size, _) = source.shape();
        let count = tentative.matrix.width;
        let coarse_rows = tentative.coarse.values.len() / (count * count);
        let prolongation = smoothed(source, &tentative.matrix, smoother, coarse_rows);
        let restriction = prolongation.transposed(coarse_rows);
        let pattern = product_pattern(source.pattern(), &prolongation.pattern, coarse_rows);
        let product = BlockMatrix::zeros(pattern, size, count);
        let pattern = product_pattern(&restriction.pattern, &product.pattern, coarse_rows);
        let coarse = BlockMatrix::zeros(pattern, count, count);
        let mut transfer = Self {
            prolongation,
            restriction,
            product,
            coarse,
            missing: tentative.missing.clone(),
        };
        transfer.refresh(source, None);
        transfer
    }

    /// Recomputes the coarse matrix where the chosen rows of the fine one reach it; all of it
    /// without a choice.
    pub(super) fn refresh(&mut self, source: &dyn BlockRows, changed: Option<&[bool]>) {
        let columns = self.coarse.rows();
        let is_changed = |row: usize| changed.is_none_or(|changed| changed[row]);
        multiply_rows(
            source,
            &self.prolongation,
            &mut self.product,
            columns,
            is_changed,
        );
        let reached = |row: usize| {
            let members = self.restriction.pattern.row(row);
            changed.is_none_or(|changed| members.iter().any(|point| changed[*point as usize]))
        };
        let reached: Vec<bool> = parallel::map(columns, reached);
        let (left, right) = (&self.restriction, &self.product);
        multiply_rows(left, right, &mut self.coarse, columns, |row| reached[row]);
        symmetrise(&mut self.coarse, &reached);
        self.fill_missing();
    }

    /// A coarse unknown without a basis function has a row of zeros; a diagonal entry keeps the
    /// matrix definite, and since nothing is restricted to it, it stays zero.
    fn fill_missing(&mut self) {
        let size = self.coarse.height;
        for unknown in &self.missing {
            let (row, local) = (unknown / size, unknown % size);
            let Some(position) = self.coarse.pattern.find(row, row) else {
                continue;
            };
            let block = &mut self.coarse.values[position * size * size..][..size * size];
            let largest = block
                .iter()
                .fold(0.0_f64, |largest, value| largest.max(value.abs()));
            block[local * size + local] = if largest > 0.0 { largest } else { 1.0 };
        }
    }

    /// Sets the coarse right-hand side to Pᵀ r.
    pub(super) fn restrict(&self, r: &[f64], coarse: &mut [f64]) {
        self.restriction.apply(r, coarse, Update::Set);
    }

    /// Adds P e to x and subtracts A P e from r.
    pub(super) fn correct(&self, e: &[f64], x: &mut [f64], r: &mut [f64]) {
        self.prolongation.apply(e, x, Update::Add);
        self.product.apply(e, r, Update::Subtract);
    }

    pub(super) fn bytes(&self) -> usize {
        self.prolongation.bytes()
            + self.restriction.bytes()
            + self.product.bytes()
            + self.coarse.bytes()
    }
}

/// (1 − ω D⁻¹ A) T.
fn smoothed(
    source: &dyn BlockRows,
    tentative: &BlockMatrix<f64>,
    smoother: &Smoother,
    columns: usize,
) -> BlockMatrix<f32> {
    let (height, width) = (tentative.height, tentative.width);
    let pattern = product_pattern(source.pattern(), &tentative.pattern, columns);
    let mut product = BlockMatrix::<f64>::zeros(pattern, height, width);
    multiply_rows(source, tentative, &mut product, columns, |_| true);
    let mut prolongation = BlockMatrix::<f32>::zeros(product.pattern.clone(), height, width);
    let area = height * width;
    let mut rows = rows_of(&product.pattern, &mut prolongation.values, area);
    parallel::each(&mut rows, ROWS_PER_TASK, |row, out| {
        let blocks = product.row_values(row).chunks_exact(area);
        let blocks = blocks.zip(out.chunks_exact_mut(area));
        for (column, (block, out)) in product.pattern.row(row).iter().zip(blocks) {
            let own = tentative.pattern.row(row).first() == Some(column);
            let start = if own { tentative.row_values(row) } else { &[] };
            smooth_block(start, block, smoother, row, out);
        }
    });
    prolongation
}

/// T − ω D⁻¹ (A T) in one block; `start` is empty where T is zero.
fn smooth_block(start: &[f64], block: &[f64], smoother: &Smoother, row: usize, out: &mut [f32]) {
    let inverse = smoother.inverse_block(row);
    let height = inverse.len().isqrt();
    let width = block.len() / height;
    let omega = DAMPING / smoother.bound;
    for (entry, out) in out.iter_mut().enumerate() {
        let (i, j) = (entry / width, entry % width);
        let scaled: f64 = (0..height)
            .map(|k| inverse[i * height + k] * block[k * width + j])
            .sum();
        *out = (start.get(entry).copied().unwrap_or(0.0) - omega * scaled) as f32;
    }
}

/// Copies the upper blocks of the chosen rows and columns to the lower ones: rounding would
/// otherwise differ, and the preconditioner must be symmetric.
fn symmetrise(matrix: &mut BlockMatrix<f64>, chosen: &[bool]) {
    let (size, area) = (matrix.height, matrix.area());
    for row in (0..matrix.rows()).filter(|row| chosen[*row]) {
        for position in matrix.pattern.range(row) {
            let column = matrix.pattern.columns[position] as usize;
            if column > row {
                break;
            }
            let Some(other) = matrix.pattern.find(column, row) else {
                continue;
            };
            for entry in 0..area {
                let (i, j) = (entry / size, entry % size);
                if column < row || j < i {
                    matrix.values[position * area + entry] =
                        matrix.values[other * area + j * size + i];
                }
            }
        }
    }
}
