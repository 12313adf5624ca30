//! Products of block matrices: the pattern once, the values of all or of some rows often.

use super::block::{BlockMatrix, BlockPattern, BlockRows, ROWS_PER_TASK, rows_of};
use super::kernel::{Entry, Sizes, add_product};
use crate::parallel;

/// Memory of one task: where each column of the current row is stored, and its blocks.
struct Workspace {
    slot_of: Vec<u32>,
    left: Vec<f64>,
    sum: Vec<f64>,
}

impl Workspace {
    fn new(columns: usize) -> Self {
        Self {
            slot_of: vec![u32::MAX; columns],
            left: Vec::new(),
            sum: Vec::new(),
        }
    }
}

/// Pattern of the product; `columns` is the number of block columns of `right`.
pub(in crate::preconditioner) fn product_pattern(
    left: &BlockPattern,
    right: &BlockPattern,
    columns: usize,
) -> BlockPattern {
    let row_of = |mark: &mut Vec<u32>, row: usize| -> Vec<u32> {
        let mut found = Vec::new();
        for middle in left.row(row) {
            for column in right.row(*middle as usize) {
                let mark = &mut mark[*column as usize];
                if *mark != row as u32 {
                    *mark = row as u32;
                    found.push(*column);
                }
            }
        }
        found.sort_unstable();
        found
    };
    let rows: Vec<Vec<u32>> = parallel::map_with(
        left.rows(),
        ROWS_PER_TASK,
        || vec![u32::MAX; columns],
        row_of,
    );
    BlockPattern::from_rows(rows.into_iter())
}

/// Computes the chosen rows of `product = left · right`, whose pattern stands already.
pub(in crate::preconditioner) fn multiply_rows<T: Entry, U: Entry>(
    left: &dyn BlockRows,
    right: &BlockMatrix<T>,
    product: &mut BlockMatrix<U>,
    columns: usize,
    chosen: impl Fn(usize) -> bool + Sync,
) {
    let (height, inner) = left.shape();
    let width = right.width;
    let sizes = Sizes {
        height,
        inner,
        width,
    };
    let kernel = product_row::<T>(sizes);
    let pattern = &product.pattern;
    let mut rows = rows_of(pattern, &mut product.values, height * width);
    let start = || Workspace::new(columns);
    parallel::each_with(&mut rows, ROWS_PER_TASK, start, |work, row, out| {
        if chosen(row) {
            kernel(left, right, pattern.row(row), sizes, work, row);
            for (out, sum) in out.iter_mut().zip(&work.sum) {
                *out = U::from_f64(*sum);
            }
        }
    });
}

/// Leaves one row of the product in `work.sum`: (left, right, columns, sizes, work, row).
type ProductRow<T> = fn(&dyn BlockRows, &BlockMatrix<T>, &[u32], Sizes, &mut Workspace, usize);

/// The loop for blocks of this size.
fn product_row<T: Entry>(sizes: Sizes) -> ProductRow<T> {
    match (sizes.height, sizes.inner, sizes.width) {
        (1, 1, 1) => multiply_row::<T, 1, 1, 1>,
        (1, 2, 1) => multiply_row::<T, 1, 2, 1>,
        (1, 3, 1) => multiply_row::<T, 1, 3, 1>,
        (2, 2, 3) => multiply_row::<T, 2, 2, 3>,
        (3, 2, 3) => multiply_row::<T, 3, 2, 3>,
        (3, 3, 3) => multiply_row::<T, 3, 3, 3>,
        (3, 3, 6) => multiply_row::<T, 3, 3, 6>,
        (6, 3, 6) => multiply_row::<T, 6, 3, 6>,
        (6, 6, 6) => multiply_row::<T, 6, 6, 6>,
        _ => multiply_row::<T, 0, 0, 0>,
    }
}

/// Sizes of 0 stand for those known at run time only.
fn multiply_row<T: Entry, const H: usize, const M: usize, const W: usize>(
    left: &dyn BlockRows,
    right: &BlockMatrix<T>,
    columns: &[u32],
    sizes: Sizes,
    work: &mut Workspace,
    row: usize,
) {
    let or = |known: usize, given: usize| if known > 0 { known } else { given };
    let sizes = Sizes {
        height: or(H, sizes.height),
        inner: or(M, sizes.inner),
        width: or(W, sizes.width),
    };
    let Sizes {
        height,
        inner,
        width,
    } = sizes;
    for (slot, column) in columns.iter().enumerate() {
        work.slot_of[*column as usize] = slot as u32;
    }
    work.sum.clear();
    work.sum.resize(columns.len() * height * width, 0.0);
    left.load(row, &mut work.left);
    let blocks = work.left.chunks_exact(height * inner);
    for (middle, block) in left.pattern().row(row).iter().zip(blocks) {
        let middle = *middle as usize;
        let others = right.row_values(middle).chunks_exact(inner * width);
        for (column, other) in right.pattern.row(middle).iter().zip(others) {
            let slot = work.slot_of[*column as usize] as usize;
            let sum = &mut work.sum[slot * height * width..][..height * width];
            add_product(sum, block, other, sizes);
        }
    }
}
