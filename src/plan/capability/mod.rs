//! What can be combined: schemes, effects, solvers and processes.
//!
//! One table decides, [`RULES`]; `check`, `plan` and `run` ask it through [`refusals`], and `perifrac
//! schemes` and `docs/combinations.md` are written from it by `page`. Which scheme an admitted plan gets,
//! and which systems that solves, is `method`.

mod feature;
mod method;
mod page;
mod rules;
#[cfg(test)]
mod tests;

use perifrac_solvers::{Backend, SolveError};

pub use feature::{Feature, Features, features};
pub use method::{Method, System, holds_stiffness, method, scales_mass, systems};
pub use page::{completed, page};
pub use rules::{Place, RULES, Rule};

use super::lattice;
use super::types::Plan;
use crate::scene::SchemeName;

/// A combination that is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// By a rule of the table.
    #[error("{scheme} cannot run this scene: {reason}; {remedy}")]
    Rule {
        /// Name of the scheme.
        scheme: &'static str,
        /// Why.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The solver does not take a system that the scheme solves.
    #[error(transparent)]
    Solver(#[from] SolveError),
}

/// All that forbids to run a plan by so many processes; empty if nothing does.
///
/// It is told from the plan alone: numbers of the model do not matter.
pub fn refusals(plan: &Plan, processes: usize) -> Vec<Refusal> {
    let scheme = plan.scheme.scheme();
    let refused: Vec<Refusal> = broken(scheme, &features(plan, processes))
        .map(|rule| rule.refusal(scheme))
        .collect();
    if !refused.is_empty() {
        // Which systems are solved is said of plans only that can be run.
        return refused;
    }
    solver_refusal(plan, processes)
        .into_iter()
        .map(Refusal::Solver)
        .collect()
}

/// The rules that a scheme breaks with these features.
pub fn broken<'a>(
    scheme: SchemeName,
    features: &'a Features,
) -> impl Iterator<Item = &'static Rule> + use<'a> {
    RULES.iter().filter(move |rule| {
        (rule.schemes.is_empty() || rule.schemes.contains(&scheme))
            && rule.with.iter().all(|own| features.contains(own))
            && !rule.without.iter().any(|own| features.contains(own))
    })
}

impl Rule {
    /// Why a scheme is refused.
    pub fn reason_for(&self, scheme: &str) -> String {
        self.reason.replace("{scheme}", scheme)
    }

    fn refusal(&self, scheme: SchemeName) -> Refusal {
        Refusal::Rule {
            scheme: scheme.name(),
            reason: self.reason_for(scheme.name()),
            remedy: self.remedy,
        }
    }
}

/// What the named solver says to the systems of the plan.
fn solver_refusal(plan: &Plan, processes: usize) -> Option<SolveError> {
    let backend = Backend::find(plan.solver.name()).ok()?;
    systems(plan).into_iter().find_map(|system| {
        let lattice = lattice(plan, system);
        let points = || {
            let lattice = lattice.as_ref().map_err(String::as_str);
            backend.takes_points(system.symmetry(), lattice)
        };
        let takes = backend.takes(system.symmetry(), processes);
        takes.and_then(|()| points()).err()
    })
}
