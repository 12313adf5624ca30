//! Times at which steps must end: outputs, and jumps in the slope of a load.

use crate::plan::Plan;

/// Step that fits before the next stop without leaving a sliver behind.
pub(super) fn clamp(dt: f64, remaining: f64) -> f64 {
    match remaining / dt {
        r if r <= 1.0 + 1e-9 => remaining,
        r if r < 2.0 - 1e-9 => 0.5 * remaining,
        _ => dt,
    }
}

/// A time at which a step must end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stop {
    /// The time, s.
    pub time: f64,
    /// Whether fields are written then.
    pub output: bool,
}

/// Output times and breakpoints of loads up to the end.
pub(super) struct OutputSchedule {
    stops: std::vec::IntoIter<Stop>,
    current: Option<Stop>,
    passed: usize,
}

impl OutputSchedule {
    /// Schedule of a plan whose loads have the given breakpoints.
    pub(super) fn new(plan: &Plan, breakpoints: &[f64]) -> Self {
        let (start, end) = (plan.time.start, plan.time.end);
        let first = start + 1e-12 * end;
        let outputs = plan
            .output
            .times
            .iter()
            .map(|&time| Stop { time, output: true });
        let breaks = breakpoints.iter().map(|&time| Stop {
            time,
            output: false,
        });
        let mut stops: Vec<Stop> = outputs
            .chain(breaks)
            .filter(|stop| stop.time > first && stop.time < end * (1.0 - 1e-12))
            .collect();
        stops.push(Stop {
            time: end,
            output: true,
        });
        stops.sort_by(|a, b| a.time.total_cmp(&b.time).then(b.output.cmp(&a.output)));
        stops.dedup_by(|b, a| b.time - a.time <= 1e-12 * end);
        let mut stops = stops.into_iter();
        let current = stops.next();
        OutputSchedule {
            stops,
            current,
            passed: 0,
        }
    }

    /// The next one, if any is left.
    pub(super) fn next(&self) -> Option<Stop> {
        self.current
    }

    /// Goes on to the one after.
    pub(super) fn pass(&mut self) {
        self.current = self.stops.next();
        self.passed += 1;
    }

    /// How many are behind.
    pub(super) fn passed(&self) -> usize {
        self.passed
    }
}
