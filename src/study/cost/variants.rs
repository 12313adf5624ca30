//! The runs of the study of cost.

use super::settings::{Setting, least_tolerance};
use super::{STEADY, breaking, steady_only};
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
    let mut variants: Vec<Variant> = grids
        .iter()
        .flat_map(|grid| on_grid(subject, options, grid))
        .collect();
    if steady_only(subject) && options.wants_scheme("implicit") {
        variants.extend(steady(subject, options, &grids));
    }
    let finest = grids.iter().max_by_key(|grid| grid.along);
    if let (true, Some(finest), false) = (compared, finest, variants.is_empty()) {
        let least = least_tolerance(options);
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

/// Every method with every setting by its solvers on one cloud.
fn on_grid(subject: &StudyCase, options: &Options, grid: &Grid) -> Vec<Variant> {
    let mut variants = Vec::new();
    for method in methods(subject, options) {
        let solvers = subject.fastest_solvers(method.scheme, options);
        let main = method.integrator == Some("tr-bdf2") && method.scheme != "semi-implicit";
        let solvers = if main { &solvers[..] } else { &solvers[..1] };
        let settings = Setting::of(&method, subject, options);
        for (solver, setting) in solvers
            .iter()
            .flat_map(|solver| settings.iter().map(move |setting| (solver, setting)))
        {
            let variant = method
                .variant(Some(solver))
                .set(grid.overrides.clone())
                .with("spacing", grid.spacing);
            let runs = setting.runs(&variant, subject.plan.time.end, options);
            variants.extend(runs.into_iter().map(|(variant, longer)| Variant {
                weight: weight(method.scheme, grid.points, longer),
                ..variant
            }));
        }
    }
    variants
}

/// Those that suit the case, and the explicit one as printed where its relaxation is another than the default.
fn methods(subject: &StudyCase, options: &Options) -> Vec<Method> {
    let mut methods = subject.methods(options);
    let explicit = methods.iter().find(|method| method.scheme == "explicit");
    let printed = explicit.map(|method| Method {
        printed: true,
        ..*method
    });
    methods.extend(printed.filter(|_| subject.is_coupled()));
    methods
}

/// The steady state in one solve, by every solver on every cloud.
fn steady(subject: &StudyCase, options: &Options, grids: &[Grid]) -> Vec<Variant> {
    let method = Method::new("implicit", None);
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

/// Cheap first: points, runs that take `longer` than others on the same cloud, and the many steps of methods without a
/// linear system.
pub(super) fn weight(scheme: &str, points: usize, longer: f64) -> f64 {
    let points = points as f64;
    match scheme {
        "explicit" => points * points,
        "semi-implicit" => 30.0 * points * longer,
        _ => 10.0 * points * longer,
    }
}
