//! A ladder of hard configurations: each is right, against an exact solution or another scheme, or refused
//! by name. `PERIFRAC_LADDER=all` climbs all of it; without it every seventh rung is taken.

mod rungs;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use perifrac::plan::{Plan, resolve};
use perifrac::run::Summary;
use perifrac::scene;
use perifrac::schemes::State;
use rayon::prelude::*;

use crate::support::try_run;

/// One configuration.
pub struct Rung {
    /// What it is made of: scheme, contrast, step and so on.
    pub name: String,
    /// Row of the table.
    pub family: &'static str,
    /// The scene.
    pub scene: &'static str,
    /// What differs from it.
    pub overrides: Vec<String>,
    /// What it is held against.
    pub judge: Judge,
}

/// What a configuration is held against.
pub enum Judge {
    /// The exact solution that the scene names: field, largest root mean square error over its range, and the
    /// range that counts at least, where the field has all but vanished.
    Exact(&'static str, f64, f64),
    /// The same scene with other overrides, another scheme in the same steps or in short ones: the largest relative
    /// distance of each field.
    Like(Vec<String>, f64),
    /// A displacement along an axis at the point farthest along it, m, and the largest relative error.
    Tip { axis: usize, value: f64, bar: f64 },
}

/// How a configuration ended.
#[derive(Debug, Clone, PartialEq)]
enum Outcome {
    Right,
    Refused(String),
    Wrong(String),
}

fn plan_of(scene: &str, overrides: &[String]) -> Result<Plan, String> {
    let loaded = scene::load_str("ladder", scene, Path::new(""), overrides);
    let loaded = loaded.map_err(|errors| errors.to_string())?;
    resolve(&loaded, "ladder").map_err(|errors| errors.to_string())
}

/// Runs a configuration; what ends it without a name is a panic, and that is wrong.
fn run(scene: &str, overrides: &[String]) -> Result<(Plan, Summary, State), String> {
    let plan = plan_of(scene, overrides)?;
    let (summary, state) = try_run(&plan).map_err(|error| error.to_string())?;
    Ok((plan, summary, state))
}

fn climb(rung: &Rung) -> Outcome {
    let attempt = catch_unwind(AssertUnwindSafe(|| judged(rung)));
    attempt.unwrap_or_else(|_| Outcome::Wrong("panicked".to_owned()))
}

fn judged(rung: &Rung) -> Outcome {
    let (plan, summary, state) = match run(rung.scene, &rung.overrides) {
        Ok(done) => done,
        Err(why) => return Outcome::Refused(why),
    };
    let limits = &plan.audit;
    if summary.balance.mass > limits.mass {
        return Outcome::Wrong(format!("mass {:.1e}", summary.balance.mass));
    }
    match &rung.judge {
        Judge::Exact(field, bar, least) => match summary.errors.get(*field) {
            Some(error) => {
                let found = error.l2 * error.range / error.range.max(*least);
                at_most(found, *bar, &format!("error of {field}"))
            }
            None => Outcome::Wrong(format!("no error of {field}")),
        },
        Judge::Tip { axis, value, bar } => {
            let found = state
                .displacement
                .iter()
                .skip(*axis)
                .step_by(plan.dimension);
            let largest = found.fold(
                0.0_f64,
                |most, u| if u.abs() > most.abs() { *u } else { most },
            );
            at_most((largest - value).abs() / value.abs(), *bar, "displacement")
        }
        Judge::Like(other, bar) => match run(rung.scene, other) {
            Err(why) => Outcome::Wrong(format!("ran, but its peer did not: {why}")),
            Ok((_, _, peer)) => at_most(distance(&state, &peer), *bar, "distance to its peer"),
        },
    }
}

fn at_most(found: f64, bar: f64, what: &str) -> Outcome {
    match found <= bar {
        true => Outcome::Right,
        false => Outcome::Wrong(format!("{what} {found:.1e}, at most {bar:.0e}")),
    }
}

/// Largest relative distance of pressure and displacement, in the Euclidean norm.
fn distance(state: &State, peer: &State) -> f64 {
    let apart = |a: &[f64], b: &[f64]| {
        let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let size = perifrac_solvers::norm2(b);
        perifrac_solvers::norm2(&change) / size.max(f64::MIN_POSITIVE)
    };
    let pressure = apart(&state.pressure, &peer.pressure);
    pressure.max(apart(&state.displacement, &peer.displacement))
}

/// Rungs between two that are taken where not all are.
const STRIDE: usize = 7;

/// Counts of right, refused and wrong configurations.
type Table = BTreeMap<&'static str, [usize; 3]>;

fn printed(table: &Table) -> String {
    let mut lines = vec!["| family | right | refused | wrong |".to_owned()];
    lines.push("|---|---|---|---|".to_owned());
    let row = |(name, [right, refused, wrong]): (&&str, &[usize; 3])| {
        format!("| {name} | {right} | {refused} | {wrong} |")
    };
    lines.extend(table.iter().map(row));
    lines.join("\n")
}

#[test]
fn hard_configurations_are_right_or_refused_by_name() {
    let all = std::env::var_os("PERIFRAC_LADDER").is_some_and(|value| value == "all");
    let rungs = rungs::all();
    assert!(rungs.len() >= 500, "{} rungs", rungs.len());
    let taken: Vec<&Rung> = match all {
        true => rungs.iter().collect(),
        false => rungs.iter().step_by(STRIDE).collect(),
    };
    let ended: Vec<(&Rung, Outcome)> = taken.par_iter().map(|rung| (*rung, climb(rung))).collect();
    let mut table = Table::new();
    let mut wrong = Vec::new();
    for (rung, outcome) in &ended {
        let row = table.entry(rung.family).or_default();
        match outcome {
            Outcome::Right => row[0] += 1,
            Outcome::Refused(why) => {
                row[1] += 1;
                println!(
                    "refused {}: {}",
                    rung.name,
                    why.lines().next().unwrap_or(why)
                );
                assert!(why.len() > 20, "{}: a refusal says why: {why}", rung.name);
            }
            Outcome::Wrong(why) => {
                row[2] += 1;
                wrong.push(format!(
                    "{}: {why} [{}]",
                    rung.name,
                    rung.overrides.join(" ")
                ));
            }
        }
    }
    println!("{}", printed(&table));
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    let right: usize = table.values().map(|row| row[0]).sum();
    assert!(
        2 * right > ended.len(),
        "most configurations run: {right} of {}",
        ended.len()
    );
}
