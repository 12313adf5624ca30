//! Runs of scenes whose rock breaks: steps are bounded on the cloud of the scene itself.
//!
//! Where rock breaks the width of its cracks follows the horizon, so that another cloud is another
//! problem; and steps follow the growth of damage beside an error. Methods are therefore compared by their
//! errors in time on one cloud, at bounds of the step, of that growth and of the error which shrink alike.

use super::variants::weight;
use crate::plan::{DamagePlan, StepRule};
use crate::study::over_resolved::{LEVELS, as_level};
use crate::study::{Options, StudyCase, Variant};

/// Bounds relative to those of the scene.
const SHARES: [f64; 4] = [2.0, 1.0, 0.5, 0.25];
const QUICK: [f64; 2] = [2.0, 1.0];
/// Bound of a step relative to the run where the scene has none.
const USUAL: f64 = 0.02;
/// Value of a variant: the bound of its steps, s.
pub(super) const STEP: &str = "largest step";

/// Every method at every bound, and the chain of over-resolved runs.
pub(super) fn variants(
    subject: &StudyCase,
    damage: &DamagePlan,
    options: &Options,
) -> Vec<Variant> {
    let shares: &[f64] = if options.quick { &QUICK } else { &SHARES };
    let mut variants = Vec::new();
    for method in subject.methods(options) {
        let solvers = subject.solvers(method.scheme, options);
        let solvers = match method.scheme {
            "monolithic" => &solvers[..],
            _ => &solvers[..1],
        };
        // An explicit scheme keeps to its own limit.
        let shares = if method.integrator.is_some() {
            shares
        } else {
            &[1.0]
        };
        for (solver, share) in solvers
            .iter()
            .flat_map(|s| shares.iter().map(move |b| (s, *b)))
        {
            let mut variant = bounded(method.variant(Some(solver)), subject, damage, share);
            variant.weight = weight(method.scheme, 1, 1.0) / share;
            variants.push(variant);
        }
    }
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    if let (Some(method), false) = (
        subject.methods(&Options::default()).first(),
        variants.is_empty(),
    ) {
        variants.extend((0..LEVELS).map(|level| {
            let share = 0.5 * least * 0.5_f64.powi(level);
            let variant = bounded(method.variant(Some("auto")), subject, damage, share);
            as_level(variant, level)
        }));
    }
    variants
}

/// A variant with the bounds of the scene times `share`.
fn bounded(variant: Variant, subject: &StudyCase, damage: &DamagePlan, share: f64) -> Variant {
    let time = &subject.plan.time;
    let step = match time.step {
        StepRule::Fixed(step) => step,
        StepRule::Adaptive => time.max_step.unwrap_or(USUAL * time.end),
    } * share;
    let bounds = match time.step {
        StepRule::Fixed(_) => vec![format!("time.step={step:?}")],
        StepRule::Adaptive => vec![
            format!("time.max_step={step:?}"),
            format!(
                "time.first_step={:?}",
                time.first_step.unwrap_or(step).min(step) * share
            ),
            format!(
                "damage.largest_increment={:?}",
                (damage.largest_increment * share).min(1.0)
            ),
            format!("damage.shortest_step={:?}", damage.shortest_step * share),
            // Of second order in the step, as the error of one step is.
            format!(
                "time.tolerance={:?}",
                (time.tolerance * share * share).min(0.1)
            ),
        ],
    };
    variant.set(bounds).with(STEP, step)
}
