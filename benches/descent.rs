//! What each constant of the walk to equilibrium buys: passes of fracturing cases with one of them changed.
//!
//! Words after `--` keep the constants whose name contains one of them, as in `-- near curvature`.

mod support;

use std::path::Path;

use anyhow::{Context, Result};
use perifrac::plan::DescentSettings;
use perifrac::prelude::*;
use serde_json::{Value, json};

use support::quick;

/// Name of a kind of passes, and its runs: variant, and overrides.
type Group = (
    &'static str,
    &'static [(&'static str, &'static [(&'static str, &'static str)])],
);

const GROUPS: [Group; 4] = [
    (
        "solid",
        &[("notched-tension/smoke", &[]), ("notched-shear/smoke", &[])],
    ),
    (
        "eliminated",
        &[("natural-fractures/smoke", &[("time.end", "0.2 s")])],
    ),
    (
        "in turns",
        &[(
            "natural-fractures/smoke",
            &[("time.end", "0.1 s"), ("scheme.name", "staggered")],
        )],
    ),
    (
        "both fields",
        &[
            ("kgd-toughness/smoke", &[]),
            ("two-cracks/smoke", &[]),
            ("inclined-injection/smoke", &[]),
            ("kgd-leak-off/smoke", &[]),
            ("pressurised-notch/smoke", &[]),
        ],
    ),
];

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let names = GROUPS.map(|(name, _)| name).join(" | ");
    println!(
        "| constant | value | {names} |\n|---|---|{}",
        "---|".repeat(GROUPS.len())
    );
    row("defaults", "", DescentSettings::default());
    let defaults = serde_json::to_value(DescentSettings::default())?;
    for (name, value) in defaults.as_object().context("settings are a table")? {
        if !words.is_empty() && words.iter().all(|word| !name.contains(word.as_str())) {
            continue;
        }
        for other in others(value) {
            let mut changed = defaults.clone();
            changed[name.as_str()] = other.clone();
            let title = format!("`{name}` = {value}");
            row(&title, &other.to_string(), serde_json::from_value(changed)?);
        }
        if quick() {
            break;
        }
    }
    Ok(())
}

/// A quarter and four times a value; half and twice a count.
fn others(value: &Value) -> [Value; 2] {
    match (value.as_u64(), value.as_f64()) {
        (Some(count), _) => [json!(count / 2), json!(2 * count)],
        (_, Some(number)) => [json!(number / 4.0), json!(4.0 * number)],
        _ => [Value::Null, Value::Null],
    }
}

/// Prints the passes of all groups with some settings.
fn row(title: &str, value: &str, settings: DescentSettings) {
    let cells = GROUPS.map(|(_, runs)| {
        let runs = if quick() { &runs[..1] } else { runs };
        runs.iter()
            .map(|(variant, overrides)| passes(variant, overrides, settings))
            .sum::<Result<u64>>()
            .map_or_else(|error| error.to_string(), |passes| passes.to_string())
    });
    println!("| {title} | {value} | {} |", cells.join(" | "));
}

/// Passes of a run, those of rejected steps included.
fn passes(variant: &str, overrides: &[(&str, &str)], settings: DescentSettings) -> Result<u64> {
    let file = Path::new("cases").join(variant).with_extension("toml");
    let mut setup = Setup::file(file)
        .set("output.vtu", "false")
        .set("output.plots", "false");
    for (key, value) in overrides {
        setup = setup.set(key, value);
    }
    let mut plan = setup.plan()?;
    if quick() {
        plan.time.end *= 0.1;
    }
    plan.damage.as_mut().context("a case that breaks")?.descent = settings;
    let (summary, _) = run(&plan, None, &mut (), &Interrupt::default())?;
    let work = &summary.counters;
    Ok(work.newton_iterations + work.coupling_iterations)
}
