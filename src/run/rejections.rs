//! Steps that were not accepted, and why.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::summary::Name;
use crate::schemes::Rejection;

/// Rejected steps by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rejections([u64; Rejection::ALL.len()]);

impl Rejections {
    /// Counts one.
    pub fn count(&mut self, reason: Rejection) {
        self.0[reason as usize] += 1;
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// Rejections for one reason.
    pub fn of(&self, reason: Rejection) -> u64 {
        self.0[reason as usize]
    }

    /// Rejections by the name of their reason.
    pub fn named(&self) -> BTreeMap<Name, u64> {
        let named = Rejection::ALL.map(|reason| (reason.name().into(), self.of(reason)));
        named.into_iter().collect()
    }
}

/// What step control is told about a step, relative to what is allowed at the tolerance of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Verdict {
    /// Error over the range of the pressure; `None` without an estimate.
    pub error: Option<f64>,
    /// Growth of damage over the allowed one, times the tolerance; `None` without damage.
    pub growth: Option<f64>,
}

impl Verdict {
    /// What limits the step.
    pub(super) fn largest(&self) -> Option<f64> {
        match (self.error, self.growth) {
            // NaN counts as largest.
            (Some(error), Some(growth)) if error.is_nan() || error > growth => Some(error),
            (error, growth) => growth.or(error),
        }
    }

    /// Why the step is rejected, if it is.
    pub(super) fn reason(&self) -> Rejection {
        match self.growth.is_some() && self.largest() == self.growth {
            true => Rejection::Growth,
            false => Rejection::Error,
        }
    }
}
