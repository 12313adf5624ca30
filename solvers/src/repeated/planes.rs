//! Products with rows of which many in a row are the same: a value times many entries of the vector at once.
//!
//! On a lattice the same unknown of a point and of the next have the same row. Vectors are put in order of unknowns,
//! one plane of all points after the other, so that such rows read entries that lie side by side. Every row is summed
//! as by [`crate::matrix::four_sums`], to the last bit.

use std::collections::HashMap;

use super::{ROWS_PER_TASK, RepeatedRows};
use crate::parallel;

/// Most unknowns a point may have: displacement and pressure in space.
const MOST_UNKNOWNS: usize = 4;
/// Rows that are summed in step; four sums of each fill the registers of any processor.
const WIDE: usize = 16;
const NARROW: usize = 4;
/// Rows of a run, on average, from which runs are taken: with fewer, rows would be summed one by one.
const WORTHWHILE: usize = NARROW;

/// The rows in order of planes, by runs of rows that are the same.
#[derive(Debug, Clone)]
pub(super) struct Planes {
    /// Rows from one of a plane to the next.
    stride: usize,
    /// Rows of a plane.
    length: usize,
    /// Runs within the planes, in order.
    runs: Vec<Run>,
    /// Places of the columns less that of the row, for every kind of rows and unknown.
    steps: Vec<i32>,
}

/// Rows that are the same.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// First place in order of planes.
    start: u32,
    /// Which of the distinct rows.
    kind: u32,
    /// First of its steps.
    steps: u32,
}

impl Planes {
    /// The planes of these rows; `None` where runs are too short.
    pub(super) fn of(rows: &RepeatedRows) -> Option<Self> {
        let count = rows.kinds.len();
        let strides = (1..=MOST_UNKNOWNS).filter(|stride| count.is_multiple_of(*stride));
        let all = strides.map(|stride| Self::with(&rows.kinds, stride));
        let best = all.min_by_key(|planes| planes.runs.len())?;
        let long = best.runs.len() * WORTHWHILE <= count;
        long.then(|| best.with_steps(rows))
    }

    fn with(kinds: &[u32], stride: usize) -> Self {
        let length = kinds.len() / stride;
        let mut runs: Vec<Run> = Vec::new();
        for unknown in 0..stride {
            let own = kinds.iter().skip(unknown).step_by(stride).enumerate();
            for (place, &kind) in own {
                if place == 0 || runs.last().is_none_or(|last| last.kind != kind) {
                    runs.push(Run {
                        start: (unknown * length + place) as u32,
                        kind,
                        steps: 0,
                    });
                }
            }
        }
        Planes {
            stride,
            length,
            runs,
            steps: Vec::new(),
        }
    }

    /// The same with the steps of all runs.
    fn with_steps(mut self, rows: &RepeatedRows) -> Self {
        let (length, stride) = (self.length as i64, self.stride as i64);
        let mut known = HashMap::new();
        for run in &mut self.runs {
            let unknown = i64::from(run.start) / length;
            let steps = &mut self.steps;
            run.steps = *known.entry((run.kind, unknown)).or_insert_with(|| {
                let first = steps.len() as u32;
                steps.extend(rows.kind(run.kind).0.iter().map(|distance| {
                    let column = unknown + i64::from(*distance);
                    let plane = column.rem_euclid(stride) - unknown;
                    (plane * length + column.div_euclid(stride)) as i32
                }));
                first
            });
        }
        self
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Run>() * self.runs.len() + 4 * self.steps.len()
    }

    /// Computes `y = A x`.
    pub(super) fn multiply(&self, rows: &RepeatedRows, x: &[f64], y: &mut [f64]) {
        if self.stride == 1 {
            return self.products(rows, x, y);
        }
        let columns: Vec<f64> = (0..self.stride)
            .flat_map(|unknown| x.iter().skip(unknown).step_by(self.stride))
            .copied()
            .collect();
        let mut found = vec![0.0; y.len()];
        self.products(rows, &columns, &mut found);
        for (unknown, plane) in found.chunks_exact(self.length).enumerate() {
            let own = y.iter_mut().skip(unknown).step_by(self.stride);
            own.zip(plane).for_each(|(y, found)| *y = *found);
        }
    }

    /// The same with both vectors in order of planes.
    fn products(&self, rows: &RepeatedRows, x: &[f64], y: &mut [f64]) {
        parallel::chunks(y, ROWS_PER_TASK, 1, |task, y| {
            self.task(rows, x, task * ROWS_PER_TASK, y);
        });
    }

    /// Products of the rows from place `first` on.
    fn task(&self, rows: &RepeatedRows, x: &[f64], first: usize, y: &mut [f64]) {
        let next = self.runs.partition_point(|run| run.start as usize <= first);
        let runs = &self.runs[next.saturating_sub(1)..];
        let (mut at, end) = (first, first + y.len());
        for (number, run) in runs.iter().enumerate() {
            let stop = runs.get(number + 1).map_or(end, |own| own.start as usize);
            let stop = stop.min(end);
            let values = rows.kind(run.kind).1;
            let steps = &self.steps[run.steps as usize..][..values.len()];
            products(steps, values, (x, at), &mut y[at - first..stop - first]);
            at = stop;
            if at == end {
                break;
            }
        }
    }
}

/// Products of a row at a place and of those that follow it, whose columns lie one place further each time.
fn products(steps: &[i32], values: &[f64], (x, at): (&[f64], usize), y: &mut [f64]) {
    let (wide, rest) = y.as_chunks_mut::<WIDE>();
    let (narrow, single) = rest.as_chunks_mut::<NARROW>();
    let mut at = at;
    for y in wide {
        *y = in_step(steps, values, x, at);
        at += WIDE;
    }
    for y in narrow {
        *y = in_step(steps, values, x, at);
        at += NARROW;
    }
    for y in single {
        [*y] = in_step(steps, values, x, at);
        at += 1;
    }
}

/// As [`crate::matrix::four_sums`] for several rows, the first at a place.
#[inline]
fn in_step<const ROWS: usize>(steps: &[i32], values: &[f64], x: &[f64], at: usize) -> [f64; ROWS] {
    let (mut sums, mut tail) = ([[0.0; ROWS]; 4], [0.0; ROWS]);
    let (step_blocks, step_tail) = steps.as_chunks::<4>();
    let (value_blocks, value_tail) = values.as_chunks::<4>();
    // One sum after the other, so that it stays in registers.
    for (lane, sums) in sums.iter_mut().enumerate() {
        for (steps, values) in step_blocks.iter().zip(value_blocks) {
            add(sums, values[lane], x, at, steps[lane]);
        }
    }
    for (step, value) in step_tail.iter().zip(value_tail) {
        add(&mut tail, *value, x, at, *step);
    }
    std::array::from_fn(|row| {
        ((sums[0][row] + sums[1][row]) + (sums[2][row] + sums[3][row])) + tail[row]
    })
}

/// Adds a value times the columns of rows that follow each other.
#[inline(always)]
fn add<const ROWS: usize>(sums: &mut [f64; ROWS], value: f64, x: &[f64], at: usize, step: i32) {
    let place = at.wrapping_add_signed(step as isize);
    // A column beyond the matrix would be no number, and be found.
    let columns = x.get(place..).and_then(<[f64]>::first_chunk::<ROWS>);
    let columns = columns.copied().unwrap_or([f64::NAN; ROWS]);
    for row in 0..ROWS {
        sums[row] += value * columns[row];
    }
}
