//! A run on a thread of its own.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use perifrac::prelude::{Checkpoint, Interrupt, Job, LoadedScene, Plan, Settings, Writer, run_job};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::Fault;
use crate::relay::Relay;

/// Stack of every thread of a run, as large as that of the program.
const STACK: usize = 8 << 20;

/// All that a run needs.
pub(crate) struct Task {
    pub loaded: LoadedScene,
    pub plan: Plan,
    pub writer: Option<Writer>,
    pub settings: Settings,
    pub from: Option<Checkpoint>,
    pub pool: ThreadPool,
}

/// Threads for a run: as many as there are processors by default.
///
/// # Errors
/// [`Fault`] for a number that cannot be.
pub(crate) fn pool(threads: Option<usize>) -> Result<ThreadPool, Fault> {
    if threads == Some(0) {
        return Err(Fault::new("UsageError", "threads must be at least 1"));
    }
    let builder = ThreadPoolBuilder::new().stack_size(STACK);
    let pool = builder.num_threads(threads.unwrap_or(0)).build();
    pool.map_err(|error| Fault::new("UsageError", format!("threads: {error}")))
}

/// Runs a task and tells of its end.
pub(crate) fn work(task: Task, mut relay: Relay, interrupt: &Interrupt) {
    let Task {
        loaded,
        plan,
        mut writer,
        settings,
        from,
        pool,
    } = task;
    let run = || {
        let job = Job {
            writer: writer.as_mut(),
            settings,
            base: whole(&loaded.base_dir),
            from,
            ..Job::new(&mut relay, interrupt)
        };
        run_job(&plan, job)
    };
    let result = match catch_unwind(AssertUnwindSafe(|| pool.install(run))) {
        Ok(Ok((summary, _))) => Ok(serde_json::to_string(&summary).unwrap_or_default()),
        Ok(Err(error)) => Err(Fault::of_run(&loaded, &error)),
        Err(_) => {
            let message =
                "a fault of perifrac itself ended the run; please report it with the scene";
            Err(Fault::new("RunError", message))
        }
    };
    // The folder is free for others before the end is told.
    drop(writer);
    relay.conclude(result);
}

/// A folder by its whole path.
fn whole(folder: &Path) -> PathBuf {
    let here = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    here.canonicalize().unwrap_or_else(|_| folder.to_owned())
}
