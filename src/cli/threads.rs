//! How many threads may be asked for.

use super::exit::Failure;

/// The variable in which the thread pool looks for a number of its own accord.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Threads that a process may have: far more than help, far fewer than bring a system to a halt.
fn most() -> usize {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    (8 * processors).max(64)
}

/// Refuses a number of threads from the environment that would bring the system to a halt.
///
/// # Errors
/// [`Failure::Usage`].
pub(super) fn check_environment() -> Result<(), Failure> {
    let number = std::env::var(VARIABLE)
        .ok()
        .and_then(|text| text.trim().parse().ok());
    number.map_or(Ok(()), |threads| bounded(&format!("{VARIABLE}="), threads))
}

/// Makes the pool of threads: as many as wished for, or as the default says, or as there are processors.
///
/// The thread that runs belongs to it: handing every loop to others and waiting for them took more than many a loop of
/// a small scene.
///
/// # Errors
/// [`Failure::Usage`] for a number that cannot be.
pub(super) fn set(wish: Option<usize>, default: Option<usize>) -> Result<(), Failure> {
    let mut builder = rayon::ThreadPoolBuilder::new().use_current_thread();
    if let Some(threads) = wish.or(default) {
        if threads == 0 {
            return Err(Failure::Usage("--threads must be at least 1".to_owned()));
        }
        bounded("--threads ", threads)?;
        builder = builder.num_threads(threads);
    }
    (builder.build_global())
        .map_err(|error| Failure::Usage(format!("no threads to run on: {error}")))
}

fn bounded(key: &str, threads: usize) -> Result<(), Failure> {
    let most = most();
    match threads <= most {
        true => Ok(()),
        false => Err(Failure::Usage(format!(
            "{key}{threads}: at most {most} threads, eight for each processor; as many as there are \
             processors are fastest"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_threads_than_eight_for_each_processor_are_refused() {
        assert!(bounded("--threads ", most()).is_ok());
        for threads in [most() + 1, 99_999_999, usize::MAX] {
            let Err(Failure::Usage(told)) = bounded("--threads ", threads) else {
                unreachable!("{threads} threads are too many");
            };
            assert!(
                told.contains(&format!("--threads {threads}: at most")),
                "{told}"
            );
        }
    }
}
