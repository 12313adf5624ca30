//! One V-cycle: smooth, correct from the coarser level, smooth.

use super::hierarchy::{Hierarchy, Level};

impl Hierarchy {
    /// Sets `out` to the result of one symmetric V-cycle for the right-hand side `r`.
    pub(super) fn cycle(&mut self, r: &[f64], out: &mut [f64]) {
        match self.levels.first_mut() {
            Some(level) => level.work.r.copy_from_slice(r),
            None => self.coarsest_x.copy_from_slice(r),
        }
        for index in 0..self.levels.len() {
            self.descend(index);
        }
        self.coarsest.solve(&mut self.coarsest_x);
        for index in (0..self.levels.len()).rev() {
            self.ascend(index);
        }
        let x = self
            .levels
            .first()
            .map_or(&self.coarsest_x, |level| &level.work.x);
        out.copy_from_slice(x);
    }

    fn descend(&mut self, index: usize) {
        let polynomial = self.polynomial;
        let (above, below) = self.levels.split_at_mut(index + 1);
        let Level {
            matrix,
            smoother,
            transfer,
            work,
        } = &mut above[index];
        work.x.fill(0.0);
        let memory = (&mut work.direction[..], &mut work.scaled[..]);
        smoother.smooth(matrix, polynomial, &mut work.r, &mut work.x, memory, true);
        let coarse = below
            .first_mut()
            .map_or(&mut self.coarsest_x, |level| &mut level.work.r);
        transfer.restrict(&work.r, coarse);
    }

    fn ascend(&mut self, index: usize) {
        let polynomial = self.polynomial;
        let (above, below) = self.levels.split_at_mut(index + 1);
        let coarse = below
            .first()
            .map_or(&self.coarsest_x, |level| &level.work.x);
        let Level {
            matrix,
            smoother,
            transfer,
            work,
        } = &mut above[index];
        transfer.correct(coarse, &mut work.x, &mut work.r);
        let memory = (&mut work.direction[..], &mut work.scaled[..]);
        smoother.smooth(matrix, polynomial, &mut work.r, &mut work.x, memory, false);
    }
}
