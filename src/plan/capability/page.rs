//! The table as a page: `perifrac schemes`, and `docs/combinations.md`.

use perifrac_solvers::BACKENDS;

use super::feature::{Feature, Features};
use super::method::System;
use super::rules::{RULES, Rule};
use super::{SchemeName, broken};

const HEAD: &str = "\
# What can be combined

This page is printed by `perifrac schemes`, from the table that `check`, `plan` and `run` ask.

## Effects and schemes

A row asks for one thing, together with what it cannot be without (second column). A cell says `yes`, or
gives the numbers of the rules below that refuse it.

";

const RULES_HEAD: &str = "
## Rules

What is asked for together, for some schemes only where they are named, and why it is refused; then what to
do.

";

const SOLVERS_HEAD: &str = "
## Solvers

Flow and mechanics are positive definite systems; flow and mechanics in one are a quasi-definite system,
which `implicit` and `monolithic` solve. Any solver goes with a scheme that solves no system. `perifrac
solvers` lists options and preconditioners.

";

/// Schemes in the order of the columns.
const SCHEMES: [SchemeName; 5] = [
    SchemeName::Explicit,
    SchemeName::SemiImplicit,
    SchemeName::Implicit,
    SchemeName::Staggered,
    SchemeName::Monolithic,
];

/// The page, in Markdown.
pub fn page() -> String {
    let mut text = HEAD.to_owned();
    text += &table(&matrix());
    text += RULES_HEAD;
    for (number, rule) in (1..).zip(RULES) {
        text += &format!("{number}. {}\n", told(rule));
    }
    text += SOLVERS_HEAD;
    text += &table(&solvers());
    text
}

/// One row for each feature, under a heading.
fn matrix() -> Vec<Vec<String>> {
    let heading = ["asked for", "with"].into_iter();
    let heading = heading.chain(SCHEMES.map(SchemeName::name));
    let mut rows = vec![heading.map(str::to_owned).collect()];
    rows.extend(Feature::ALL.map(row));
    rows
}

fn row(feature: Feature) -> Vec<String> {
    let all = completed(Features::from([feature]));
    let others = all.iter().filter(|other| **other != feature);
    let others: Vec<String> = others.map(|other| quoted(*other)).collect();
    let cells = SCHEMES.map(|scheme| {
        let numbers: Vec<String> = broken(scheme, &all).map(number).collect();
        match numbers.is_empty() {
            true => "yes".to_owned(),
            false => numbers.join(", "),
        }
    });
    let start = [quoted(feature), others.join(" ")];
    start.into_iter().chain(cells).collect()
}

fn number(rule: &Rule) -> String {
    let same = |other: &Rule| std::ptr::eq(other, rule);
    let place = RULES.iter().position(same).unwrap_or_default();
    (place + 1).to_string()
}

/// Features with all that they cannot be without: what they are options of, and the first thing whose
/// absence a rule for all schemes refuses.
pub fn completed(mut features: Features) -> Features {
    loop {
        let parent = (features.iter())
            .filter(|own| !own.part_of().iter().any(|part| features.contains(part)))
            .find_map(|own| own.part_of().first());
        let needed = || {
            let needs: Vec<&Rule> = broken(SchemeName::Implicit, &features)
                .filter(|rule| rule.schemes.is_empty() && rule.is_need())
                .collect();
            // What its own features need comes before what every scene needs.
            let own = needs.iter().find(|rule| !rule.with.is_empty());
            own.or(needs.first()).and_then(|rule| rule.without.first())
        };
        match parent.or_else(needed) {
            Some(missing) => drop(features.insert(*missing)),
            None => return features,
        }
    }
}

/// A rule in one line.
fn told(rule: &Rule) -> String {
    let mut text = Vec::new();
    if !rule.with.is_empty() {
        text.push(listed(rule.with, " + "));
    }
    if !rule.without.is_empty() {
        text.push(format!("without {}", listed(rule.without, ", ")));
    }
    let names: Vec<&str> = rule.schemes.iter().map(|scheme| scheme.name()).collect();
    if !names.is_empty() {
        text.push(format!("with the scheme {}", names.join(" or ")));
    }
    let between = match rule.reason.contains("`{scheme}`") {
        true => "` or `",
        false => " or ",
    };
    let reason = rule.reason_for(&names.join(between));
    format!("{}: {reason}; {}.", text.join(" "), rule.remedy)
}

fn listed(features: &[Feature], between: &str) -> String {
    let names: Vec<String> = features.iter().map(|own| quoted(*own)).collect();
    names.join(between)
}

fn quoted(feature: Feature) -> String {
    format!("`{}`", feature.name())
}

fn solvers() -> Vec<Vec<String>> {
    let heading = [
        "solver",
        "flow",
        "mechanics",
        "monolithic",
        "several processes",
    ];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    let word = |takes: bool| if takes { "yes" } else { "no" }.to_owned();
    for backend in BACKENDS {
        let systems = [System::Flow, System::Mechanics, System::Monolithic];
        let takes = systems.map(|system| word(backend.takes(system.symmetry(), 1).is_ok()));
        let name = [format!("`{}`", backend.name)];
        let several = [word(backend.distributed)];
        rows.push(name.into_iter().chain(takes).chain(several).collect());
    }
    rows
}

/// A Markdown table with columns of one width each; the first row is the heading.
fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let widths: Vec<usize> = (0..columns)
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max())
        .map(Option::unwrap_or_default)
        .collect();
    let line = |row: &[String]| {
        let cells = row.iter().zip(&widths);
        let cells: Vec<String> = cells
            .map(|(cell, width)| format!("{cell:width$}"))
            .collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule: Vec<String> = widths.iter().map(|width| "-".repeat(*width)).collect();
    let mut lines = rows.iter().map(|row| line(row));
    let heading = lines.next().unwrap_or_default();
    heading + &line(&rule) + &lines.collect::<String>()
}
