//! Inner loops over small dense blocks, with the sizes that occur known at compile time.
//!
//! The hierarchy is stored in single precision, which halves its memory and the time of a cycle;
//! every sum is done in double precision.

/// Number type of stored entries.
pub(in crate::preconditioner) trait Entry:
    Copy + Send + Sync + PartialEq + 'static
{
    fn from_f64(value: f64) -> Self;
    fn to_f64(self) -> f64;
}

impl Entry for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }

    fn to_f64(self) -> f64 {
        self
    }
}

impl Entry for f32 {
    fn from_f64(value: f64) -> Self {
        value as Self
    }

    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

/// Adds `sign` times the product of a block row and a vector: (columns, blocks, x, sign, out).
pub(in crate::preconditioner) type RowKernel<T> = fn(&[u32], &[T], &[f64], f64, &mut [f64]);

/// The loop for blocks of this size.
pub(in crate::preconditioner) fn row_kernel<T: Entry>(height: usize, width: usize) -> RowKernel<T> {
    match (height, width) {
        (1, 1) => scalar_row,
        (2, 2) => block_row::<T, 2, 2>,
        (3, 3) => block_row::<T, 3, 3>,
        (6, 6) => block_row::<T, 6, 6>,
        (2, 3) => block_row::<T, 2, 3>,
        (3, 2) => block_row::<T, 3, 2>,
        (3, 6) => block_row::<T, 3, 6>,
        (6, 3) => block_row::<T, 6, 3>,
        _ => any_row,
    }
}

fn scalar_row<T: Entry>(columns: &[u32], values: &[T], x: &[f64], sign: f64, out: &mut [f64]) {
    // Four independent sums keep the floating-point units busy.
    let mut sums = [0.0; 4];
    let (column_blocks, value_blocks) = (columns.chunks_exact(4), values.chunks_exact(4));
    let tail = column_blocks
        .remainder()
        .iter()
        .zip(value_blocks.remainder());
    for (columns, values) in column_blocks.zip(value_blocks) {
        for lane in 0..4 {
            sums[lane] += values[lane].to_f64() * x[columns[lane] as usize];
        }
    }
    for (column, value) in tail {
        sums[0] += value.to_f64() * x[*column as usize];
    }
    out[0] += sign * ((sums[0] + sums[1]) + (sums[2] + sums[3]));
}

fn block_row<T: Entry, const H: usize, const W: usize>(
    columns: &[u32],
    values: &[T],
    x: &[f64],
    sign: f64,
    out: &mut [f64],
) {
    let mut sums = [[0.0; W]; H];
    for (column, block) in columns.iter().zip(values.chunks_exact(H * W)) {
        let x = &x[*column as usize * W..][..W];
        for row in 0..H {
            for lane in 0..W {
                sums[row][lane] += block[row * W + lane].to_f64() * x[lane];
            }
        }
    }
    for (out, sums) in out.iter_mut().zip(sums) {
        *out += sign * sums.iter().sum::<f64>();
    }
}

fn any_row<T: Entry>(columns: &[u32], values: &[T], x: &[f64], sign: f64, out: &mut [f64]) {
    let height = out.len();
    let Some(area) = values.len().checked_div(columns.len()) else {
        return;
    };
    let width = area / height;
    for (column, block) in columns.iter().zip(values.chunks_exact(area)) {
        let x = &x[*column as usize * width..][..width];
        for (out, row) in out.iter_mut().zip(block.chunks_exact(width)) {
            let sum: f64 = row.iter().zip(x).map(|(value, x)| value.to_f64() * x).sum();
            *out += sign * sum;
        }
    }
}

/// Sizes of a product of blocks: (height × inner) · (inner × width).
#[derive(Debug, Clone, Copy)]
pub(in crate::preconditioner) struct Sizes {
    pub(in crate::preconditioner) height: usize,
    pub(in crate::preconditioner) inner: usize,
    pub(in crate::preconditioner) width: usize,
}

/// Adds the product of two blocks to a third.
#[inline(always)]
pub(in crate::preconditioner) fn add_product<T: Entry>(
    sum: &mut [f64],
    left: &[f64],
    right: &[T],
    sizes: Sizes,
) {
    let Sizes {
        height,
        inner,
        width,
    } = sizes;
    for row in 0..height {
        for middle in 0..inner {
            let factor = left[row * inner + middle];
            for column in 0..width {
                sum[row * width + column] += factor * right[middle * width + column].to_f64();
            }
        }
    }
}
