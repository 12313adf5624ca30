//! L D Lᵀ factors without pivoting of many banded matrices at once: one for every wavenumber.
//!
//! Matrices that lie side by side are eliminated in step, so that every number is a vector of [`WIDE`].

/// Matrices that are eliminated in step: one cache line, two or four vector registers.
pub(super) const WIDE: usize = 8;

/// One number of [`WIDE`] matrices.
pub(super) type Numbers = [f64; WIDE];

/// [`WIDE`] banded matrices of one shape, or their factors. Entry `s` of a row is its `s`-th before the
/// diagonal; in factors entry 0 is the inverse of D.
pub(super) struct Bands {
    /// Entries before the diagonal.
    width: usize,
    /// Row after row, shape `(rows · (width + 1),)`.
    entries: Vec<Numbers>,
}

/// What becomes of a pivot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pivot {
    /// It is divided by.
    Good,
    /// Its unknown, the last one, is free and becomes 0.
    Free,
    /// The matrix cannot be factored.
    Bad,
}

/// A pivot that cannot be divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BadPivot {
    /// Its row.
    pub(super) row: usize,
    /// Which of the matrices.
    pub(super) lane: usize,
}

impl Bands {
    /// Matrices of zeros.
    pub(super) fn zeros(rows: usize, width: usize) -> Self {
        Bands {
            width,
            entries: vec![[0.0; WIDE]; rows * (width + 1)],
        }
    }

    /// Entries of a row, the diagonal first.
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [Numbers] {
        &mut self.entries[row * (self.width + 1)..][..self.width + 1]
    }

    /// Makes a row of the matrices that of another.
    pub(super) fn copy_row(&mut self, from: usize, to: usize) {
        let stride = self.width + 1;
        let entries = from * stride..(from + 1) * stride;
        self.entries.copy_within(entries, to * stride);
    }

    fn rows(&self) -> usize {
        self.entries.len() / (self.width + 1)
    }

    /// Replaces the matrices by their factors. `judge` is told the row and the lane of every pivot and its
    /// ratio to the diagonal entry; the first bad one is returned, and the factors are of no use then.
    pub(super) fn factorise(
        &mut self,
        judge: impl Fn(usize, usize, f64) -> Pivot,
    ) -> Option<BadPivot> {
        let width = self.width;
        let stride = width + 1;
        let mut fault = None;
        for row in 0..self.rows() {
            let (above, rest) = self.entries.split_at_mut(row * stride);
            let own = &mut rest[..stride];
            let diagonal = own[0];
            let mut pivot = diagonal;
            // Entries of columns row − s, the farthest first; own[s] holds L D until its turn.
            for s in (1..=width.min(row)).rev() {
                let column = row - s;
                let other = &above[column * stride..][..stride];
                let mut value = own[s];
                for t in 1..stride - s {
                    for lane in 0..WIDE {
                        value[lane] -= own[s + t][lane] * other[t][lane];
                    }
                }
                own[s] = value;
            }
            for s in 1..=width.min(row) {
                let inverse = above[(row - s) * stride];
                for lane in 0..WIDE {
                    let scaled = own[s][lane] * inverse[lane];
                    pivot[lane] -= own[s][lane] * scaled;
                    own[s][lane] = scaled;
                }
            }
            for lane in 0..WIDE {
                let ratio = pivot[lane] / diagonal[lane];
                let verdict = judge(row, lane, ratio);
                own[0][lane] = match verdict {
                    Pivot::Good => 1.0 / pivot[lane],
                    Pivot::Free | Pivot::Bad => 0.0,
                };
                if verdict == Pivot::Bad && fault.is_none() {
                    fault = Some(BadPivot { row, lane });
                }
            }
        }
        fault
    }

    /// Overwrites right-hand sides by solutions, shape `(rows,)`.
    pub(super) fn solve(&self, x: &mut [Numbers]) {
        let stride = self.width + 1;
        for row in 0..x.len() {
            let own = &self.entries[row * stride..][..stride];
            let mut value = x[row];
            for s in 1..=self.width.min(row) {
                for lane in 0..WIDE {
                    value[lane] -= own[s][lane] * x[row - s][lane];
                }
            }
            x[row] = value;
        }
        for row in (0..x.len()).rev() {
            let inverse = self.entries[row * stride];
            let mut value = x[row];
            for lane in 0..WIDE {
                value[lane] *= inverse[lane];
            }
            for s in 1..=self.width.min(x.len() - 1 - row) {
                let below = self.entries[(row + s) * stride + s];
                for lane in 0..WIDE {
                    value[lane] -= below[lane] * x[row + s][lane];
                }
            }
            x[row] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::noise;

    /// Eight different matrices against products with the matrices themselves.
    #[test]
    fn factors_solve_what_the_matrices_multiply() {
        let (rows, width) = (13, 4);
        let entry = |row: usize, s: usize, lane: usize| match s {
            0 => 10.0 * if row.is_multiple_of(3) { -1.0 } else { 1.0 },
            _ => noise(1000 * lane + 10 * row + s),
        };
        let mut bands = Bands::zeros(rows, width);
        for row in 0..rows {
            for s in 0..=width.min(row) {
                bands.row_mut(row)[s] = std::array::from_fn(|lane| entry(row, s, lane));
            }
        }
        let at = |row: usize, column: usize, lane: usize| {
            let (low, high) = (row.min(column), row.max(column));
            if high - low > width {
                0.0
            } else {
                entry(high, high - low, lane)
            }
        };
        let exact = |row: usize, lane: usize| noise(77 * row + lane);
        let mut x: Vec<Numbers> = (0..rows)
            .map(|row| {
                std::array::from_fn(|lane| {
                    (0..rows).map(|c| at(row, c, lane) * exact(c, lane)).sum()
                })
            })
            .collect();
        assert_eq!(bands.factorise(|_, _, _| Pivot::Good), None);
        bands.solve(&mut x);
        for (row, x) in x.iter().enumerate() {
            for (lane, x) in x.iter().enumerate() {
                assert!((x - exact(row, lane)).abs() < 1e-13);
            }
        }
    }

    /// Springs in a row without a support: the last pivot is zero.
    #[test]
    fn a_free_unknown_is_held_at_zero() {
        let mut bands = Bands::zeros(3, 1);
        for (row, diagonal) in [1.0, 2.0, 1.0].into_iter().enumerate() {
            bands.row_mut(row)[0] = [diagonal; WIDE];
            bands.row_mut(row)[1] = [if row == 0 { 0.0 } else { -1.0 }; WIDE];
        }
        let bad = bands.factorise(|row, _, ratio| match (row, ratio > 0.0) {
            (2, false) => Pivot::Free,
            (_, true) => Pivot::Good,
            _ => Pivot::Bad,
        });
        assert_eq!(bad, None);
        let mut x = vec![[1.0; WIDE], [0.0; WIDE], [-1.0; WIDE]];
        bands.solve(&mut x);
        for (x, expected) in x.iter().zip([2.0, 1.0, 0.0]) {
            assert!((x[0] - expected).abs() < 1e-15);
        }
    }
}
