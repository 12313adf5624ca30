//! Eigenvalues of small symmetric matrices by Jacobi's rotations, exact in a plane after one.

use crate::geometry::{Matrix, Vector};

/// Sweeps over all pairs; three dimensions need about six for all digits.
const SWEEPS: usize = 12;

/// Eigenvalues, and eigenvectors as columns.
pub(crate) fn eigen<const D: usize>(matrix: &Matrix<D>) -> (Vector<D>, Matrix<D>) {
    let (mut a, mut vectors) = (*matrix, Matrix::identity());
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..D {
            for q in p + 1..D {
                rotated |= rotate(&mut a, &mut vectors, p, q);
            }
        }
        if !rotated {
            break;
        }
    }
    (Vector::from_fn(|k, _| a[(k, k)]), vectors)
}

/// Makes entry (p, q) zero; false if it is that already, to rounding.
fn rotate<const D: usize>(a: &mut Matrix<D>, vectors: &mut Matrix<D>, p: usize, q: usize) -> bool {
    let (off, gap) = (a[(p, q)], a[(q, q)] - a[(p, p)]);
    let scale = a[(p, p)].abs() + a[(q, q)].abs();
    if off.abs() <= f64::EPSILON * 1e-2 * scale || off.abs() < f64::MIN_POSITIVE {
        return false;
    }
    let theta = 0.5 * gap / off;
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for k in 0..D {
        let (kp, kq) = (a[(k, p)], a[(k, q)]);
        (a[(k, p)], a[(k, q)]) = (c * kp - s * kq, s * kp + c * kq);
    }
    for k in 0..D {
        let (pk, qk) = (a[(p, k)], a[(q, k)]);
        (a[(p, k)], a[(q, k)]) = (c * pk - s * qk, s * pk + c * qk);
        let (kp, kq) = (vectors[(k, p)], vectors[(k, q)]);
        (vectors[(k, p)], vectors[(k, q)]) = (c * kp - s * kq, s * kp + c * kq);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// By hand: [[2, 1], [1, 2]] has the eigenvalues 1 and 3 along the diagonals.
    #[test]
    fn a_plane_matrix_by_hand() {
        let (values, vectors) = eigen(&Matrix::<2>::new(2.0, 1.0, 1.0, 2.0));
        assert!((values - Vector::<2>::new(1.0, 3.0)).amax() < 1e-15);
        assert!((vectors[(0, 1)].abs() - 0.5_f64.sqrt()).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn the_matrix_is_put_together_again(entries in prop::array::uniform6(-1e3..1e3_f64)) {
            let [a, b, c, d, e, f] = entries;
            let matrix = Matrix::<3>::new(a, d, e, d, b, f, e, f, c);
            let (values, vectors) = eigen(&matrix);
            let again = vectors * Matrix::from_diagonal(&values) * vectors.transpose();
            prop_assert!((again - matrix).amax() < 1e-11);
            prop_assert!((vectors.transpose() * vectors - Matrix::identity()).amax() < 1e-14);
        }
    }
}
