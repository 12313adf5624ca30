//! How many runs of a study ended in which way, and how to get those that are missing.

use std::fmt;

use serde_json::{Value, json};

use super::{Measured, Status};

/// How many runs of a study ended in which way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Coverage {
    counts: [(Status, usize); 7],
    of: usize,
}

impl Coverage {
    /// Of these runs, with those that were not begun.
    pub(crate) fn of<'a>(runs: impl IntoIterator<Item = &'a Measured>) -> Self {
        let all = [
            Status::Done,
            Status::Failed,
            Status::Refused,
            Status::TimedOut,
            Status::Skipped,
            Status::Beaten,
            Status::NotRun,
        ];
        let mut counts = all.map(|status| (status, 0));
        let mut of = 0;
        for run in runs {
            of += 1;
            let own = counts
                .iter_mut()
                .filter(|(status, _)| *status == run.first().status);
            own.for_each(|(_, count)| *count += 1);
        }
        Coverage { counts, of }
    }

    fn count(&self, wanted: &[Status]) -> usize {
        let own = self.counts.iter();
        own.filter(|(status, _)| wanted.contains(status))
            .map(|(_, count)| count)
            .sum()
    }

    /// Runs that reached their end.
    pub(crate) fn done(&self) -> usize {
        self.count(&[Status::Done])
    }

    /// Whether more time gives more runs.
    pub(crate) fn lacks_time(&self) -> bool {
        self.count(&[Status::TimedOut, Status::Skipped]) > 0
    }

    /// For report.json.
    pub(crate) fn facts(&self) -> Value {
        let counts = self.counts.iter();
        let counts: serde_json::Map<String, Value> = counts
            .map(|(status, count)| (status.name().replace(' ', "-"), json!(count)))
            .collect();
        json!({ "planned": self.of, "outcomes": counts })
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} runs done", self.done(), self.of)?;
        let others = self.counts.iter().skip(1).filter(|(_, count)| *count > 0);
        others
            .into_iter()
            .try_for_each(|(status, count)| write!(f, ", {count} {}", status.name()))
    }
}

/// A study as it was asked for, and how far it came.
#[derive(Debug, Clone)]
pub(crate) struct Request {
    /// The command as typed, with all its options.
    pub command: String,
    /// The command that gives a study more time than this one had.
    pub longer: String,
    /// Whether all runs and repetitions were made.
    pub complete: bool,
}

impl Request {
    /// How to get the runs that are missing; `None` if more time gives no more of them.
    pub(crate) fn remedy(&self, coverage: &Coverage) -> Option<String> {
        match (coverage.lacks_time(), self.complete) {
            (true, _) => Some(format!("`{}` gives runs more time", self.longer)),
            (false, false) if coverage.count(&[Status::NotRun]) == 0 => Some(
                "repetitions are missing: the same command goes on where it stopped".to_owned(),
            ),
            (false, false) => Some("the same command goes on where it stopped".to_owned()),
            (false, true) => None,
        }
    }

    /// Both in one sentence, without its full stop.
    pub(crate) fn state(&self, coverage: &Coverage) -> String {
        let remedy = self.remedy(coverage);
        let remedy = remedy.map_or(String::new(), |remedy| format!("; {remedy}"));
        format!("{coverage}{remedy}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Row, Variant};

    fn runs(statuses: &[Status]) -> Vec<Measured> {
        let row = |status: &Status| Row::unmeasured(String::new(), 0, *status, String::new());
        statuses
            .iter()
            .map(|status| Measured::new(Variant::default(), vec![row(status)]))
            .collect()
    }

    fn state(statuses: &[Status], complete: bool) -> String {
        let request = Request {
            command: "c --budget 1s".to_owned(),
            longer: "c".to_owned(),
            complete,
        };
        request.state(&Coverage::of(&runs(statuses)))
    }

    #[test]
    fn what_is_missing_is_told_with_the_command_that_gives_it() {
        use Status::{Done, Failed, NotRun, Skipped, TimedOut};
        assert_eq!(
            state(&[Done, Failed], true),
            "1 of 2 runs done, 1 failed",
            "nothing is left to run"
        );
        assert_eq!(
            state(&[Done, NotRun], false),
            "1 of 2 runs done, 1 not run; the same command goes on where it stopped"
        );
        assert_eq!(
            state(&[TimedOut, Skipped, NotRun], false),
            "0 of 3 runs done, 1 timed out, 1 skipped, 1 not run; `c` gives runs more time"
        );
        assert_eq!(
            state(&[Done], false),
            "1 of 1 runs done; repetitions are missing: the same command goes on where it stopped"
        );
        assert_eq!(state(&[], true), "0 of 0 runs done");
    }
}
