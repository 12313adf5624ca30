//! `perifrac run`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use perifrac_solvers::{Communicator, Interrupt};

use crate::output::OutputError;
use crate::run::{Checkpoint, CheckpointRule, Job, Settings, Snapshot, Summary, Writer, run_job};
use crate::scene::units;

use super::common::{Asked, Planned, SceneArgs};
use super::exit::{Failure, print, tell_of_kept};
use super::interrupt::handled;
use super::label::label;
use super::processes::Processes;
use super::progress::Console;
use super::{memory, stages, threads};

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder for the results; the next run there removes what this one writes and nothing else
    /// [default: out/CASE, followed by +SCHEME, +SOLVER, +KEY=VALUE and +end=TIME as given]
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

/// How a run is done, whether it begins or goes on.
#[derive(Debug, clap::Args)]
pub(super) struct How {
    /// Number of threads of each process [default: all processors, shared out]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Memory that the run may need, such as 8GiB [default: what is free]
    #[arg(long, value_name = "SIZE", value_parser = memory::size)]
    memory: Option<u64>,
    /// Wall time between two checkpoints, such as 5min, or off; one is also written when a run is
    /// interrupted, before it fails, and at its end
    #[arg(long, value_name = "TIME", default_value = "10min", value_parser = wall_time)]
    checkpoint_every: WallTime,
    /// Write a checkpoint at every output as well
    #[arg(long)]
    checkpoint_at_outputs: bool,
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

/// A wall time, or none.
#[derive(Debug, Clone, Copy)]
struct WallTime(Option<Duration>);

fn wall_time(text: &str) -> Result<WallTime, String> {
    if text == "off" {
        return Ok(WallTime(None));
    }
    let wanted = "give a time with its unit, such as 5min or 30s, or off";
    let (seconds, dimension) = units::parse(text).map_err(|error| format!("{error}; {wanted}"))?;
    let is_time = dimension == Some(units::Exponents::new(0, 0, 1));
    match is_time && seconds > 0.0 {
        true => Duration::try_from_secs_f64(seconds)
            .map(|every| WallTime(Some(every)))
            .map_err(|error| format!("{error}; {wanted}")),
        false => Err(wanted.to_owned()),
    }
}

impl How {
    fn settings(&self) -> Settings {
        Settings {
            reject_every: self.reject_every,
            checkpoints: self.checkpoint_every.0.map(|every| CheckpointRule {
                every,
                at_outputs: self.checkpoint_at_outputs,
            }),
        }
    }

    /// Takes the threads and sees whether the memory suffices, before anything is written.
    ///
    /// # Errors
    /// [`Failure::Usage`], [`Failure::Memory`], or what the scene is refused for.
    pub(super) fn prepare(&self, asked: &Asked) -> Result<(), Failure> {
        threads::set(self.threads, Processes::started().threads())?;
        for (_, planned) in asked.all() {
            memory::check(&planned.explain()?.memory, self.memory)?;
        }
        Ok(())
    }

    /// Whether the summary is printed as JSON.
    pub(super) fn is_json(&self) -> bool {
        self.json
    }

    /// Whether nothing but errors is told.
    pub(super) fn is_quiet(&self) -> bool {
        self.quiet
    }
}

/// Runs a scene.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let asked = args.scene.ask()?;
    args.how.prepare(&asked)?;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| default_folder(&args.scene, asked.case()));
    check_folder(&folder)?;
    match asked {
        Asked::One(planned) => {
            let mut desk = Desk::new(&args.how)?;
            let writer = desk.writer(&folder, &planned)?;
            let summary = desk.carry_out(&planned, writer, None)?;
            desk.tell(&summary, &folder)
        }
        Asked::Stages(stages) => stages::run(stages, &args.how, &folder),
    }
}

/// What runs of one command share: processes, and what a signal does.
pub(super) struct Desk<'a> {
    how: &'a How,
    /// Whether it goes on with what was begun.
    resumes: bool,
    team: Option<Arc<dyn Communicator>>,
    interrupt: Interrupt,
    snapshot: Snapshot,
}

impl<'a> Desk<'a> {
    /// Brings the processes together and listens to signals.
    ///
    /// # Errors
    /// [`Failure::Usage`] if processes cannot be brought together.
    pub(super) fn new(how: &'a How) -> Result<Self, Failure> {
        let team = Processes::started().team()?;
        let snapshot = Snapshot::default();
        Ok(Desk {
            how,
            resumes: false,
            team,
            interrupt: handled(&snapshot),
            snapshot,
        })
    }

    /// The writer of a run that begins.
    ///
    /// # Errors
    /// Those of [`Writer::create`].
    pub(super) fn writer(&self, folder: &Path, planned: &Planned) -> Result<Writer, Failure> {
        let resolved = planned.loaded.resolved_toml();
        Ok(match Processes::started().leads() {
            true => Writer::create(folder, &resolved)?,
            false => Writer::follow(folder, &resolved),
        })
    }

    /// The writer of a run that goes on.
    ///
    /// # Errors
    /// Those of [`Writer::go_on`].
    pub(super) fn resumed_writer(&self, folder: &Path, resolved: &str) -> Result<Writer, Failure> {
        Ok(match Processes::started().leads() {
            true => Writer::go_on(folder, resolved)?,
            false => Writer::follow(folder, resolved),
        })
    }

    /// Goes on with what was begun.
    pub(super) fn resume(self) -> Self {
        Desk {
            resumes: true,
            ..self
        }
    }

    /// Whether it goes on with what was begun.
    pub(super) fn resumes(&self) -> bool {
        self.resumes
    }

    /// Whether nothing but errors is told.
    pub(super) fn is_quiet(&self) -> bool {
        self.how.quiet
    }

    /// Runs a plan from its beginning or from a checkpoint.
    ///
    /// # Errors
    /// [`Failure`] of the run.
    pub(super) fn carry_out(
        &mut self,
        planned: &Planned,
        mut writer: Writer,
        from: Option<Checkpoint>,
    ) -> Result<Summary, Failure> {
        let leads = Processes::started().leads();
        let mut console = Console::new(self.how.quiet || !leads);
        let (plan, base) = (&planned.plan, &planned.loaded.base_dir);
        let here = if base.as_os_str().is_empty() {
            Path::new(".")
        } else {
            base
        };
        let job = Job {
            team: self.team.as_ref(),
            writer: Some(&mut writer),
            observer: &mut console,
            interrupt: &self.interrupt,
            settings: self.how.settings(),
            base: here.canonicalize().unwrap_or_else(|_| base.clone()),
            from,
            snapshot: self.snapshot.clone(),
        };
        let result = run_job(plan, job);
        console.finish();
        tell_of_kept(&writer.kept());
        let told = |error| planned.failure(error).with_way_on(writer.folder());
        let (summary, _) = result.map_err(told)?;
        Ok(summary)
    }

    /// Tells how a run went.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be printed.
    pub(super) fn tell(&self, summary: &Summary, folder: &Path) -> Result<(), Failure> {
        if !Processes::started().leads() {
            return Ok(());
        }
        if self.how.json {
            let text = serde_json::to_string(summary).unwrap_or_default();
            return print(&text);
        }
        if self.how.quiet {
            return Ok(());
        }
        print(&format!(
            "{}results in {}",
            describe(summary),
            folder.display()
        ))
    }
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
        let summary = crate::run::run(&plan, None, &mut (), &Interrupt::default());
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
