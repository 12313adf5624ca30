//! `perifrac study`.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::builder::PossibleValuesParser;

use crate::output::{FolderLock, Manifest};
use crate::run::Interrupt;
use crate::run::Snapshot;
use crate::study::{
    self, Campaign, Coverage, Options, Request, Row, Status, StudyCase, Variant, Watcher,
};

use super::common::SceneArgs;
use super::completions;
use super::exit::{Failure, print, tell_of_kept};
use super::interrupt::handled;
use super::label::label;

/// Arguments of `study`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The report is OUT/report.html; numbers are in OUT/KIND.csv and OUT/report.json, every run in
OUT/log.jsonl. The same command goes on where an interrupted study stopped; a program that was built
anew, or a deleted folder, begins again. Without an exact solution, cost compares runs with an
over-resolved one.

  perifrac study cost terzaghi --quick
  perifrac study contrast two-layer
  perifrac study stability terzaghi
  perifrac study convergence mandel --schemes monolithic")]
pub(super) struct Args {
    /// cost: error against seconds; contrast: 1e-12 to 1e12; stability: where schemes hold;
    /// convergence: orders in space and time
    #[arg(value_parser = PossibleValuesParser::new(study::NAMES))]
    kind: String,
    /// Path of a scene file, or name of a bundled case
    #[arg(add = completions::scenes())]
    scene: String,
    /// Override a key in all runs
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Time schemes to compare [default: all that suit the case]
    #[arg(long, value_name = "A,B", value_delimiter = ',', add = completions::schemes())]
    schemes: Vec<String>,
    /// Linear solvers to compare, separated by blanks [default: a factor and multigrid;
    /// for cost transforms as well, where they can be used]
    #[arg(long, value_name = "A B", value_delimiter = ' ', add = completions::solvers())]
    solvers: Vec<String>,
    /// Points along the longest side [default: halved spacings around the case's own]
    #[arg(long, value_name = "N,M", value_delimiter = ',')]
    points: Vec<usize>,
    /// Runs of each variant, of which the median counts [default: 3 for cost, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    repeat: Option<u32>,
    /// For cost: methods as they come only, without settings that may be cheaper
    #[arg(long)]
    defaults: bool,
    /// Few and small runs, done within a minute
    #[arg(long)]
    quick: bool,
    /// Time after which no further run is started, such as 90s or 10min [default: 9min; quick: 50s]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    budget: Option<Duration>,
    /// Longest single run [default: a tenth of the budget]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    limit: Option<Duration>,
    /// Folder for the report [default: out/study-KIND-CASE, followed by +KEY=VALUE as given]
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: Option<PathBuf>,
    /// Print report.json
    #[arg(long)]
    json: bool,
}

/// Runs a study.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let start = Instant::now();
    let Some(kind) = study::study(&args.kind) else {
        return Err(Failure::Usage(format!(
            "there is no study \"{}\"",
            args.kind
        )));
    };
    let subject = subject(&args.scene, &args.overrides)?;
    let options = Options {
        schemes: args.schemes.clone(),
        solvers: args.solvers.clone(),
        points: args.points.clone(),
        quick: args.quick,
        defaults: args.defaults,
    };
    let variants = kind.variants(&subject, &options)?;
    if variants.is_empty() {
        return Err(Failure::Usage(
            "no scheme that suits the case is left; see --schemes".to_owned(),
        ));
    }
    let quick = if args.quick { "-quick" } else { "" };
    let variant = label(&scene_of(&args.scene, &args.overrides));
    let default = format!("study-{}-{}{variant}{quick}", args.kind, subject.plan.case);
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from("out").join(default));
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::Usage(format!("cannot create {}: {error}", folder.display())))?;
    let _lock = FolderLock::take(&folder)?;
    // Dropped before the lock is.
    let list = Manifest::go_on(&folder)?;
    let interrupt = handled(&Snapshot::default());
    let budget = args.budget.unwrap_or(usual(args).0);
    let limit = args.limit.unwrap_or(budget / 10);
    let repeat = args
        .repeat
        .unwrap_or(if args.quick { 1 } else { kind.repetitions() });
    let mut campaign = Campaign::new(&subject, &folder, repeat, (budget, limit), &interrupt)?;
    let mut console = Console {
        shown: std::io::stderr().is_terminal() && !args.json,
    };
    let (mut runs, complete) = campaign.run(&variants, &mut console)?;
    console.clear();
    if runs.iter().all(|run| run.first().status == Status::NotRun) {
        return Err(nothing(&interrupt));
    }
    kind.compare(&mut runs);
    let request = Request {
        command: typed(&[]),
        longer: longer(args, budget, limit),
        complete,
    };
    let report = study::write_report(&folder, (&*kind, &request), &subject, &runs)?;
    tell_of_kept(&list.kept());
    let page = folder.join("report.html");
    if interrupt.is_raised() {
        return Err(Failure::Interrupted(format!(
            "what is done is in {}; the same command goes on",
            page.display()
        )));
    }
    if args.json {
        return print(&serde_json::to_string_pretty(&report).unwrap_or_default());
    }
    print(&format!(
        "{}{}\n{:.0} s; report in {}",
        headlines(&*kind, &subject, &runs),
        request.state(&Coverage::of(&runs)),
        start.elapsed().as_secs_f64(),
        page.display()
    ))
}

/// The budget of a study, and the longest time of one of its runs, unless the user has other wishes.
fn usual(args: &Args) -> (Duration, Duration) {
    let budget = Duration::from_secs(if args.quick { 50 } else { 540 });
    (budget, budget / 10)
}

/// The command that gives more time: without the user's bounds if they are tighter than the usual ones, else with ten
/// times the budget.
fn longer(args: &Args, budget: Duration, limit: Duration) -> String {
    let bare = typed(&["--budget", "--limit"]);
    let (usual_budget, usual_limit) = usual(args);
    match budget <= usual_budget && limit <= usual_limit && (budget, limit) != usual(args) {
        true => bare,
        false => format!(
            "{bare} --budget {}s",
            (10.0 * budget.as_secs_f64().max(10.0 * limit.as_secs_f64())).ceil()
        ),
    }
}

/// The command as it was typed, with quotes where a shell needs them, without some options and their values.
fn typed(without: &[&str]) -> String {
    let words = std::env::args_os().skip(1);
    command(
        words.map(|word| word.to_string_lossy().into_owned()),
        without,
    )
}

fn command(mut words: impl Iterator<Item = String>, without: &[&str]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+".contains(c);
    let quoted = |word: &str| match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    };
    let mut text = "perifrac".to_owned();
    while let Some(word) = words.next() {
        let (name, value) = word
            .split_once('=')
            .map_or((&*word, None), |(a, b)| (a, Some(b)));
        match without.contains(&name) {
            // Its value is the next word.
            true if value.is_none() => drop(words.next()),
            true => {}
            false => text = format!("{text} {}", quoted(&word)),
        }
    }
    text
}

/// The scene of a study, whose schemes and solvers are its own.
fn scene_of(scene: &str, overrides: &[String]) -> SceneArgs {
    SceneArgs {
        scene: scene.to_owned(),
        overrides: overrides.to_vec(),
        scheme: None,
        solver: None,
        end: None,
    }
}

/// The case of a study.
pub(super) fn subject(scene: &str, overrides: &[String]) -> Result<StudyCase, Failure> {
    let planned = scene_of(scene, overrides).plan()?;
    Ok(StudyCase::new(
        scene,
        &planned.loaded,
        planned.plan,
        overrides.to_vec(),
    ))
}

fn nothing(interrupt: &Interrupt) -> Failure {
    match interrupt.is_raised() {
        true => Failure::Interrupted("before the first run ended".to_owned()),
        false => {
            Failure::Usage("the budget is too small for a single run; see --budget".to_owned())
        }
    }
}

fn headlines(kind: &dyn study::Study, subject: &StudyCase, runs: &[study::Measured]) -> String {
    let lines = kind.findings(subject, runs).headlines;
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// A time such as `90s`, `10min` or `1h`; a bare number is seconds.
fn duration(text: &str) -> Result<Duration, String> {
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic() || c.is_whitespace());
    let factor = match text[digits.len()..].trim() {
        "" | "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        unit => {
            return Err(format!(
                "unknown unit \"{unit}\"; write it like 90s, 10min or 1h"
            ));
        }
    };
    let number: f64 = digits
        .parse()
        .map_err(|_| "write it like 90s, 10min or 1h".to_owned())?;
    Duration::try_from_secs_f64(factor * number).map_err(|error| error.to_string())
}

/// One line that tells how far the study is.
struct Console {
    shown: bool,
}

impl Console {
    fn clear(&self) {
        if self.shown {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}

impl Watcher for Console {
    fn ended(&mut self, variant: &Variant, row: &Row, done: usize, of: usize) {
        if !self.shown {
            return;
        }
        let outcome = match row.status {
            Status::Done => format!("{:.2} s", row.wall_s),
            other => other.name().to_owned(),
        };
        let _ = write!(
            std::io::stderr(),
            "\r\x1b[K{done}/{of} {}: {outcome}",
            variant.method()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_keeps_its_words_and_their_blanks() {
        let words = || {
            let words = "study cost|a b|--quick|--set|x=\"1 m\"|--budget|1s|--limit=2s|--out|it's"
                .split('|');
            words.map(str::to_owned)
        };
        assert_eq!(
            command(words(), &[]),
            r#"perifrac 'study cost' 'a b' --quick --set 'x="1 m"' --budget 1s --limit=2s --out 'it'\''s'"#
        );
        assert_eq!(
            command(words(), &["--budget", "--limit"]),
            r#"perifrac 'study cost' 'a b' --quick --set 'x="1 m"' --out 'it'\''s'"#
        );
    }

    #[test]
    fn times_have_units() {
        assert_eq!(duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("10min"), Ok(Duration::from_secs(600)));
        assert_eq!(duration("1.5 h"), Ok(Duration::from_secs(5400)));
        assert!(duration("10 m").is_err() && duration("soon").is_err() && duration("-1s").is_err());
    }
}
