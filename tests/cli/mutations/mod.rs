//! Thousands of scenes that somebody could have typed: none ends the program, none takes it long, and
//! `check`, `plan` and the start of a run refuse the same ones with the same words.

mod bases;
mod mutator;
mod random;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use perifrac::explain::explain;
use perifrac::plan::{Plan, resolve};
use perifrac::run::{Interrupt, RunError, begin, examine, run};
use perifrac::scene::load_str;
use perifrac::schemes;
use perifrac::schemes::StepError;
use toml::Table;

use mutator::mutated;

/// Scenes of one run; `PERIFRAC_MUTATIONS` asks for another number, `PERIFRAC_MUTATION_SEED` for another
/// first seed.
const SCENES: u64 = 4_000;
/// Seeds of scenes that once failed; each stays.
const KEPT: [u64; 4] = [54, 403, 909, 974];
/// A scene that takes longer has hung: models of up to a second are built, by both commands. It is tried again,
/// since another program may have had the machine.
const HUNG: Duration = Duration::from_secs(5);
/// Of so many sound scenes one is started for good.
const STARTED: u64 = 40;

#[test]
fn mutated_scenes_are_refused_alike_and_end_nothing() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let first = number("PERIFRAC_MUTATION_SEED").unwrap_or(0);
    let scenes = number("PERIFRAC_MUTATIONS").unwrap_or(SCENES);
    let seeds: Vec<u64> = KEPT.into_iter().chain(first..first + scenes).collect();
    let bases = bases::bases();
    for (number, base) in bases.iter().enumerate() {
        let text = toml::to_string(base).unwrap();
        assert_eq!(judge(&text, true), Ok(true), "base {number}:\n{text}");
    }
    let (next, sound) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut failures = Vec::new();
        while let Some(&seed) = seeds.get(next.fetch_add(1, Ordering::Relaxed)) {
            match try_seed(&bases, seed) {
                Ok(accepted) => drop(sound.fetch_add(usize::from(accepted), Ordering::Relaxed)),
                Err(failure) => failures.push(failure),
            }
        }
        failures
    };
    let failures: Vec<String> = std::thread::scope(|scope| {
        let threads = [scope.spawn(work), scope.spawn(work)];
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap())
            .collect()
    });
    assert!(
        failures.is_empty(),
        "{} scenes:\n{}",
        failures.len(),
        failures.join("\n")
    );
    // Too few or too many sound scenes would test little.
    let share = sound.into_inner() as f64 / seeds.len() as f64;
    println!("{} scenes, {share:.2} of them sound", seeds.len());
    assert!(
        scenes < 1000 || (0.05..0.7).contains(&share),
        "{share} of the scenes are sound"
    );
}

/// Ends the test with the text of a scene that takes more than a minute: nothing else could.
fn watch(seed: u64, text: String) -> std::sync::mpsc::Sender<()> {
    let (done, ended) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let late = std::sync::mpsc::RecvTimeoutError::Timeout;
        if ended.recv_timeout(Duration::from_secs(60)) == Err(late) {
            eprintln!("seed {seed}: hung for a minute\n{text}");
            std::process::exit(101);
        }
    });
    done
}

/// Whether the scene of a seed is sound, or what is wrong with the program.
fn try_seed(bases: &[Table], seed: u64) -> Result<bool, String> {
    let text = mutated(bases, seed);
    let _watched = watch(seed, text.clone());
    let timed = || {
        let start = Instant::now();
        let judged = catch_unwind(AssertUnwindSafe(|| {
            judge(&text, seed.is_multiple_of(STARTED))
        }));
        (judged, start.elapsed())
    };
    let (mut judged, mut taken) = timed();
    if taken > HUNG {
        (judged, taken) = timed();
    }
    let wrong = |what: String| Err(format!("seed {seed}: {what}\n{text}"));
    match judged {
        Err(_) => wrong("panic".to_owned()),
        Ok(_) if taken > HUNG => wrong(format!("hung for {taken:?}")),
        Ok(Err(what)) => wrong(what),
        Ok(Ok(accepted)) => Ok(accepted),
    }
}

/// Whether a scene is sound; an error if the answers differ.
fn judge(text: &str, start: bool) -> Result<bool, String> {
    let Ok(loaded) = load_str("scene", text, Path::new("nowhere"), &[]) else {
        return Ok(false);
    };
    match resolve(&loaded, "scene") {
        Err(_) => Ok(false),
        Ok(plan) => compare(&plan, start),
    }
}

fn compare(plan: &Plan, start: bool) -> Result<bool, String> {
    let told = |error: &RunError| error.to_string();
    let examined = examine(plan, 1);
    let checked = examined.as_ref().map(|_| ()).map_err(told);
    // What estimates alone refuse must be what the model refuses.
    let admitted = schemes::check(plan, 1).map_err(|error| told(&RunError::refused(plan, error)));
    let planned = admitted.and_then(|()| {
        let explained = explain(plan).map_err(|error| error.to_string());
        explained.map(|explanation| drop(explanation.to_string()))
    });
    if let Err(error) = &planned
        && checked != Err(error.clone())
    {
        return Err(format!("plan: {error}; check: {checked:?}"));
    }
    match &examined {
        Ok(examined) if !examined.built => return Ok(true),
        _ => {}
    }
    // A run estimates what it needs before it takes any of it.
    let begun = match planned.is_err() {
        true => checked.clone(),
        false => begin(plan).map_err(|error| told(&error)),
    };
    if begun != checked {
        return Err(format!("run: {begun:?}; check: {checked:?}"));
    }
    match start && begun.is_ok() {
        true => started(plan),
        false => Ok(begun.is_ok()),
    }
}

/// A run that is interrupted at once may fail by its numbers, but not by what the scene asks for.
fn started(plan: &Plan) -> Result<bool, String> {
    let interrupt = Interrupt::default();
    interrupt.raise();
    match run(plan, None, &mut (), &interrupt) {
        Err(RunError::Step { source, .. }) if is_refusal(&source) => {
            Err(format!("refused by the run alone: {source}"))
        }
        Err(RunError::Model(error)) => Err(format!("refused by the run alone: {error}")),
        _ => Ok(true),
    }
}

fn is_refusal(error: &StepError) -> bool {
    matches!(
        error,
        StepError::Refused(_)
            | StepError::MissingPart { .. }
            | StepError::Spec(_)
            | StepError::Pattern(_)
    )
}
