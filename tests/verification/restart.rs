//! Runs that are stopped and go on, and steps that are thrown away: both must change no bit of any file.

use std::path::{Path, PathBuf};

use perifrac::cases;
use perifrac::plan::{Plan, resolve};
use perifrac::run::{
    Checkpoint, CheckpointRule, Interrupt, Job, Observer, Progress, RunError, Settings, Snapshot,
    Summary, Writer, run_job,
};
use perifrac::scene::{self, LoadedScene};

use crate::dynamics::BAR;

/// Small forms of bundled cases: all schemes, effects, kinds of clouds, integrators and kinds of solvers there are.
const CASES: &[(&str, &[&str])] = &[
    ("five-spot", &["geometry.points=[24, 24]"]),
    (
        "five-spot",
        &[
            "geometry.points=[24, 24]",
            "time.integrator=backward-euler",
            "solver.name=faer-cg:preconditioner=amg",
        ],
    ),
    (
        "five-spot",
        &[
            "geometry.points=[24, 24]",
            "solver.name=faer-cg:preconditioner=stale",
        ],
    ),
    (
        "five-spot",
        &["geometry.points=[16, 16]", "scheme.name=explicit"],
    ),
    ("two-layer", &["geometry.points=[40, 5]"]),
    ("reservoir-3d", &["geometry.points=[15, 15, 6]"]),
    ("terzaghi", &["geometry.spacing=0.25"]),
    (
        "terzaghi",
        &["geometry.spacing=0.5", "scheme.name=staggered"],
    ),
    (
        "terzaghi",
        &[
            "geometry.spacing=0.5",
            "scheme.name=semi-implicit",
            "time.end=20 s",
        ],
    ),
    (
        "terzaghi",
        &[
            "geometry.spacing=0.5",
            "scheme.name=explicit",
            "time.end=20 s",
        ],
    ),
    (
        "terzaghi",
        &[
            "geometry.spacing=0.25",
            "solver.name=fgmres:preconditioner=schur",
        ],
    ),
    (
        "terzaghi-graded",
        &["geometry.spacing=0.2", "time.end=0.1 s"],
    ),
    ("column-3d", &["geometry.spacing=0.2", "time.end=2 s"]),
    ("mandel", &[]),
    ("sneddon", &["geometry.spacing=0.02"]),
    ("manufactured", &[]),
    ("notched-tension/smoke", &["geometry.points=[20, 20]"]),
    ("kgd-viscosity/smoke", &["time.end=0.1 s"]),
    (
        "notched-tension/paper",
        &[
            "geometry.points=[30, 30]",
            "damage.length_scale=0.1333333 mm",
        ],
    ),
    (
        "notched-tension/paper",
        &[
            "geometry.points=[30, 30]",
            "damage.length_scale=0.1333333 mm",
            "scheme.name=explicit",
            "time.end=2000 s",
        ],
    ),
    (
        "pressurised-notch/smoke",
        &["time.end=440 s", "output.times=[]"],
    ),
    (
        "natural-fractures/smoke",
        &["time.end=0.03 s", "output.vtu=true"],
    ),
    (
        "natural-fractures/smoke",
        &["scheme.name=staggered", "time.end=0.01 s"],
    ),
    (
        "natural-fractures/smoke",
        &["scheme.name=semi-implicit", "time.end=5 ms"],
    ),
    (
        "natural-fractures/smoke",
        &["scheme.name=explicit", "time.end=0.03 ms"],
    ),
    ("penny-3d/smoke", &[]),
    // Dynamics, which no bundled case has.
    (
        BAR,
        &["geometry.points=[16, 4]", "time.end=3", "output.every=1"],
    ),
    (
        BAR,
        &[
            "geometry.points=[16, 4]",
            "time.end=3",
            "output.every=1",
            "materials.rock.permeability=1e-3",
            "materials.rock.storage=10",
            "materials.rock.biot_coefficient=1",
            "fluid.viscosity=1",
            "flow.boundary.right.pressure=0",
            "coupling={}",
            "scheme.name=semi-implicit",
        ],
    ),
    // Steps of the solid as printed.
    (
        "terzaghi",
        &[
            "geometry.spacing=0.5",
            "scheme.name=explicit",
            "scheme.solid=verlet",
            "time.end=2 s",
            "output.times=[1]",
        ],
    ),
    (
        "terzaghi",
        &[
            "geometry.spacing=0.5",
            "scheme.name=explicit",
            "scheme.adr_damping=local",
            "time.end=20 s",
        ],
    ),
    // A well that goes over to its limit and back.
    ("well-test/limited", &["geometry.points=[24, 24]"]),
    (
        "well-test/limited",
        &["geometry.points=[24, 24]", "scheme.name=explicit"],
    ),
];

fn loaded((case, overrides): (&str, &[&str])) -> LoadedScene {
    if case == BAR {
        let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
        let loaded = scene::load_str("bar", BAR, Path::new(""), &overrides);
        return loaded.unwrap_or_else(|errors| panic!("{errors}"));
    }
    let (name, variant) = match case.split_once('/') {
        Some((name, variant)) => (name, Some(variant)),
        None => (case, None),
    };
    let layers = cases::find(name).unwrap().layers(variant).unwrap();
    let layers: Vec<(&str, &str)> = layers.iter().map(|(n, text)| (&**n, *text)).collect();
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    scene::load_layers(&layers, Path::new(""), &overrides)
        .unwrap_or_else(|errors| panic!("{case} {overrides:?}: {errors}"))
}

/// Raises the flag after so many steps.
struct StopsAfter<'a>(u64, &'a Interrupt);

impl Observer for StopsAfter<'_> {
    fn step(&mut self, progress: &Progress) {
        if progress.steps == self.0 {
            self.1.raise();
        }
    }
}

/// Runs into a folder, from a checkpoint if there is one, and stops after so many steps.
fn run_into(
    loaded: &LoadedScene,
    plan: &Plan,
    folder: &Path,
    from: Option<Checkpoint>,
    (stop, settings): (u64, Settings),
) -> Result<Summary, RunError> {
    let resolved = loaded.resolved_toml();
    let mut writer = match &from {
        None => Writer::create(folder, &resolved)?,
        Some(_) => Writer::go_on(folder, &resolved)?,
    };
    let interrupt = Interrupt::default();
    let mut observer = StopsAfter(stop, &interrupt);
    let job = Job {
        writer: Some(&mut writer),
        settings,
        from,
        snapshot: Snapshot::default(),
        ..Job::new(&mut observer, &interrupt)
    };
    let summary = match plan.dimension {
        2 => run_job(plan, job)?.0,
        _ => run_job(plan, job)?.0,
    };
    Ok(summary)
}

/// With `threads` threads.
fn within<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

/// Files of results, but for lists, summaries, which have wall times, and checkpoints, which have them too.
fn results(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let ending = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| ["csv", "vtu", "vtp", "pvd", "svg", "png"].contains(&ending))
    };
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> = paths.filter(ending).collect();
    found.sort();
    found
}

/// Every file of one folder is in the other, with the same bytes, and no further one.
fn same_files(one: &Path, other: &Path) -> Result<(), String> {
    let names = |folder: &Path| -> Vec<_> {
        let own = results(folder).into_iter();
        own.map(|path| path.file_name().unwrap().to_owned())
            .collect()
    };
    same("files", &names(one), &names(other))?;
    for path in results(one) {
        let name = path.file_name().unwrap();
        let equal = std::fs::read(&path).unwrap() == std::fs::read(other.join(name)).unwrap();
        if !equal {
            return Err(format!("{name:?} differs"));
        }
    }
    Ok(())
}

fn keeping() -> Settings {
    Settings {
        checkpoints: Some(CheckpointRule::default()),
        ..Settings::default()
    }
}

/// Runs the check of every case and tells of all that fail.
fn of_all_cases(check: impl Fn((&str, &[&str])) -> Result<(), String>) {
    let failed = CASES.iter().filter_map(|case| {
        let fault = check(*case).err()?;
        Some(format!("{case:?}: {fault}"))
    });
    let failed: Vec<String> = failed.collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// `Ok` where two values are the same.
fn same<T: PartialEq + std::fmt::Debug>(what: &str, one: &T, other: &T) -> Result<(), String> {
    match one == other {
        true => Ok(()),
        false => Err(format!("{what}: {one:?} and {other:?}")),
    }
}

/// Without a stop on one thread, and with two stops on two threads and one; and what was counted.
#[test]
fn a_run_that_was_stopped_goes_on_to_the_same_bits() {
    of_all_cases(|case| {
        let loaded = loaded(case);
        let plan = resolve(&loaded, "case").map_err(|errors| errors.to_string())?;
        let folder = tempfile::tempdir().unwrap();
        let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
        let straight = within(1, || {
            run_into(&loaded, &plan, &whole, None, (u64::MAX, keeping()))
        });
        let straight = straight.map_err(|error| error.to_string())?;
        // Equilibrium under a constant load is one step, in which nothing can be stopped.
        let mut stops: Vec<u64> = [1, 2].map(|third| third * straight.steps / 3).to_vec();
        stops.retain(|stop| *stop > 0);
        stops.dedup();
        let last = stops.len();
        stops.push(u64::MAX);
        let mut ended = None;
        for (number, stop) in stops.into_iter().enumerate() {
            let from = (number > 0).then(|| Checkpoint::newest(&parts).unwrap());
            let threads = 2 - number % 2;
            let outcome = within(threads, || {
                run_into(&loaded, &plan, &parts, from, (stop, keeping()))
            });
            match outcome {
                Err(RunError::Interrupted { .. }) if number < last => {}
                Err(error) => return Err(error.to_string()),
                Ok(summary) => ended = Some(summary),
            }
        }
        same_files(&whole, &parts)?;
        let ended = ended.ok_or("it did not end")?;
        same("steps", &ended.steps, &straight.steps)?;
        same("rejections", &ended.rejections, &straight.rejections)?;
        let found = |summary: &Summary| serde_json::to_value(&summary.balance).unwrap();
        same("balance", &found(&ended), &found(&straight))?;
        same("results", &ended.results, &straight.results)?;
        same("errors", &ended.errors, &straight.errors)?;
        let over_time = |summary: &Summary| summary.errors_over_time.clone();
        same("errors", &over_time(&ended), &over_time(&straight))?;
        same("warnings", &ended.warnings, &straight.warnings)
    });
}

/// Has seen enough after so many steps.
struct Enough(u64, bool);

impl Observer for Enough {
    fn step(&mut self, progress: &Progress) {
        self.1 = progress.steps == self.0;
    }

    fn is_enough(&mut self) -> bool {
        self.1
    }
}

/// It ends like any other run, with a summary of that state and its fields, which what goes on drops again.
#[test]
fn a_run_that_has_come_far_enough_ends_well_and_goes_on_to_the_same_bits() {
    for case in [CASES[0], CASES[20]] {
        let loaded = loaded(case);
        let plan = resolve(&loaded, "case").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
        let straight = run_into(&loaded, &plan, &whole, None, (u64::MAX, keeping())).unwrap();
        let stop = straight.steps / 2;
        let mut writer = Writer::create(&parts, &loaded.resolved_toml()).unwrap();
        let (mut observer, interrupt) = (Enough(stop, false), Interrupt::default());
        let job = Job {
            writer: Some(&mut writer),
            settings: keeping(),
            ..Job::new(&mut observer, &interrupt)
        };
        let (summary, state) = run_job(&plan, job).unwrap();
        drop(writer);
        assert_eq!(summary.steps, stop);
        assert!(summary.t_end < plan.time.end && summary.t_end.total_cmp(&state.time).is_eq());
        assert!(parts.join("summary.json").is_file());
        let from = Checkpoint::newest(&parts).unwrap();
        assert!(!from.header.finished && from.header.steps == stop);
        let ended = run_into(&loaded, &plan, &parts, Some(from), (u64::MAX, keeping()));
        assert_eq!(ended.unwrap().steps, straight.steps);
        same_files(&whole, &parts).unwrap();
    }
}

/// Cases whose schemes and effects others have as well, and smaller.
const ALIKE: &[&str] = &["reservoir-3d", "terzaghi-graded", "column-3d"];

/// Every second sound step is computed, thrown away and computed again: the state that it starts from, and all
/// that schemes and solvers remember, must be untouched to the last bit.
#[test]
fn a_rejected_step_leaves_no_trace() {
    of_all_cases(|case| {
        if ALIKE.contains(&case.0) {
            return Ok(());
        }
        let loaded = loaded(case);
        let plan = resolve(&loaded, "case").map_err(|errors| errors.to_string())?;
        let folder = tempfile::tempdir().unwrap();
        let [plain, twice] = ["plain", "twice"].map(|name| folder.path().join(name));
        let rejecting = Settings {
            reject_every: Some(2),
            ..Settings::default()
        };
        for (place, settings) in [(&plain, Settings::default()), (&twice, rejecting)] {
            let ended = run_into(&loaded, &plan, place, None, (u64::MAX, settings));
            ended.map_err(|error| error.to_string())?;
        }
        same_files(&plain, &twice)
    });
}

/// A checkpoint is about as large as what it holds: fields, and what the scheme carries over.
#[test]
fn a_checkpoint_is_as_large_as_the_state() {
    for (case, vectors) in [
        (CASES[0], 4),
        // Displacement has two components, and strain and pressure increments of both stages are kept.
        (CASES[6], 8),
        (CASES[16], 22),
    ] {
        let loaded = loaded(case);
        let plan = resolve(&loaded, "case").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let run = run_into(&loaded, &plan, folder.path(), None, (u64::MAX, keeping()));
        let points = run.unwrap().points as u64;
        let checkpoint = Checkpoint::newest(folder.path()).unwrap();
        let bytes = std::fs::metadata(&checkpoint.path).unwrap().len();
        let most = 8 * points * vectors + 20_000;
        assert!(bytes < most, "{case:?}: {bytes} bytes for {points} points");
    }
}

fn tamper(folder: &Path, change: impl FnOnce(&mut Vec<u8>)) {
    let path = Checkpoint::newest(folder).unwrap().path;
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
}

/// A checkpoint that cannot be written, for a folder stands in its place, costs nothing but itself.
#[test]
fn a_checkpoint_that_cannot_be_written_leaves_the_one_before_and_the_run_goes_on() {
    let loaded = loaded(CASES[0]);
    let plan = resolve(&loaded, "case").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let stopped = run_into(&loaded, &plan, folder.path(), None, (20, keeping()));
    assert!(matches!(stopped, Err(RunError::Interrupted { .. })));
    let kept = Checkpoint::newest(folder.path()).unwrap();
    std::fs::create_dir(folder.path().join("checkpoint-0000000040.pfc")).unwrap();
    let from = Checkpoint::read(&kept.path).unwrap();
    let stopped = run_into(&loaded, &plan, folder.path(), Some(from), (40, keeping()));
    assert!(matches!(stopped, Err(RunError::Interrupted { .. })));
    std::fs::remove_dir(folder.path().join("checkpoint-0000000040.pfc")).unwrap();
    assert_eq!(Checkpoint::newest(folder.path()).unwrap(), kept);
    let ended = run_into(
        &loaded,
        &plan,
        folder.path(),
        Some(kept),
        (u64::MAX, keeping()),
    );
    assert!(ended.unwrap().steps > 40);
}

#[test]
fn a_damaged_checkpoint_is_refused_and_the_one_before_serves() {
    let loaded = loaded(CASES[0]);
    let plan = resolve(&loaded, "case").unwrap();
    let folder = tempfile::tempdir().unwrap();
    for stop in [20, 40] {
        let from = Checkpoint::newest(folder.path()).ok();
        let stopped = run_into(&loaded, &plan, folder.path(), from, (stop, keeping()));
        assert!(matches!(stopped, Err(RunError::Interrupted { .. })));
    }
    tamper(folder.path(), |bytes| bytes.truncate(bytes.len() / 2));
    let error = Checkpoint::newest(folder.path()).unwrap_err().to_string();
    let before = folder.path().join("checkpoint-0000000020.pfc");
    assert!(error.contains(&before.display().to_string()), "{error}");
    let from = Some(Checkpoint::read(&before).unwrap());
    let ended = run_into(&loaded, &plan, folder.path(), from, (u64::MAX, keeping()));
    assert!(ended.is_ok());
}
