//! Backend `fourier`: transforms along all axes of a lattice but one, banded factors along that one.
//!
//! Where the rows of a matrix repeat along an axis up to sides that mirror, sines and cosines along it are
//! eigenvectors: every wavenumber stands for itself. Along one last axis nothing needs to repeat, so that
//! layers, clamped and free sides are exact too: each wavenumber leaves one banded system.
//!
//! The stencil is read from the matrix itself, row by row along one line, and never looked at again
//! elsewhere: whether it is that of all lines the true residual tells, as for every solver.

mod bands;
mod layout;
mod stencil;
mod symbol;
mod transform;

use crate::direct::{Direct, Factor};
use crate::matrix::{Rows, multiply};
use crate::parallel;
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, Options};
use crate::{CsrView, LinearSolver, SolveError, SpecError};

use self::bands::{BadPivot, Bands, Numbers, Pivot, WIDE};
use self::layout::Layout;
use self::stencil::{Reach, Stencil, edge};
use self::symbol::Symbols;

const NAME: &str = "fourier";

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "sine and cosine transforms on lattices whose rows repeat along all axes but one (direct)",
    symmetries: &[Symmetry::PositiveDefinite, Symmetry::QuasiDefinite],
    distributed: false,
    lattices_only: true,
    options: &[],
    build,
};

fn build(_options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    let symbolic = |problem: &Problem<'_>| -> Result<Box<dyn Factor>, SolveError> {
        Ok(Box::new(Transformed::analyse(problem)?))
    };
    Ok(Box::new(Direct::new(&BACKEND, Box::new(symbolic))))
}

/// Sum of a row over its diagonal entry that is rounding error: 200 entries leave 4e-14 at most.
const ROUNDING: f64 = 1e-13;
/// Pivot over diagonal entry below which nothing is left of it. Contrasts of 1e12 leave 1e-12, and a storage that
/// is too small for row sums to show still leaves as many times more as a line has points.
const LOST: f64 = 1e-15;
/// Difference of an entry, relative to the largest of its row, that is none. Positions and what follows from
/// them are rounded to 1e-13 at 1000 points across.
const SAME: f64 = 1e-10;

/// A matrix in terms of wavenumbers, factored.
struct Transformed {
    symmetry: Symmetry,
    layout: Layout,
    reach: Reach,
    stencil: Option<Stencil>,
    /// Factors, [`WIDE`] lanes in each.
    factors: Vec<Bands>,
    /// The point that holds a constant which nothing else does, and what it adds to its diagonal.
    ground: Option<(usize, f64)>,
    /// Values by rows of a line, then lanes.
    waves: Vec<f64>,
    /// The same by groups of lanes, then rows.
    groups: Vec<Numbers>,
}

impl Transformed {
    fn analyse(problem: &Problem<'_>) -> Result<Self, SolveError> {
        let layout = Layout::of(problem)?;
        let groups = layout.lanes().div_ceil(WIDE);
        Ok(Transformed {
            symmetry: problem.symmetry,
            reach: Reach::of(&layout, problem.pattern),
            stencil: None,
            factors: Vec::new(),
            ground: None,
            waves: vec![0.0; layout.rows() * layout.lanes()],
            groups: vec![[0.0; WIDE]; layout.rows() * groups],
            layout,
        })
    }

    /// Entries of a row before its diagonal.
    fn width(&self) -> usize {
        let width = (self.reach.along + 1) * self.layout.unknowns - 1;
        width.min(self.layout.rows() - 1)
    }

    /// A row of the matrix in a group of lanes.
    fn matrix_row(&self, group: usize, lane: usize, row: usize) -> usize {
        let (layout, unknown) = (&self.layout, row % self.layout.unknowns);
        let lane = group * WIDE + lane;
        let slots = [lane % layout.slots(0), lane / layout.slots(0)];
        let places = [0, 1].map(|n| slots[n].saturating_sub(layout.first(n, unknown)));
        let point = layout.point(row / layout.unknowns, places);
        point * layout.unknowns + unknown
    }

    /// The error for a pivot that cannot be used.
    fn fault(&self, matrix: CsrView<'_>, group: usize, fault: BadPivot) -> SolveError {
        let row = self.matrix_row(group, fault.lane, fault.row);
        let diagonal = Rows::new(&matrix).get(row, row);
        match self.symmetry {
            Symmetry::QuasiDefinite => SolveError::ZeroPivot { row, diagonal },
            _ => SolveError::NotPositiveDefinite { row, diagonal },
        }
    }

    /// The one point that a constant feels, whose row alone does not sum to zero, and its sum; none where
    /// several or no rows do not, and where the stencil holds that point already.
    fn grounded(&self, matrix: CsrView<'_>) -> Option<(usize, f64)> {
        if self.layout.unknowns > 1 {
            return None;
        }
        let mut sums = vec![0.0; matrix.rows()];
        multiply(matrix, &vec![1.0; matrix.rows()], &mut sums);
        let rows = Rows::new(&matrix);
        let mut held = (sums.into_iter().enumerate())
            .filter(|(row, sum)| sum.abs() > ROUNDING * rows.get(*row, *row));
        let beside = |row: usize| self.layout.places(row).1 != edge(&self.layout);
        let only = held.next().filter(|_| held.next().is_none());
        only.filter(|(row, _)| beside(*row))
    }

    /// Takes what the ground holds off the right-hand side, which is then in balance: summing all rows shows
    /// that the grounded value times `more` is the sum. Returns that value.
    fn balance(&self, x: &mut [f64]) -> Option<f64> {
        let (point, more) = self.ground?;
        let sum: f64 = x.iter().sum();
        x[point] -= sum;
        Some(sum / more)
    }

    fn forward(&mut self, x: &[f64]) {
        let layout = &self.layout;
        let lanes = layout.lanes();
        parallel::chunks(&mut self.waves, lanes, 1, |row, waves| {
            let unknown = row % layout.unknowns;
            waves.fill(0.0);
            each_place(layout, |places| {
                let point = layout.point(row / layout.unknowns, places);
                waves[layout.lane(unknown, places)] = x[point * layout.unknowns + unknown];
            });
            across(layout, unknown, waves, |own, values| {
                own.forward(unknown, values)
            });
        });
    }

    fn substitute(&mut self) {
        let (lanes, waves, rows) = (self.layout.lanes(), &self.waves, self.layout.rows());
        let factors = &self.factors;
        parallel::chunks(&mut self.groups, rows, 1, |group, values| {
            let start = group * WIDE;
            let own = start..lanes.min(start + WIDE);
            for (row, value) in values.iter_mut().enumerate() {
                value[..own.len()].copy_from_slice(&waves[row * lanes..][own.clone()]);
                value[own.len()..].fill(0.0);
            }
            factors[group].solve(values);
        });
    }

    fn backward(&mut self, x: &mut [f64]) {
        let (layout, groups) = (&self.layout, &self.groups);
        let (lanes, rows) = (layout.lanes(), layout.rows());
        let halves = layout
            .across
            .iter()
            .map(|own| 2.0 / own.transform.count as f64);
        let scale: f64 = halves.product();
        parallel::chunks(&mut self.waves, lanes, 1, |row, waves| {
            for (group, part) in waves.chunks_mut(WIDE).enumerate() {
                part.copy_from_slice(&groups[group * rows + row][..part.len()]);
            }
            let unknown = row % layout.unknowns;
            across(layout, unknown, waves, |own, values| {
                own.backward(unknown, values)
            });
        });
        let waves = &self.waves;
        parallel::chunks(x, layout.unknowns, 1024, |point, values| {
            let (along, places) = layout.places(point);
            for (unknown, value) in values.iter_mut().enumerate() {
                let row = along * layout.unknowns + unknown;
                *value = scale * waves[row * lanes + layout.lane(unknown, places)];
            }
        });
    }
}

/// Calls `work` with all places across the lines.
fn each_place(layout: &Layout, mut work: impl FnMut([usize; 2])) {
    for second in 0..layout.count(1) {
        for first in 0..layout.count(0) {
            work([first, second]);
        }
    }
}

/// Calls `work` with the values of an unknown in every row along each axis across the lines, in turn.
fn across(
    layout: &Layout,
    unknown: usize,
    waves: &mut [f64],
    work: impl Fn(&transform::Transform, &mut [f64]),
) {
    let slots = layout.slots(0);
    if let Some(own) = layout.across.first() {
        let (first, count) = (own.transform.first(unknown), own.transform.count);
        for values in waves.chunks_exact_mut(slots) {
            work(&own.transform, &mut values[first..first + count]);
        }
    }
    if let Some(own) = layout.across.get(1) {
        let first = own.transform.first(unknown);
        for column in 0..slots {
            let places = (first..first + own.transform.count).map(|place| place * slots + column);
            own.transform
                .at_places(waves, places, |values| work(&own.transform, values));
        }
    }
}

impl Factor for Transformed {
    fn factorise(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.factors.clear();
        self.ground = self.grounded(matrix);
        let stencil = Stencil::read(&self.layout, &self.reach, matrix);
        let symbols = Symbols::new(&self.layout, &self.reach, &stencil);
        let (rows, width) = (self.layout.rows(), self.width());
        let positive = self.symmetry == Symmetry::PositiveDefinite;
        // The stencil does not hold the ground, so the constant, the last row of the first lane, is free.
        let free = self.ground.map(|_| (0, 0, rows - 1));
        let factor = |group: usize| {
            let mut bands = Bands::zeros(rows, width);
            symbols.fill(group, &mut bands);
            let fault = bands.factorise(|row, lane, ratio| match positive {
                _ if free == Some((group, lane, row)) => Pivot::Free,
                true if ratio > LOST => Pivot::Good,
                false if ratio.abs() > LOST => Pivot::Good,
                _ => Pivot::Bad,
            });
            match fault {
                Some(fault) => Err(self.fault(matrix, group, fault)),
                None => Ok(bands),
            }
        };
        let groups = self.layout.lanes().div_ceil(WIDE);
        self.factors = parallel::map(groups, factor)
            .into_iter()
            .collect::<Result<_, _>>()?;
        self.stencil = Some(stencil);
        Ok(())
    }

    fn solve_in_place(&mut self, x: &mut [f64]) {
        if self.factors.is_empty() {
            return;
        }
        let held = self.balance(x);
        self.forward(x);
        self.substitute();
        self.backward(x);
        if let (Some(held), Some((point, _))) = (held, self.ground) {
            let shift = held - x[point];
            x.iter_mut().for_each(|value| *value += shift);
        }
    }

    fn size(&self) -> (u64, u64) {
        let numbers = self.layout.rows() * (self.width() + 1) * self.layout.lanes();
        (numbers as u64, 8 * numbers as u64)
    }

    fn explain(&self, matrix: CsrView<'_>) -> Option<SolveError> {
        let stencil = self.stencil.as_ref()?;
        let (row, off) = stencil.misfit(&self.layout, matrix, SAME)?;
        Some(SolveError::Refused {
            solver: NAME,
            symmetry: self.symmetry,
            advice: format!(
                "row {row} differs by {off:.1e} from those that it should repeat; the rows of a lattice do \
                 not repeat where coefficients vary, at fixed points and cracks; use `auto`"
            ),
        })
    }
}

#[cfg(test)]
mod tests;
