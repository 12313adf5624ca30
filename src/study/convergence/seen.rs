//! Orders in time and in space that the runs of a study show.

use std::collections::{BTreeMap, BTreeSet};

use super::orders::{Law, Orders, finish};
use super::{REFERENCE, SPACE, TIME, VERIFICATION};
use crate::study::findings::count;
use crate::study::over_resolved::{OverResolved, SECOND_ORDER};
use crate::study::{Coverage, Measured, Section, profile};

fn of_role(runs: &[Measured], role: f64) -> impl Iterator<Item = &Measured> {
    let plays = move |run: &&Measured| (run.variant.value("role") - role).abs() < 0.5;
    runs.iter().filter(plays)
}

fn done(runs: &[Measured], role: f64) -> impl Iterator<Item = &Measured> {
    of_role(runs, role).filter(|run| run.done())
}

pub(super) fn in_time(runs: &[Measured]) -> Orders {
    let section = Section::new("Orders in time");
    let chain = done(runs, REFERENCE).chain(done(runs, VERIFICATION));
    let exact = done(runs, REFERENCE)
        .next()
        .and_then(|_| OverResolved::of(&chain.collect::<Vec<_>>(), profile::apart, SECOND_ORDER));
    let verdict = exact.as_ref().and_then(OverResolved::verdict);
    let (Some(exact), Some(uncertainties)) = (exact, verdict) else {
        let pair = of_role(runs, REFERENCE).chain(of_role(runs, VERIFICATION));
        return Orders::without(
            section,
            format!(
                "No orders in time: of the over-resolved run and the one that verifies it, {}.",
                Coverage::of(pair)
            ),
        );
    };
    let verified = format!(
        "The over-resolved run ({} steps) is itself good to, by Richardson's rule with a run of half \
         its steps: {uncertainties}.",
        count(exact.run.variant.value("steps")),
    );
    let laws = laws_in_time(runs, &exact);
    let mut orders = Orders {
        section,
        laws,
        remark: Some(verified.clone()),
    };
    orders.section.text = vec![
        format!(
            "Constant steps on one cloud: {}. The error is the distance of the fields along the case's profiles at \
             the end from those of an over-resolved run of the second-order method on the same cloud, so that \
             the error in space does not enter. Runs within ten times the uncertainty of the over-resolved one are \
             left out.",
            Coverage::of(of_role(runs, TIME))
        ),
        verified,
    ];
    let names = ("convergence-time", "Error against step", "step [s]");
    finish(&mut orders, names);
    orders
}

fn laws_in_time(runs: &[Measured], exact: &OverResolved<'_>) -> Vec<Law> {
    let end = exact.run.figure(|run| run.t_end);
    let steps = |run: &Measured| run.variant.value("steps");
    let mut methods: BTreeMap<&str, Vec<&Measured>> = BTreeMap::new();
    for run in of_role(runs, TIME) {
        methods.entry(&run.variant.scheme).or_default().push(run);
    }
    let mut laws = Vec::new();
    for (method, mut runs) in methods {
        runs.retain(|run| run.done());
        runs.sort_by(|a, b| steps(a).total_cmp(&steps(b)));
        let theory = if method.contains("TR-BDF2") { 2.0 } else { 1.0 };
        for (field, _) in &exact.run.first().fields {
            let sure = 10.0 * exact.uncertainty.get(field).copied().unwrap_or(0.0);
            let pairs = runs.iter().filter_map(|run| {
                let distance = *exact.distances(run).get(field)?;
                Some((end / steps(run), distance))
            });
            let pairs = pairs.filter(|pair| pair.1 > sure).collect();
            laws.push(Law::of((method, field), ("time", theory), pairs));
        }
    }
    laws
}

pub(super) fn in_space(runs: &[Measured]) -> Orders {
    let section = Section::new("Orders in space");
    let coverage = Coverage::of(of_role(runs, SPACE));
    let mut runs: Vec<&Measured> = of_role(runs, SPACE).collect();
    if runs.is_empty() {
        let reason = "No orders in space: the case has no exact solution, or the schemes chosen none of second order.";
        return Orders::without(section, reason.to_owned());
    }
    runs.retain(|run| run.done());
    let spacing = |run: &Measured| run.variant.value("spacing");
    runs.sort_by(|a, b| spacing(b).total_cmp(&spacing(a)));
    let fields: BTreeSet<String> = runs
        .iter()
        .flat_map(|run| run.errors().into_keys())
        .collect();
    if fields.is_empty() {
        return Orders::without(section, format!("No orders in space: {coverage}."));
    }
    let method = runs
        .first()
        .map_or(String::new(), |run| run.variant.scheme.clone());
    let law = |field: String| {
        let error = |run: &&Measured| Some((spacing(run), *run.errors().get(&field)?));
        let pairs = runs.iter().filter_map(error).collect();
        Law::of((&method, &field), ("space", 2.0), pairs)
    };
    let mut orders = Orders {
        laws: fields.into_iter().map(law).collect(),
        section,
        remark: None,
    };
    orders.section.text.push(format!(
        "Clouds with halved spacing at a small tolerance of the steps: {coverage}. Errors are root mean square errors \
         against the exact solution, the largest of all outputs, relative to the range."
    ));
    let names = ("convergence-space", "Error against spacing", "spacing [m]");
    finish(&mut orders, names);
    orders
}
