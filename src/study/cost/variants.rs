//! The runs of the study of cost.

use super::{STEADY, breaking, steady_only};
use crate::plan::TimeMode;
use crate::study::{
    Grid, Method, Options, RecordedOutput, StudyCase, StudyError, Variant, over_resolved,
};

/// Fewest and most points of the clouds.
type Range = (usize, usize);

/// Every method on every cloud at every tolerance; without an exact solution, a chain of over-resolved
/// runs as well.
pub(super) fn variants(subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
    if let Some(damage) = &subject.plan.damage {
        let lines = lines(subject)?;
        let variants = breaking::variants(subject, damage, options);
        return Ok(comparable(variants, &lines));
    }
    let compared = subject.plan.reference.is_none();
    let lines = match compared {
        true => lines(subject)?,
        false => Vec::new(),
    };
    let grids = subject.grids(options, range(subject, options));
    let tolerances: &[f64] = match options.quick {
        true => &[1e-2, 1e-3],
        false => &[1e-2, 1e-3, 1e-4],
    };
    let mut variants: Vec<Variant> = grids
        .iter()
        .flat_map(|grid| on_grid(subject, options, grid, tolerances))
        .collect();
    if steady_only(subject) && options.wants_scheme("implicit") {
        variants.extend(steady(subject, options, &grids));
    }
    let finest = grids.iter().max_by_key(|grid| grid.along);
    if let (true, Some(finest), false) = (compared, finest, variants.is_empty()) {
        let least = tolerances.iter().copied().fold(f64::INFINITY, f64::min);
        variants.extend(over_resolved::chain(subject, finest.along, least));
        variants = comparable(variants, &lines);
    }
    Ok(variants)
}

/// Variants that keep their fields along lines, to be compared with each other.
fn comparable(variants: Vec<Variant>, lines: &[String]) -> Vec<Variant> {
    let kept = |variant: Variant| Variant {
        kept: RecordedOutput::Outputs,
        ..variant
            .set(lines.to_vec())
            .set(["output.plots=false".to_owned()])
    };
    variants.into_iter().map(kept).collect()
}

/// Overrides that record what runs are compared by.
fn lines(subject: &StudyCase) -> Result<Vec<String>, StudyError> {
    let unsuited = |reason: &str| StudyError::Unsuited {
        study: "the cost study",
        case: subject.plan.case.clone(),
        reason: reason.to_owned(),
    };
    if subject.plan.flow.is_none() {
        return Err(unsuited(
            "it compares time schemes of flow, which the scene has not; choose a case with [flow]",
        ));
    }
    over_resolved::lines(&subject.plan).ok_or_else(|| {
        unsuited(
            "without an exact solution it compares runs at places across the domain, whose planes are \
             not known; give geometry.bounds",
        )
    })
}

/// Clouds are smaller where over-resolved runs have four times their points in every direction.
fn range(subject: &StudyCase, options: &Options) -> Range {
    if subject.plan.reference.is_some() {
        return match (subject.is_coupled(), options.quick) {
            (true, false) => (60, 6000),
            (true, true) => (60, 400),
            (false, false) => (100, 40_000),
            (false, true) => (100, 2500),
        };
    }
    let most = match (subject.is_coupled(), options.quick) {
        (_, false) => 1000,
        (true, true) => 250,
        (false, true) => 400,
    };
    (40, most)
}

fn on_grid(
    subject: &StudyCase,
    options: &Options,
    grid: &Grid,
    tolerances: &[f64],
) -> Vec<Variant> {
    let mut variants = Vec::new();
    for method in subject.methods(options) {
        let solvers = subject.fastest_solvers(method.scheme, options);
        let main = method.integrator == Some("tr-bdf2") && method.scheme != "semi-implicit";
        let solvers = if main { &solvers[..] } else { &solvers[..1] };
        let adaptive = method.integrator.is_some() && subject.plan.time.mode == TimeMode::Transient;
        let tolerances = if adaptive { tolerances } else { &[f64::NAN] };
        for (solver, &tolerance) in solvers
            .iter()
            .flat_map(|s| tolerances.iter().map(move |t| (s, t)))
        {
            let mut variant = method
                .variant(Some(solver))
                .set(grid.overrides.clone())
                .with("spacing", grid.spacing);
            if adaptive {
                variant = variant
                    .set([format!("time.tolerance={tolerance:?}")])
                    .with("tolerance", tolerance);
            }
            variant.weight = weight(method.scheme, grid.points, tolerance);
            variants.push(variant);
        }
    }
    variants
}

/// The steady state in one solve, by every solver on every cloud.
fn steady(subject: &StudyCase, options: &Options, grids: &[Grid]) -> Vec<Variant> {
    let method = Method {
        scheme: "implicit",
        integrator: None,
    };
    let solvers = subject.fastest_solvers(method.scheme, options);
    let pairs = grids
        .iter()
        .flat_map(|grid| solvers.iter().map(move |solver| (grid, solver)));
    pairs
        .map(|(grid, solver)| {
            let mut variant = method
                .variant(Some(solver))
                .set(grid.overrides.clone())
                .set(["time.mode=\"steady\"".to_owned()])
                .with("spacing", grid.spacing);
            variant.scheme = STEADY.to_owned();
            variant.weight = grid.points as f64;
            variant
        })
        .collect()
}

/// Cheap first: points, tighter tolerances, and the many steps of methods without a linear system.
pub(super) fn weight(scheme: &str, points: usize, tolerance: f64) -> f64 {
    let points = points as f64;
    let steps = match tolerance.is_finite() {
        true => (1e-2 / tolerance).powf(0.3),
        false => 1.0,
    };
    match scheme {
        "explicit" => points * points,
        "semi-implicit" => 30.0 * points * steps,
        _ => 10.0 * points * steps,
    }
}
