//! What a scene would be refused for, found before it is run: the one answer that `check`, `plan` and
//! `run` give.

use super::{RunError, takeover};
use crate::explain::{Explanation, Memory, explain};
use crate::model::Model;
use crate::plan::{Plan, TimeMode};
use crate::report::Timers;
use crate::schemes;

/// Bytes of families, gradients and matrices up to which a model is built to be examined: a second at most. A grid of
/// 384,000 flat cells, which takes two with its faces, is beyond it.
const MOST_BYTES: u64 = 50_000_000;

/// A plan that a run would begin with.
#[derive(Debug, Clone)]
pub struct Examined {
    /// What it will do and cost; its warnings are those of the plan and of the model.
    pub explanation: Explanation,
    /// Whether model and scheme were built; else the answer comes from estimates.
    pub built: bool,
}

/// Examines a plan of dimension `D` for a run by so many processes: estimates what it takes, and builds model
/// and scheme where that takes no more than about half a second.
///
/// # Errors
/// [`RunError`] as a run would give it at its start.
pub fn examine<const D: usize>(plan: &Plan, processes: usize) -> Result<Examined, RunError> {
    let refused = |error| RunError::refused(plan, error);
    schemes::check(plan, processes).map_err(refused)?;
    let mut explanation = explain::<D>(plan)?;
    let built = model_bytes(&explanation.memory) <= MOST_BYTES;
    if built {
        let mut model = Model::<D>::build(plan, &mut Timers::default())?;
        takeover::check_start(plan, Some(&mut model), processes)?;
        if plan.time.mode == TimeMode::Transient {
            schemes::build(plan, &model).map_err(refused)?;
        }
        for warning in model.warnings {
            if !explanation.warnings.contains(&warning) {
                explanation.warnings.push(warning);
            }
        }
    } else {
        takeover::check_start::<D>(plan, None, processes)?;
    }
    Ok(Examined { explanation, built })
}

/// As [`examine`], for a plan of any dimension.
///
/// # Errors
/// As [`examine`].
pub fn examine_plan(plan: &Plan, processes: usize) -> Result<Examined, RunError> {
    match plan.dimension {
        2 => examine::<2>(plan, processes),
        _ => examine::<3>(plan, processes),
    }
}

fn model_bytes(memory: &Memory) -> u64 {
    memory.bonds + memory.gradients + memory.matrices
}
