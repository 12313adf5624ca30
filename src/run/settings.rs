//! How a run is done, beside what its plan says.

use std::time::Duration;

/// Settings of a run; the default does nothing beyond the plan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Settings {
    /// Does every Nth sound step twice, throwing the first trial away: the results must be the same.
    pub reject_every: Option<u64>,
    /// When checkpoints are written; none without a rule.
    pub checkpoints: Option<CheckpointRule>,
}

/// When checkpoints are written: also when a run is interrupted, before it fails, and at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CheckpointRule {
    /// Wall time between two.
    pub every: Duration,
    /// Whether at every output as well.
    pub at_outputs: bool,
}

impl Default for CheckpointRule {
    /// Ten minutes, the work that a crash may cost.
    fn default() -> Self {
        CheckpointRule {
            every: Duration::from_secs(600),
            at_outputs: false,
        }
    }
}
