//! How much work was done: the effort that tests assert and studies compare.

use std::borrow::Cow;
use std::collections::BTreeMap;

use perifrac_solvers::SolverCounters;
use serde::{Deserialize, Serialize};

/// Effort of a run. Names of effects and fields that the scene does not call for are absent.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Counters {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Products with an assembled operator.
    pub operator_products: u64,
    /// Times the coefficient matrix was filled.
    pub refills: u64,
    /// Times the stiffness was filled; 0 without mechanics.
    pub stiffness_refills: u64,
    /// What the linear solver of flow, or of flow and mechanics together, did.
    pub solver: SolverCounters,
    /// What the linear solver of mechanics alone did, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mechanics: Option<SolverCounters>,
    /// Newton iterations of mechanics.
    pub newton_iterations: u64,
    /// Passes between flow and mechanics.
    pub coupling_iterations: u64,
    /// Iterations of dynamic relaxation.
    pub relaxation_iterations: u64,
    /// Single steps of the solid.
    pub single_steps: u64,
    /// Newton tangents of a breaking solid that were given up for positive ones.
    pub fallbacks: u64,
    /// Evaluations of the forces of a breaking solid along search directions.
    pub searches: u64,
    /// Families whose stiffness was filled anew because damage changed it.
    pub refilled_families: u64,
    /// Evaluations per effect.
    pub evaluations: BTreeMap<Cow<'static, str>, u64>,
    /// Bytes per field of the state.
    pub field_bytes: BTreeMap<Cow<'static, str>, usize>,
    /// Bytes of everything else, by what holds them.
    pub bytes: BTreeMap<Cow<'static, str>, usize>,
}

impl Counters {
    /// Evaluations of an effect; zero for one that does not exist in the run.
    pub fn evaluations(&self, effect: &str) -> u64 {
        self.evaluations.get(effect).copied().unwrap_or(0)
    }
}
