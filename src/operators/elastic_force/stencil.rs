//! The bonds of a point on a lattice in pairs of opposite ones, and sums over them in blocks of points.
//!
//! Values of a few neighbouring points are summed side by side, which the processor does at once. Every value has its
//! sum in the order of the pairs, so that bits depend neither on the block nor on the width of the processor.
//! Loops are over arrays of known length, or they would check bounds and stay scalar.
#![allow(
    clippy::needless_range_loop,
    reason = "kernels over several arrays at once"
)]

/// A bond and the opposite one.
#[derive(Debug, Clone)]
pub(super) struct Pair<const D: usize> {
    /// Step on the lattice to the end of the bond, in values of a field of displacements.
    pub shift: usize,
    /// The same in values of a field of stresses.
    pub stress: usize,
    /// ω V of the bond.
    pub measure: f64,
    /// ω V ξ.
    pub arm: [f64; D],
}

/// Values of a block of points, one after the other.
pub(super) type Block<const LANES: usize> = [f64; LANES];

/// The values ahead of and behind a block by a shift.
#[inline(always)]
fn ends<const LANES: usize>(
    field: &[f64],
    at: usize,
    shift: usize,
) -> (Block<LANES>, Block<LANES>) {
    let part = |from: usize| field[from..].first_chunk().copied().unwrap_or([0.0; LANES]);
    (part(at + shift), part(at - shift))
}

/// Σ (u₊ − u₋) arm by axes and Σ ω V (u₊ + u₋) for the values from `at` on.
#[inline(always)]
pub(super) fn gather<const D: usize, const LANES: usize>(
    pairs: &[Pair<D>],
    field: &[f64],
    at: usize,
) -> ([Block<LANES>; D], Block<LANES>) {
    let (mut slopes, mut sum) = ([[0.0; LANES]; D], [0.0; LANES]);
    for pair in pairs {
        let (ahead, behind) = ends::<LANES>(field, at, pair.shift);
        let mut difference = [0.0; LANES];
        for k in 0..LANES {
            difference[k] = ahead[k] - behind[k];
            sum[k] += pair.measure * (ahead[k] + behind[k]);
        }
        for axis in 0..D {
            let arm = pair.arm[axis];
            for k in 0..LANES {
                slopes[axis][k] += difference[k] * arm;
            }
        }
    }
    (slopes, sum)
}

/// Σ ω V (u₊ + u₋).
#[inline(always)]
pub(super) fn add_up<const D: usize, const LANES: usize>(
    pairs: &[Pair<D>],
    field: &[f64],
    at: usize,
) -> Block<LANES> {
    let mut sum = [0.0; LANES];
    for pair in pairs {
        let (ahead, behind) = ends::<LANES>(field, at, pair.shift);
        for k in 0..LANES {
            sum[k] += pair.measure * (ahead[k] + behind[k]);
        }
    }
    sum
}

/// Σ (T₋ − T₊) arm; columns of T are `column` values apart.
#[inline(always)]
pub(super) fn spread<const D: usize, const LANES: usize>(
    pairs: &[Pair<D>],
    stress: &[f64],
    (at, column): (usize, usize),
) -> Block<LANES> {
    let mut sum = [0.0; LANES];
    for pair in pairs {
        let mut traction = [0.0; LANES];
        for axis in 0..D {
            let (ahead, behind) = ends::<LANES>(stress, at + axis * column, pair.stress);
            let arm = pair.arm[axis];
            for k in 0..LANES {
                traction[k] += (behind[k] - ahead[k]) * arm;
            }
        }
        for k in 0..LANES {
            sum[k] += traction[k];
        }
    }
    sum
}

/// A small matrix by rows.
pub(super) type Rows<const D: usize> = [[f64; D]; D];

/// The product of small matrices, written out: elsewhere it is a call.
#[inline(always)]
pub(super) fn product<const D: usize>(left: &Rows<D>, right: &Rows<D>) -> Rows<D> {
    let mut result = [[0.0; D]; D];
    for a in 0..D {
        for b in 0..D {
            for c in 0..D {
                result[a][c] += left[a][b] * right[b][c];
            }
        }
    }
    result
}
