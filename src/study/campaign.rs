//! Running the variants of a study: in turns, within a budget, and never twice.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::run::Interrupt;

use super::beaten::{Outcome, is_beaten};
use super::{Log, Measured, Row, Runner, Status, StudyCase, StudyError, Variant, profile};

/// Hears of the progress of a study.
pub(crate) trait Watcher {
    /// A run ended, or was found in the log.
    fn ended(&mut self, variant: &Variant, row: &Row, done: usize, of: usize);
}

impl Watcher for () {
    fn ended(&mut self, _: &Variant, _: &Row, _: usize, _: usize) {}
}

/// Runs variants and keeps their rows.
pub(crate) struct Campaign<'a> {
    /// What is studied.
    pub subject: &'a StudyCase,
    /// Starts the runs.
    pub runner: Runner,
    /// Keeps the rows.
    pub log: Log,
    /// Most runs per variant.
    pub repetitions: u32,
    /// When no further run is started.
    pub deadline: Instant,
    /// Longest single run.
    pub limit: Duration,
    /// Set by ctrl-C.
    pub interrupt: &'a Interrupt,
}

impl<'a> Campaign<'a> {
    /// A campaign with its log in `folder`.
    ///
    /// # Errors
    /// [`StudyError`] if the log cannot be opened or the program not be found.
    pub(crate) fn new(
        subject: &'a StudyCase,
        folder: &Path,
        repetitions: u32,
        (budget, limit): (Duration, Duration),
        interrupt: &'a Interrupt,
    ) -> Result<Self, StudyError> {
        Ok(Campaign {
            subject,
            runner: Runner::new(&subject.scene)?,
            log: Log::open(&folder.join("log.jsonl"))?,
            repetitions,
            deadline: Instant::now() + budget,
            limit,
            interrupt,
        })
    }

    /// Runs all variants once, methods in turns, then all again, as often as wished and as the budget
    /// allows. Gives a row at least of every variant, those whose turn did not come among them, and whether all
    /// runs were made.
    ///
    /// # Errors
    /// [`StudyError`] if a run cannot be started or its row not be kept; a run that fails is a row.
    pub(crate) fn run(
        &mut self,
        variants: &[Variant],
        watcher: &mut dyn Watcher,
    ) -> Result<(Vec<Measured>, bool), StudyError> {
        let order = turns(variants);
        let mut rows: Vec<Vec<Row>> = vec![Vec::new(); variants.len()];
        let mut outcomes: Vec<Option<Outcome>> = vec![None; variants.len()];
        let (mut done, mut complete) = (0, true);
        'rounds: for repetition in 0..self.repetitions {
            for &index in &order {
                let variant = &variants[index];
                let earlier = rows[index].first().map(|row| row.status);
                let enough = variant.once && earlier.is_some();
                if enough || earlier.is_some_and(|status| status != Status::Done) {
                    done += 1;
                    continue;
                }
                let idle = match is_beaten(index, variants, &outcomes) {
                    true => Some(Status::Beaten),
                    false => takes_too_long(variant, variants, &rows).then_some(Status::Skipped),
                };
                let Some(row) = self.row(variant, repetition, idle)? else {
                    complete = false;
                    if self.interrupt.is_raised() {
                        break 'rounds;
                    }
                    continue;
                };
                done += 1;
                watcher.ended(variant, &row, done, order.len() * self.repetitions as usize);
                outcomes[index].get_or_insert(Outcome::from(&row));
                rows[index].push(row);
            }
        }
        let measured = variants.iter().zip(rows).map(|(variant, mut rows)| {
            if rows.is_empty() {
                rows.push(self.not_run(variant));
            }
            Measured::new(variant.clone(), rows)
        });
        Ok((measured.collect(), complete))
    }

    /// The row of a variant whose turn did not come.
    fn not_run(&self, variant: &Variant) -> Row {
        let key = self.subject.key(self.runner.build(), &variant.overrides);
        let reason = match self.interrupt.is_raised() {
            true => "the study was interrupted",
            false => "the budget was used up",
        };
        Row::unmeasured(key, 0, Status::NotRun, reason.to_owned())
    }

    /// The row from the log, else that of a run that is `idle`, else a new one; `None` if time is up or the user wants to stop.
    fn row(
        &mut self,
        variant: &Variant,
        repetition: u32,
        idle: Option<Status>,
    ) -> Result<Option<Row>, StudyError> {
        let key = self.subject.key(self.runner.build(), &variant.overrides);
        // A run that was given less time than it may take now is run again.
        let too_short = self.limit.as_secs_f64();
        let known = |row: &&Row| row.status != Status::TimedOut || row.wall_s >= too_short;
        if let Some(row) = self.log.find(&key, repetition).filter(known) {
            return Ok(Some(row.clone()));
        }
        if let Some(status) = idle {
            let reason = match status {
                Status::Beaten => "another setting was cheaper on a coarser cloud",
                _ => "a cheaper run of this method took too long already",
            };
            let row = Row::unmeasured(key, repetition, status, reason.to_owned());
            return Ok(Some(row));
        }
        let left = self.deadline.saturating_duration_since(Instant::now());
        if left.is_zero() || self.interrupt.is_raised() {
            return Ok(None);
        }
        let folder = tempfile::tempdir().map_err(StudyError::Program)?;
        let limit = self.limit.min(left);
        let overrides = [&self.subject.overrides[..], &variant.overrides].concat();
        let ended = self
            .runner
            .run(&overrides, folder.path(), limit, self.interrupt)?;
        let Some(ended) = ended else {
            return Ok(None);
        };
        // What only the end of the budget cut short says nothing about the method.
        if ended.timed_out && limit < self.limit {
            return Ok(None);
        }
        let status = match (ended.timed_out, ended.code, &ended.summary) {
            (true, ..) => Status::TimedOut,
            (_, Some(0), Some(_)) => Status::Done,
            (_, Some(2 | 3), _) => Status::Refused,
            _ => Status::Failed,
        };
        let fields = match status {
            Status::Done => profile::fields(&folder.path().join("out"), variant.kept),
            _ => Vec::new(),
        };
        let row = Row {
            key,
            repetition,
            status,
            code: ended.code,
            reason: ended.reason,
            wall_s: ended.wall_s,
            cpu_s: ended.cpu_s,
            memory_bytes: ended.memory_bytes,
            summary: ended.summary,
            fields,
        };
        self.log.add(row.clone())?;
        Ok(Some(row))
    }
}

/// Whether a cheaper run of the same method and setting took too long.
fn takes_too_long(variant: &Variant, variants: &[Variant], rows: &[Vec<Row>]) -> bool {
    let late = |row: &Row| matches!(row.status, Status::TimedOut | Status::Skipped);
    variants.iter().zip(rows).any(|(other, rows)| {
        (other.method(), other.setting) == (variant.method(), variant.setting)
            && other.weight < variant.weight
            && rows.iter().any(late)
    })
}

/// The order of variants: what weighs less than nothing, which others are compared with, then methods in turns with the
/// cheapest run that each has left, so that a budget leaves none out because its runs are dear.
fn turns(variants: &[Variant]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..variants.len()).collect();
    order.sort_by(|&a, &b| variants[a].weight.total_cmp(&variants[b].weight));
    let mut had: BTreeMap<String, usize> = BTreeMap::new();
    let mut turn = vec![0; variants.len()];
    for &index in &order {
        let variant = &variants[index];
        if variant.weight >= 0.0 {
            let had = had.entry(variant.method()).or_default();
            *had += 1;
            turn[index] = *had;
        }
    }
    order.sort_by_key(|&index| turn[index]);
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_take_turns_and_what_others_are_compared_with_comes_first() {
        let runs = [
            ("explicit", 400.0),
            ("implicit", 3.0),
            ("implicit", 1.0),
            ("explicit", 100.0),
            ("over-resolved", -1.0),
            ("implicit", 2.0),
            ("over-resolved", -2.0),
        ];
        let variants = runs.map(|(scheme, weight)| Variant {
            scheme: scheme.to_owned(),
            weight,
            ..Variant::default()
        });
        assert_eq!(turns(&variants), [6, 4, 2, 3, 5, 0, 1]);
    }
}
