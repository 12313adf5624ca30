//! What the incomplete factorisations share: the pattern left of the diagonal, and the search for a
//! shift of the diagonal.

use std::ops::Range;

use crate::CsrView;
use crate::matrix::Rows;

/// First shift, and the factor from one to the next; the last is about 1.
const FIRST_SHIFT: f64 = 1e-3;
const SHIFT_FACTOR: f64 = 4.0;
const LARGEST_SHIFT: f64 = 1.1;

/// Columns left of the diagonal, row after row.
#[derive(Default)]
pub(super) struct LowerPattern {
    starts: Vec<u32>,
    pub(super) columns: Vec<u32>,
}

impl LowerPattern {
    pub(super) fn new(pattern: CsrView<'_>) -> Self {
        let rows = Rows::new(&pattern);
        let (mut starts, mut columns) = (vec![0], Vec::new());
        for row in 0..pattern.rows() {
            let left = rows
                .row(row)
                .0
                .iter()
                .filter(|column| (**column as usize) < row);
            columns.extend(left);
            starts.push(columns.len() as u32);
        }
        Self { starts, columns }
    }

    /// Positions of the entries of a row.
    pub(super) fn range(&self, row: usize) -> Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    pub(super) fn bytes(&self) -> u64 {
        4 * (self.starts.len() + self.columns.len()) as u64
    }
}

/// The shift that served last.
#[derive(Clone, Copy, Default)]
pub(super) struct Shifts {
    last: f64,
}

impl Shifts {
    /// Tries growing shifts until `attempt` succeeds. Fails with the row and shift of the last try.
    pub(super) fn search(
        &mut self,
        mut attempt: impl FnMut(f64) -> Result<(), usize>,
    ) -> Result<(), (usize, f64)> {
        let less = self.last / SHIFT_FACTOR;
        let mut shift = if less < FIRST_SHIFT { 0.0 } else { less };
        loop {
            let Err(row) = attempt(shift) else {
                self.last = shift;
                return Ok(());
            };
            let next = (shift * SHIFT_FACTOR).max(FIRST_SHIFT);
            if next > LARGEST_SHIFT {
                self.last = 0.0;
                return Err((row, shift));
            }
            shift = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_grow_until_one_serves_and_the_next_search_begins_below_it() {
        let mut shifts = Shifts::default();
        let mut tried = Vec::new();
        let mut attempt = |enough: f64, shifts: &mut Shifts| {
            tried.clear();
            let found = shifts.search(|shift| {
                tried.push(shift);
                if shift >= enough { Ok(()) } else { Err(7) }
            });
            (found, tried.len())
        };
        assert_eq!(attempt(0.0, &mut shifts), (Ok(()), 1));
        assert_eq!(attempt(0.01, &mut shifts), (Ok(()), 4));
        assert_eq!(attempt(0.01, &mut shifts), (Ok(()), 2));
        let (failed, tries) = attempt(9.0, &mut shifts);
        assert!(matches!(failed, Err((7, shift)) if shift > 0.9) && tries < 8);
    }
}
