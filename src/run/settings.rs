//! How a run is done, beside what its plan says.

/// Settings of a run; the default does nothing beyond the plan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Settings {
    /// Does every so manieth sound step twice, throwing the first trial away: the results must be the same.
    pub reject_every: Option<u64>,
}
