//! The part of a system that this process answers for.
//!
//! Without a partition it is the whole. With one, checks and norms look at the rows of this
//! process only and their outcome is made the same on all, so that either every process goes on
//! or every process stops.

use std::sync::Arc;

use crate::matrix::ordered_norm;
use crate::{Communicator, Problem, SolveError};

/// Rows of this process and the team that holds the others.
#[derive(Debug, Clone, Default)]
pub(crate) struct Share(Option<Part>);

#[derive(Debug, Clone)]
struct Part {
    team: Arc<dyn Communicator>,
    /// Whether each row is held here.
    rows: Vec<bool>,
}

impl Share {
    /// The share of a validated problem.
    pub(crate) fn of(problem: &Problem<'_>) -> Self {
        let part = |partition: &crate::Partition| {
            let mask = partition.mask().into_iter();
            let rows = mask.flat_map(|own| std::iter::repeat_n(own, problem.unknowns_per_point));
            Part {
                team: partition.team().clone(),
                rows: rows.collect(),
            }
        };
        Self(problem.partition.map(part))
    }

    /// Whether a row is held here.
    pub(crate) fn owns(&self, row: usize) -> bool {
        self.0.as_ref().is_none_or(|part| part.rows[row])
    }

    /// Euclidean norm of `term(row)` over the rows of all processes, the same bits on each.
    pub(crate) fn norm(&self, rows: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
        let Some(Part { team, rows: own }) = &self.0 else {
            return ordered_norm(rows, term);
        };
        let mut norms = vec![0.0; team.size()];
        norms[team.rank()] = ordered_norm(rows, |row| if own[row] { term(row) } else { 0.0 });
        team.sum(&mut norms);
        ordered_norm(norms.len(), |process| norms[process])
    }

    /// The error of the first process that has one, on every process.
    pub(crate) fn agree(&self, outcome: Result<(), SolveError>) -> Result<(), SolveError> {
        let Some(Part { team, .. }) = &self.0 else {
            return outcome;
        };
        let mut board = vec![0.0; LETTERS * team.size()];
        if let Err(error) = &outcome {
            board[LETTERS * team.rank()..][..LETTERS].copy_from_slice(&encode(error));
        }
        team.sum(&mut board);
        let first = board.chunks(LETTERS).position(|letters| letters[0] > 0.0);
        match (first, outcome) {
            (None, _) => Ok(()),
            (Some(process), Err(error)) if process == team.rank() => Err(error),
            (Some(process), _) => Err(decode(process, &board[LETTERS * process..])),
        }
    }
}

/// Numbers that describe an error to other processes: its kind, row and value.
const LETTERS: usize = 3;
/// Kinds of undefined numbers, by what holds them.
const HOLDERS: [&str; 3] = ["the matrix", "the right-hand side", "the initial guess"];
const SINGULAR: f64 = 4.0;
const NOT_POSITIVE: f64 = 5.0;
const OTHER: f64 = 6.0;
const INTERRUPTED: f64 = 7.0;

fn encode(error: &SolveError) -> [f64; LETTERS] {
    match error {
        SolveError::NotFinite { what, row, value } => {
            match HOLDERS.iter().position(|holder| holder == what) {
                Some(holder) => [1.0 + holder as f64, *row as f64, *value],
                None => [OTHER, 0.0, 0.0],
            }
        }
        SolveError::Singular { row } => [SINGULAR, *row as f64, 0.0],
        SolveError::NotPositiveDefinite { row, diagonal } => [NOT_POSITIVE, *row as f64, *diagonal],
        SolveError::Interrupted => [INTERRUPTED, 0.0, 0.0],
        _ => [OTHER, 0.0, 0.0],
    }
}

fn decode(process: usize, letters: &[f64]) -> SolveError {
    let (kind, row, value) = (letters[0], letters[1] as usize, letters[2]);
    let is = |other: f64| (kind - other).abs() < 0.5;
    if is(SINGULAR) {
        return SolveError::Singular { row };
    }
    if is(INTERRUPTED) {
        return SolveError::Interrupted;
    }
    if is(NOT_POSITIVE) {
        let diagonal = value;
        return SolveError::NotPositiveDefinite { row, diagonal };
    }
    match HOLDERS.get(kind as usize - 1) {
        Some(what) => SolveError::NotFinite { what, row, value },
        None => SolveError::OtherProcess { process },
    }
}
