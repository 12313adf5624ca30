//! Inverses of small symmetric blocks and eigenvalues of small tridiagonal matrices.

/// Writes the inverse of a symmetric positive semidefinite block; directions without stiffness
/// get none.
pub(in crate::preconditioner) fn invert(block: &[f64], size: usize, inverse: &mut [f64]) {
    inverse.fill(0.0);
    let lower = cholesky(block, size);
    let mut column = vec![0.0; size];
    for unit in (0..size).filter(|unit| lower[unit * size + unit] > 0.0) {
        column.fill(0.0);
        column[unit] = 1.0;
        substitute(&lower, size, &mut column);
        for row in 0..size {
            inverse[row * size + unit] = column[row];
        }
    }
    // Rounding must not make the smoother unsymmetric.
    for row in 0..size {
        for column in 0..row {
            let (a, b) = (row * size + column, column * size + row);
            let mean = 0.5 * (inverse[a] + inverse[b]);
            (inverse[a], inverse[b]) = (mean, mean);
        }
    }
}

/// Lower factor; a pivot lost to rounding leaves a column and row of zeros.
fn cholesky(block: &[f64], size: usize) -> Vec<f64> {
    let mut lower = vec![0.0_f64; size * size];
    for column in 0..size {
        let known: f64 = (0..column).map(|k| lower[column * size + k].powi(2)).sum();
        let diagonal = block[column * size + column];
        let pivot = diagonal - known;
        if pivot <= 1e-14 * diagonal || pivot.is_nan() {
            lower[column * size..][..size].fill(0.0);
            continue;
        }
        lower[column * size + column] = pivot.sqrt();
        for row in column + 1..size {
            let product = |k: usize| lower[row * size + k] * lower[column * size + k];
            let known: f64 = (0..column).map(product).sum();
            lower[row * size + column] = (block[row * size + column] - known) / pivot.sqrt();
        }
    }
    lower
}

fn substitute(lower: &[f64], size: usize, x: &mut [f64]) {
    let pivot = |row: usize| lower[row * size + row];
    for row in 0..size {
        let known: f64 = (0..row).map(|k| lower[row * size + k] * x[k]).sum();
        x[row] = if pivot(row) > 0.0 {
            (x[row] - known) / pivot(row)
        } else {
            0.0
        };
    }
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size).map(|k| lower[k * size + row] * x[k]).sum();
        x[row] = if pivot(row) > 0.0 {
            (x[row] - known) / pivot(row)
        } else {
            0.0
        };
    }
}

/// Largest eigenvalue of a symmetric tridiagonal matrix by bisection with Sturm counts.
pub(in crate::preconditioner) fn largest_eigenvalue(diagonal: &[f64], beside: &[f64]) -> f64 {
    let radius = |row: usize| {
        let before = row.checked_sub(1).map_or(0.0, |row| beside[row].abs());
        let after = if row + 1 < diagonal.len() {
            beside[row].abs()
        } else {
            0.0
        };
        before + after
    };
    let ends =
        (0..diagonal.len()).map(|row| (diagonal[row] - radius(row), diagonal[row] + radius(row)));
    let (mut low, mut high) = ends.fold((f64::INFINITY, 0.0_f64), |(low, high), (a, b)| {
        (low.min(a), high.max(b))
    });
    while high - low > 1e-6 * high.abs() {
        let middle = 0.5 * (low + high);
        if all_below(diagonal, beside, middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Whether all eigenvalues are below `bound`: every pivot of T − bound is negative.
fn all_below(diagonal: &[f64], beside: &[f64], bound: f64) -> bool {
    let mut pivot = -1.0;
    for (row, diagonal) in diagonal.iter().enumerate() {
        let coupling = row.checked_sub(1).map_or(0.0, |row| beside[row].powi(2));
        pivot = diagonal - bound - coupling / pivot;
        if pivot >= 0.0 {
            return false;
        }
    }
    true
}
