//! The regular lattice, optionally jittered.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{GenerateError, check_count, tensor_cells};
use crate::geometry::{Cloud, Domain, Vector};

/// Cell-centred lattice of `cells` cells per axis in the box from `origin` of the given `size`
/// (metres), x fastest.
///
/// # Errors
/// [`GenerateError::TooMany`].
pub fn lattice<const D: usize>(
    origin: Vector<D>,
    size: Vector<D>,
    cells: [usize; D],
) -> Result<Cloud<D>, GenerateError> {
    check_count(cells.iter().map(|&n| n as f64).product())?;
    let edges: [Vec<f64>; D] = std::array::from_fn(|axis| {
        let n = cells[axis];
        (0..=n)
            .map(|k| origin[axis] + size[axis] * k as f64 / n as f64)
            .collect()
    });
    let (position, _) = tensor_cells(&edges);
    // One exact cell size, so that equal points have equal operators to the last bit.
    let cell = Vector::<D>::from_fn(|axis, _| size[axis] / cells[axis] as f64);
    let count = position.len();
    Ok(Cloud {
        domain: Domain {
            lower: origin,
            upper: origin + size,
            planes: true,
        },
        position,
        volume: vec![cell.product(); count],
        cell: vec![cell; count],
        irregular: false,
        filled: true,
        outline: None,
    })
}

/// Moves every point by up to `amount` of its cell edge along each axis, reproducibly from `seed`.
///
/// Volumes stay, so the cloud becomes a mildly irregular one. `amount` below one half keeps points
/// inside their own cells.
pub fn jitter<const D: usize>(cloud: &mut Cloud<D>, amount: f64, seed: u64) {
    if amount <= 0.0 {
        return;
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for (x, cell) in cloud.position.iter_mut().zip(&cloud.cell) {
        for axis in 0..D {
            x[axis] += amount * cell[axis] * random.random_range(-1.0..1.0);
        }
    }
    cloud.irregular = true;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_centred_and_fill_the_box() {
        let cloud = lattice(
            Vector::<2>::new(-1.0, 0.0),
            Vector::<2>::new(2.0, 3.0),
            [4, 6],
        )
        .unwrap();
        assert_eq!(cloud.len(), 24);
        assert_eq!(cloud.position[0], Vector::<2>::new(-0.75, 0.25));
        assert_eq!(cloud.position[1], Vector::<2>::new(-0.25, 0.25));
        assert!((cloud.volume.iter().sum::<f64>() - 6.0).abs() < 1e-14);
    }

    #[test]
    fn jitter_repeats_for_a_seed_and_stays_inside_the_cells() {
        let base = lattice(Vector::<3>::zeros(), Vector::repeat(1.0), [5, 5, 5]).unwrap();
        let (mut a, mut b, mut c) = (base.clone(), base.clone(), base.clone());
        jitter(&mut a, 0.3, 7);
        jitter(&mut b, 0.3, 7);
        jitter(&mut c, 0.3, 8);
        assert_eq!(a, b);
        assert_ne!(a, c);
        for (moved, x) in a.position.iter().zip(&base.position) {
            assert!((moved - x).amax() <= 0.3 * 0.2);
        }
    }
}
