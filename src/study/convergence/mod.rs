//! Orders in space and time, for every field, with their confidence.

mod orders;
mod seen;

use serde_json::json;

use self::orders::Orders;
use self::seen::{in_space, in_time};
use super::{
    Measured, Options, RecordedOutput, ReportContent, Study, StudyCase, StudyError, Variant,
};

/// The study of convergence.
pub(super) struct Convergence;

/// Steps of the runs that are compared.
const STEPS: [u32; 5] = [8, 16, 32, 64, 128];
/// Steps of the run they are compared with, by the second-order method.
const OVER_RESOLVED: u32 = 2048;
/// Steps of the run that verifies the over-resolved one.
const VERIFYING: u32 = 1024;

impl Study for Convergence {
    fn name(&self) -> &'static str {
        "convergence"
    }

    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        if subject.plan.output.profiles.is_empty() {
            return Err(unsuited(
                subject,
                "the orders in time compare profiles; add one under \
                                          [output.profiles]",
            ));
        }
        let mut variants = self.in_time(subject, options)?;
        variants.extend(self.in_space(subject, options));
        Ok(variants)
    }

    fn findings(&self, _: &StudyCase, runs: &[Measured]) -> ReportContent {
        let (time, space) = (in_time(runs), in_space(runs));
        let parts = [time, space];
        ReportContent {
            facts: json!({ "time": parts[0].laws, "space": parts[1].laws }),
            headlines: parts.iter().flat_map(Orders::headlines).collect(),
            sections: parts.into_iter().map(|part| part.section).collect(),
        }
    }
}

fn unsuited(subject: &StudyCase, reason: &str) -> StudyError {
    StudyError::Unsuited {
        study: "the convergence study",
        case: subject.plan.case.clone(),
        reason: reason.to_owned(),
    }
}

impl Convergence {
    /// Constant steps on one cloud, and an over-resolved run: what differs is the error in time alone.
    fn in_time(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        let end = subject.plan.time.end;
        let implicit = subject
            .methods(options)
            .into_iter()
            .filter(|m| m.integrator.is_some());
        // The semi-implicit scheme stops relaxing at a tolerance of its own, which hides the order.
        let methods: Vec<_> = implicit
            .filter(|method| method.scheme != "semi-implicit")
            .collect();
        let Some(best) = methods
            .iter()
            .find(|method| method.integrator == Some("tr-bdf2"))
        else {
            return Err(unsuited(
                subject,
                "it needs an implicit scheme; see --schemes",
            ));
        };
        let grids = subject.grids(options, (60, 1200));
        let grid = grids
            .iter()
            .rev()
            .nth(usize::from(options.quick && grids.len() > 1));
        let run = |method: &super::Method, steps: u32, role: f64| {
            let solvers = subject.solvers(method.scheme, options);
            let mut variant = method
                .variant(solvers.first().map(String::as_str))
                .set(grid.and_then(|grid| grid.overrides.clone()))
                .set([
                    format!("time.step={:?}", end / f64::from(steps)),
                    "output.times=[]".to_owned(),
                    "output.plots=false".to_owned(),
                ])
                .with("steps", f64::from(steps))
                .with("role", role);
            if subject.is_coupled() {
                variant = variant.set(["scheme.coupling_tolerance=1e-11".to_owned()]);
            }
            variant.weight = f64::from(steps);
            variant.kept = RecordedOutput::End;
            variant
        };
        let mut variants = Vec::new();
        let most = if options.quick { 4 } else { 5 };
        for method in &methods {
            variants.extend(STEPS[..most].iter().map(|steps| run(method, *steps, TIME)));
        }
        let halved = if options.quick { 2 } else { 1 };
        variants.push(run(best, VERIFYING / halved, VERIFICATION));
        variants.push(run(best, OVER_RESOLVED / halved, REFERENCE));
        Ok(variants)
    }

    /// Clouds with halved spacing and a tolerance far below the error in space.
    fn in_space(&self, subject: &StudyCase, options: &Options) -> Vec<Variant> {
        if subject.plan.reference.is_none() {
            return Vec::new();
        }
        let most = if options.quick { 1100 } else { 2000 };
        let implicit = subject.methods(options).into_iter();
        let Some(method) = implicit.clone().find(|m| m.integrator == Some("tr-bdf2")) else {
            return Vec::new();
        };
        let solvers = subject.solvers(method.scheme, options);
        let tolerance = if options.quick { "1e-6" } else { "1e-7" };
        let variant = |grid: super::Grid| {
            let mut variant = method
                .variant(solvers.first().map(String::as_str))
                .set(grid.overrides.clone())
                .set([
                    format!("time.tolerance={tolerance}"),
                    "output.plots=false".to_owned(),
                ])
                .with("spacing", grid.spacing)
                .with("role", SPACE);
            variant.weight = 10.0 * grid.points as f64;
            variant
        };
        subject
            .grids(options, (60, most))
            .into_iter()
            .map(variant)
            .collect()
    }
}

/// What a run is for.
const TIME: f64 = 0.0;
const VERIFICATION: f64 = 1.0;
const REFERENCE: f64 = 2.0;
const SPACE: f64 = 3.0;
