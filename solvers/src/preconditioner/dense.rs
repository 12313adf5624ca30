//! Inverses of the small dense blocks of points, by rows.

/// Sweeps of Jacobi rotations; blocks of a few rows need three or four.
const SWEEPS: usize = 12;
/// Part of the largest eigenvalue or pivot below which it is raised to that part.
const SMALLEST: f64 = 1e-12;

/// Sets `inverse` to Σ v vᵀ / |λ| over the eigenpairs of a symmetric block (Jacobi's method;
/// Golub & Van Loan, Matrix Computations, 8.5). The block is overwritten.
pub(super) fn invert_absolute(block: &mut [f64], size: usize, inverse: &mut [f64]) {
    let vectors = inverse;
    vectors.fill(0.0);
    (0..size).for_each(|i| vectors[i * size + i] = 1.0);
    for _ in 0..SWEEPS {
        let mut off = 0.0_f64;
        for p in 0..size {
            for q in p + 1..size {
                off = off.max(block[p * size + q].abs());
                rotate(block, vectors, size, p, q);
            }
        }
        if off <= f64::EPSILON * f64::EPSILON {
            break;
        }
    }
    let sizes = |i: usize| block[i * size + i].abs();
    let floor = SMALLEST * (0..size).map(sizes).fold(f64::MIN_POSITIVE, f64::max);
    let inverses: Vec<f64> = (0..size).map(|i| 1.0 / sizes(i).max(floor)).collect();
    for i in 0..size {
        for j in 0..size {
            let terms =
                (0..size).map(|k| vectors[i * size + k] * vectors[j * size + k] * inverses[k]);
            block[i * size + j] = terms.sum();
        }
    }
    vectors.copy_from_slice(block);
}

/// Removes the entries (p, q) and (q, p) by a rotation.
fn rotate(block: &mut [f64], vectors: &mut [f64], size: usize, p: usize, q: usize) {
    let off = block[p * size + q];
    if off.abs() <= 0.0 {
        return;
    }
    let theta = (block[q * size + q] - block[p * size + p]) / (2.0 * off);
    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    let turn = |array: &mut [f64], first: usize, second: usize| {
        let (a, b) = (array[first], array[second]);
        array[first] = cosine * a - sine * b;
        array[second] = sine * a + cosine * b;
    };
    for k in 0..size {
        turn(block, k * size + p, k * size + q);
        turn(vectors, k * size + p, k * size + q);
    }
    for k in 0..size {
        turn(block, p * size + k, q * size + k);
    }
}

/// Sets `inverse` to that of a block, by elimination with row pivoting; a vanishing pivot is raised.
/// The block is overwritten.
pub(super) fn invert(block: &mut [f64], size: usize, inverse: &mut [f64]) {
    inverse.fill(0.0);
    (0..size).for_each(|i| inverse[i * size + i] = 1.0);
    let largest = block
        .iter()
        .fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
    for k in 0..size {
        let rank = |i: &usize, j: &usize| {
            let (a, b) = (block[i * size + k].abs(), block[j * size + k].abs());
            a.total_cmp(&b).then(j.cmp(i))
        };
        let pivot_row = (k..size).max_by(rank).unwrap_or(k);
        for j in 0..size {
            block.swap(k * size + j, pivot_row * size + j);
            inverse.swap(k * size + j, pivot_row * size + j);
        }
        let found = block[k * size + k];
        let pivot = found.abs().max(SMALLEST * largest).copysign(found);
        for j in 0..size {
            block[k * size + j] /= pivot;
            inverse[k * size + j] /= pivot;
        }
        for i in (0..size).filter(|i| *i != k) {
            let factor = block[i * size + k];
            for j in 0..size {
                block[i * size + j] -= factor * block[k * size + j];
                inverse[i * size + j] -= factor * inverse[k * size + j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::noise;

    fn product(a: &[f64], b: &[f64], size: usize) -> Vec<f64> {
        let entry = |index: usize| {
            let (i, j) = (index / size, index % size);
            (0..size).map(|k| a[i * size + k] * b[k * size + j]).sum()
        };
        (0..size * size).map(entry).collect()
    }

    fn distance_to_identity(a: &[f64], size: usize) -> f64 {
        let distance = |(index, value): (usize, &f64)| {
            let one = if index / size == index % size {
                1.0
            } else {
                0.0
            };
            (value - one).abs()
        };
        a.iter().enumerate().map(distance).fold(0.0, f64::max)
    }

    fn condition(a: &[f64], inverse: &[f64]) -> f64 {
        10.0 * crate::norm2(a) * crate::norm2(inverse)
    }

    #[test]
    fn inverses_of_unsymmetric_blocks_are_inverses() {
        for size in 1..7 {
            let entry = |i: usize| noise(37 * i * i + 50 * size);
            let block: Vec<f64> = (0..size * size).map(entry).collect();
            let mut inverse = vec![0.0; size * size];
            invert(&mut block.clone(), size, &mut inverse);
            let error = distance_to_identity(&product(&block, &inverse, size), size);
            assert!(
                error < 1e-15 * condition(&block, &inverse),
                "{size} {error}"
            );
        }
    }

    #[test]
    fn the_absolute_inverse_squares_to_the_inverse_of_the_square() {
        for size in 1..7 {
            let block: Vec<f64> = (0..size * size)
                .map(|index| {
                    let (i, j) = (index / size, index % size);
                    noise(37 * usize::pow(i.min(j) * size + i.max(j), 2))
                })
                .collect();
            let mut inverse = vec![0.0; size * size];
            invert_absolute(&mut block.clone(), size, &mut inverse);
            let square = product(&block, &block, size);
            let inverse_square = product(&inverse, &inverse, size);
            let error = distance_to_identity(&product(&square, &inverse_square, size), size);
            assert!(
                error < 1e-14 * condition(&square, &inverse_square),
                "{size} {error}"
            );
            for i in 0..size {
                let diagonal = inverse[i * size + i];
                assert!(diagonal > 0.0);
            }
        }
    }

    #[test]
    fn the_eigenvalues_of_a_saddle_lose_their_sign() {
        // (1, 0; 0, −4) turned by 45 degrees.
        let mut block = [-1.5, 2.5, 2.5, -1.5];
        let mut inverse = [0.0; 4];
        invert_absolute(&mut block, 2, &mut inverse);
        let exact = [0.625, 0.375, 0.375, 0.625];
        let distance = inverse.iter().zip(exact).map(|(a, b)| (a - b).abs());
        assert!(distance.fold(0.0, f64::max) < 1e-14, "{inverse:?}");
    }
}
