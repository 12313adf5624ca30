//! How a run of the map ended.

use crate::study::{Measured, Status};

/// Error above which a run that reached its end is inaccurate.
pub(super) const INACCURATE: f64 = 0.05;
/// Error above which a run that reached its end has diverged all the same.
const DIVERGED: f64 = 1.0;
/// Overshoot of the pressure, relative to its range at the start, that counts as oscillation.
pub(super) const OVERSHOOT: f64 = 0.05;

/// How a run went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    Converged,
    Inaccurate,
    Oscillating,
    Diverged,
    Refused,
    Unfinished,
}

impl Class {
    /// In the order of legends.
    pub const ALL: [Class; 6] = [
        Class::Converged,
        Class::Inaccurate,
        Class::Oscillating,
        Class::Diverged,
        Class::Refused,
        Class::Unfinished,
    ];

    /// The class of a run.
    pub fn of(run: &Measured) -> Class {
        match run.first().status {
            Status::Done => {}
            Status::Refused => return Class::Refused,
            Status::TimedOut | Status::Skipped => return Class::Unfinished,
            _ => return Class::Diverged,
        }
        let error = run.error();
        if error > DIVERGED {
            return Class::Diverged;
        }
        let number = |path: &str| run.number(path);
        let (low, high) = (number("/pressure_range/0"), number("/pressure_range/1"));
        let range = high - low;
        // Drained and sealed pressures stay on one side of zero.
        if low < -OVERSHOOT * range && high > 0.0 && error > INACCURATE {
            return Class::Oscillating;
        }
        match error > INACCURATE {
            true => Class::Inaccurate,
            false => Class::Converged,
        }
    }

    /// Whether nothing grew that the exact solution has not.
    pub fn is_stable(self) -> bool {
        matches!(self, Class::Converged | Class::Inaccurate)
    }

    /// As in legends.
    pub fn name(self) -> &'static str {
        match self {
            Class::Converged => "converged",
            Class::Inaccurate => "inaccurate",
            Class::Oscillating => "oscillating",
            Class::Diverged => "diverged",
            Class::Refused => "refused",
            Class::Unfinished => "unfinished",
        }
    }
}
