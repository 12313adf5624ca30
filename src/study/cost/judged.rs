//! What the errors of a case without an exact solution were measured with, in words and numbers.

use std::collections::BTreeMap;

use serde::Serialize;

use super::breaking;
use crate::study::findings::{count, short};
use crate::study::over_resolved::{LEAST_FALL, OverResolved, RESOLVED, is_level};
use crate::study::{Coverage, Measured};

/// The over-resolved run and how far it is trusted; `run` is missing if none could be verified.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Assessment {
    run: Option<Exact>,
    /// Runs within what the over-resolved run itself may be wrong by.
    unresolved: usize,
    /// Runs that reached their end.
    of: usize,
    /// How the over-resolved runs ended.
    chain: String,
}

#[derive(Debug, Clone, Serialize)]
struct Exact {
    points: f64,
    /// m; `None` (null) where clouds keep their spacing.
    spacing: Option<f64>,
    tolerance: Option<f64>,
    /// Bound of its steps where clouds are the same, s.
    step: Option<f64>,
    /// Estimate of its own error per field, relative to the range.
    uncertainty: BTreeMap<String, f64>,
    /// By how much the error fell from run to run of its chain.
    fall: Option<f64>,
    verdict: String,
    least: f64,
}

impl Assessment {
    /// From the runs of a study, compared.
    pub(super) fn of(runs: &[Measured]) -> Self {
        let own = || {
            runs.iter()
                .filter(|run| run.done() && !is_level(&run.variant))
        };
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let run = OverResolved::among(runs).map(|exact| Exact {
            points: exact.run.points(),
            spacing: finite(exact.run.variant.value("spacing")),
            tolerance: finite(exact.run.variant.value("tolerance")),
            step: finite(exact.run.variant.value(breaking::STEP)),
            verdict: exact.verdict().unwrap_or_default(),
            least: RESOLVED * exact.largest_uncertainty(),
            uncertainty: exact.uncertainty,
            fall: exact.fall,
        });
        Assessment {
            run,
            unresolved: own().filter(|run| !run.resolved()).count(),
            of: own().count(),
            chain: Coverage::of(runs.iter().filter(|run| is_level(&run.variant))).to_string(),
        }
    }

    /// One sentence.
    pub(super) fn line(&self) -> String {
        let Some(run) = &self.run else {
            return format!(
                "There are no errors, as they are distances from an over-resolved run that another one verifies. Of \
                 these, {}.",
                self.chain
            );
        };
        let remedy = match run.fall {
            Some(fall) if fall < LEAST_FALL => {
                " Its chain does not converge well: choose finer clouds with --points, or a smoother case."
            }
            _ => "",
        };
        let resolved = match (self.unresolved, self.of) {
            (_, 0) => "no other run is done".to_owned(),
            (0, of) => format!(
                "the errors of all {of} other runs are at least {}",
                short(run.least)
            ),
            (some, of) => format!(
                "{some} of {of} other runs, with an error below {}, are not resolved by it",
                short(run.least)
            ),
        };
        format!(
            "Errors are distances from an over-resolved run of {} points, which is itself good to: {}; {resolved}.{remedy}",
            count(run.points),
            run.verdict,
        )
    }

    /// How that was found; `None` where it was not.
    pub(super) fn paragraph(&self) -> Option<String> {
        let run = self.run.as_ref()?;
        let cloud = match run.spacing {
            Some(spacing) => format!("a spacing of {} m", short(spacing)),
            None => "the same cloud, so that errors are those in time alone".to_owned(),
        };
        let finer = match (run.tolerance, run.step) {
            (Some(tolerance), _) => format!("a tolerance of {} and {cloud}", short(tolerance)),
            (None, Some(step)) => format!("steps of at most {} s and {cloud}", short(step)),
            (None, None) => cloud,
        };
        let fall = match run.fall {
            Some(fall) if fall < 1.0 => "errors do not fall from one to the next".to_owned(),
            Some(fall) => format!("errors fall by a factor of {fall:.1} from one to the next"),
            None => "two runs cannot tell how errors fall, so that only a factor of 2 is assumed"
                .to_owned(),
        };
        Some(format!(
            "The case has no exact solution. The exact field is that of an over-resolved run: the scheme \
             of highest order with {finer}. Fields are compared at every output at the same places on \
             lines through the whole domain; runs draw no pictures. Coarser runs of the same kind verify \
             it by Richardson's rule: {fall}, which leaves an error of {} in the run that the others are \
             compared with. Runs with less than {RESOLVED:.0} times the largest of these are marked as not \
             resolved, and are in the table of all runs only.",
            run.verdict
        ))
    }
}
