//! Which rows this process gives to PETSc, and under which numbers.
//!
//! PETSc numbers unknowns process after process. The points of a process keep their order.

use std::borrow::Cow;

use perifrac_petsc_sys::Comm;

use crate::matrix::Rows;
use crate::{CsrView, Partition, Problem, SolveError};

/// Rows of this process with PETSc's numbers of their columns.
pub(crate) struct Pattern {
    pub(crate) starts: Vec<i32>,
    pub(crate) columns: Vec<i32>,
}

/// How the unknowns of the caller and those of PETSc belong together.
#[derive(Debug)]
pub(crate) struct Layout {
    per_point: usize,
    /// Number of all unknowns.
    size: usize,
    /// PETSc's number of the first unknown held here.
    first: usize,
    /// Number of unknowns held here.
    rows: usize,
    /// Nothing where PETSc's numbers are those of the caller.
    renumbered: Option<Renumbered>,
}

#[derive(Debug)]
struct Renumbered {
    /// The points held here, by the caller's numbers.
    points: Vec<u32>,
    /// Place of every value of the pattern among the values of the caller.
    places: Vec<u32>,
}

impl Layout {
    /// The layout of a validated problem, and its pattern.
    pub(crate) fn of(problem: &Problem<'_>) -> Result<(Self, Pattern), SolveError> {
        let unknowns = problem.unknowns();
        if i32::try_from(unknowns).is_err() || i32::try_from(problem.pattern.nnz()).is_err() {
            return Err(SolveError::TooLarge {
                unknowns,
                reason: "PETSc counts with 32-bit integers".into(),
            });
        }
        let mut layout = Self {
            per_point: problem.unknowns_per_point,
            size: unknowns,
            first: 0,
            rows: unknowns,
            renumbered: None,
        };
        let matrix = problem.pattern;
        let Some(partition) = problem.partition else {
            let rows = Rows::new(&matrix);
            let base = rows.starts()[0];
            let starts = rows.starts().iter().map(|start| (start - base) as i32);
            let columns = rows.columns().iter().map(|column| *column as i32);
            let (starts, columns) = (starts.collect(), columns.collect());
            return Ok((layout, Pattern { starts, columns }));
        };
        let pattern = layout.renumber(partition, matrix);
        Ok((layout, pattern))
    }

    fn renumber(&mut self, partition: &Partition, matrix: CsrView<'_>) -> Pattern {
        let per_point = self.per_point;
        let mut number_of = vec![0_u32; partition.order().len()];
        for (number, point) in partition.order().iter().enumerate() {
            number_of[*point as usize] = number as u32;
        }
        let points = partition.own().to_vec();
        self.first = partition.starts()[partition.team().rank()] * per_point;
        self.rows = points.len() * per_point;
        let (mut starts, mut columns, mut places) = (vec![0], Vec::new(), Vec::new());
        let (rows, indptr) = (Rows::new(&matrix), matrix.indptr());
        let mut entries: Vec<(u32, u32)> = Vec::new();
        let unknowns = points.iter().flat_map(|p| unknowns(*p, per_point));
        for row in unknowns {
            let range = indptr.outer_inds_sz(row);
            entries.clear();
            for (column, place) in rows.row(row).0.iter().zip(range) {
                let (point, part) = (*column as usize / per_point, *column as usize % per_point);
                let number = number_of[point] as usize * per_point + part;
                entries.push((number as u32, place as u32));
            }
            entries.sort_unstable();
            columns.extend(entries.iter().map(|(column, _)| *column as i32));
            places.extend(entries.iter().map(|(_, place)| *place));
            starts.push(columns.len() as i32);
        }
        self.renumbered = Some(Renumbered { points, places });
        Pattern { starts, columns }
    }

    pub(crate) fn comm(&self) -> Comm {
        match self.renumbered {
            Some(_) => Comm::Communicator,
            None => Comm::Own,
        }
    }

    pub(crate) fn per_point(&self) -> usize {
        self.per_point
    }

    pub(crate) fn size(&self) -> usize {
        self.size
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Values of the pattern's entries.
    pub(crate) fn values<'a>(&self, matrix: &'a CsrView<'_>) -> Cow<'a, [f64]> {
        let data = matrix.data();
        match &self.renumbered {
            None => Cow::Borrowed(data),
            Some(own) => own
                .places
                .iter()
                .map(|place| data[*place as usize])
                .collect(),
        }
    }

    /// Values at the points held here, `per_point` each.
    pub(crate) fn at_points(&self, full: &[f64], per_point: usize) -> Vec<f64> {
        match &self.renumbered {
            None => full.to_vec(),
            Some(own) => {
                let unknowns = own.points.iter().flat_map(|p| unknowns(*p, per_point));
                unknowns.map(|unknown| full[unknown]).collect()
            }
        }
    }

    /// Copies the entries held here.
    pub(crate) fn take(&self, full: &[f64], own: &mut [f64]) {
        self.for_each(|local, unknown| own[local] = full[unknown]);
    }

    /// Adds `scale · own` to the entries held here.
    pub(crate) fn add(&self, scale: f64, own: &[f64], full: &mut [f64]) {
        self.for_each(|local, unknown| full[unknown] += scale * own[local]);
    }

    fn for_each(&self, mut action: impl FnMut(usize, usize)) {
        match &self.renumbered {
            None => (0..self.rows).for_each(|row| action(row, row)),
            Some(own) => {
                let all = own.points.iter().flat_map(|p| unknowns(*p, self.per_point));
                all.enumerate()
                    .for_each(|(local, unknown)| action(local, unknown));
            }
        }
    }

    /// PETSc's numbers of the unknowns `parts` of every point held here.
    pub(crate) fn numbers(&self, parts: std::ops::Range<usize>) -> Vec<i32> {
        let points = (self.first..self.first + self.rows).step_by(self.per_point);
        points
            .flat_map(|start| parts.clone().map(move |part| (start + part) as i32))
            .collect()
    }
}

fn unknowns(point: u32, per_point: usize) -> std::ops::Range<usize> {
    let start = point as usize * per_point;
    start..start + per_point
}
