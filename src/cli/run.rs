//! `perifrac run`.

use std::path::{Path, PathBuf};

use crate::output::OutputError;
use crate::run::{Job, Settings, Summary, Writer, run_job};

use super::common::SceneArgs;
use super::exit::{Failure, print, tell_of_kept};
use super::interrupt::handled;
use super::label::label;
use super::processes::Processes;
use super::progress::Console;
use super::{memory, threads};

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder for the results; the next run there removes what this one writes and nothing else
    /// [default: out/CASE, followed by +SCHEME, +SOLVER and +KEY=VALUE as given]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads of each process [default: all processors, shared out]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Memory that the run may need, such as 8GiB [default: what is free]
    #[arg(long, value_name = "SIZE", value_parser = memory::size)]
    memory: Option<u64>,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    /// Print nothing but errors and, with --json, the summary
    #[arg(long, short)]
    quiet: bool,
    /// Do every Nth step twice and throw the first trial away, which must change nothing
    #[arg(long, value_name = "N", hide = true, value_parser = clap::value_parser!(u64).range(1..))]
    reject_every: Option<u64>,
}

impl Args {
    fn settings(&self) -> Settings {
        Settings {
            reject_every: self.reject_every,
        }
    }
}

/// Runs a scene.
pub fn run(args: &Args) -> Result<(), Failure> {
    let processes = Processes::started();
    let planned = args.scene.plan()?;
    threads::set(args.threads, processes.threads())?;
    memory::check(&planned.explain()?.memory, args.memory)?;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| default_folder(&args.scene, &planned.plan.case));
    check_folder(&folder)?;
    let team = processes.team()?;
    let resolved = planned.loaded.resolved_toml();
    let mut writer = match processes.leads() {
        true => Writer::create(&folder, &resolved)?,
        false => Writer::follow(&folder, &resolved),
    };
    let interrupt = handled();
    let mut console = Console::new(args.quiet || !processes.leads());
    let plan = &planned.plan;
    let job = Job {
        team: team.as_ref(),
        writer: Some(&mut writer),
        observer: &mut console,
        interrupt: &interrupt,
        settings: args.settings(),
    };
    let result = match plan.dimension {
        2 => run_job::<2>(plan, job),
        _ => run_job::<3>(plan, job),
    };
    console.finish();
    tell_of_kept(&writer.kept());
    let (summary, _) = result.map_err(|error| planned.failure(error))?;
    if !processes.leads() {
        return Ok(());
    }
    if args.json {
        let text = serde_json::to_string(&summary).unwrap_or_default();
        return print(&text);
    }
    if args.quiet {
        return Ok(());
    }
    print(&format!(
        "{}results in {}",
        describe(&summary),
        writer.folder().display()
    ))
}

/// A folder of its own for every variant of a case.
fn default_folder(scene: &SceneArgs, case: &str) -> PathBuf {
    PathBuf::from("out").join(format!("{case}{}", label(scene)))
}

/// Refuses a folder whose place, or the way to it, is taken by a file.
fn check_folder(folder: &Path) -> Result<(), Failure> {
    match folder.ancestors().find(|path| path.is_file()) {
        None => Ok(()),
        Some(file) => Err(OutputError::Unsupported {
            path: file.to_owned(),
            what: "the place for results".to_owned(),
            found: "a file".to_owned(),
            allowed: "a folder; choose another one with --out",
        }
        .into()),
    }
}

fn describe(summary: &Summary) -> String {
    let mut text = format!(
        "{}: {} points{}, {} by {}, {} steps ({} rejected), {:.2} s\n",
        summary.case,
        summary.points,
        match summary.processes {
            1 => String::new(),
            several => format!(" on {several} processes"),
        },
        summary.scheme,
        summary.solver.as_deref().unwrap_or("no solver"),
        summary.steps,
        summary.rejected,
        summary.wall_s
    );
    for (field, error) in &summary.errors {
        text += &format!(
            "  error of {field}: {:.2e} (root mean square), {:.2e} (largest), relative to the range\n",
            error.l2, error.max
        );
    }
    text += &describe_mechanics(summary);
    if summary.pressure_range.is_some() {
        text += &format!(
            "  mass balance: {:.1e} of the turnover\n",
            summary.balance.mass
        );
    }
    text
}

/// Coupling and balance of forces, if there are any.
fn describe_mechanics(summary: &Summary) -> String {
    let mut text = String::new();
    if let Some(coupling) = &summary.coupling {
        text += &format!("  coupling: strength {:.2e}", coupling.strength);
        if coupling.passes > 0 {
            text += &format!(", {} passes between flow and mechanics", coupling.passes);
        }
        text.push('\n');
    }
    let balance = &summary.balance;
    if let Some(momentum) = balance.momentum {
        text += &format!("  forces out of balance: {momentum:.1e} of all forces\n");
    }
    if let (Some(kinetic), Some(error)) = (balance.kinetic, balance.energy_error) {
        text += &format!(
            "  kinetic energy: {kinetic:.3e} J, energy out of balance: {error:.1e} of the largest so far\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Interrupt;
    use crate::{cases, plan, scene};

    fn described(case: &str, overrides: &[&str]) -> String {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let text = cases::find(case).unwrap().scene;
        let loaded = scene::load_str(case, text, Path::new(""), &overrides).unwrap();
        let plan = plan::resolve(&loaded, case).unwrap();
        let summary = crate::run::run::<2>(&plan, None, &mut (), &Interrupt::default());
        describe(&summary.unwrap().0)
    }

    /// Starts of the lines after the first.
    fn lines(text: &str) -> Vec<&str> {
        let start = |line: &'_ str| -> usize { line.find(':').unwrap() };
        text.lines()
            .skip(1)
            .map(|line| line[..start(line)].trim())
            .collect()
    }

    #[test]
    fn a_scene_of_flow_is_told_without_forces() {
        let text = described("two-layer", &["geometry.points=[20, 5]"]);
        assert!(lines(&text).contains(&"mass balance"), "{text}");
        assert!(
            !text.contains("forces") && !text.contains("coupling"),
            "{text}"
        );
    }

    /// Strength by hand: α²/(s(λ + 2μ)) = 0.25/(1.65e-10 · 1e8) = 15.15.
    #[test]
    fn a_coupled_scene_is_told_with_its_coupling_and_forces() {
        let coarse = ["geometry.spacing=0.5", "scheme.name=staggered"];
        let text = described("terzaghi", &coarse);
        let expected = [
            "error of displacement",
            "error of pressure",
            "coupling",
            "forces out of balance",
            "mass balance",
        ];
        assert_eq!(lines(&text), expected, "{text}");
        assert!(text.contains("strength 1.52e1,"), "{text}");
        assert!(
            text.contains(" passes between flow and mechanics\n"),
            "{text}"
        );
    }
}
