//! Signals that ask the program to end: SIGINT, SIGTERM and SIGHUP.

use std::sync::atomic::{AtomicI32, Ordering};
use std::thread::sleep;
use std::time::Duration;

use nix::sys::signal::{SigSet, Signal};
use perifrac_solvers::Interrupt;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::exit::say;
use super::stages::way_on;
use crate::run::Snapshot;

/// Time that a run has to notice the first signal. It looks between steps, passes and iterations, so only
/// something that cannot be left, such as a factorisation, takes longer.
const GRACE: Duration = Duration::from_millis(800);
/// Time after which a state that was not written by the run itself is written all the same: queues kill soon
/// after their notice.
const LATEST: Duration = Duration::from_millis(4000);

/// The signal that came.
static SIGNAL: AtomicI32 = AtomicI32::new(SIGINT);

/// Exit code of a program that a signal ended, as shells tell it: 130 after SIGINT, 143 after SIGTERM.
pub(super) fn code() -> u8 {
    128 + SIGNAL.load(Ordering::Relaxed) as u8
}

/// A flag that the first signal raises. A second one ends the program at once, and so does the first if
/// nothing has noticed it in time: files are whole at any moment, and the state that `snapshot` was told last
/// is written before.
pub(super) fn handled(snapshot: &Snapshot) -> Interrupt {
    let interrupt = Interrupt::default();
    let (seen, snapshot) = (interrupt.clone(), snapshot.clone());
    // Without a handler the program is simply ended at once.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM, SIGHUP]) else {
        return interrupt;
    };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            SIGNAL.store(signal, Ordering::Relaxed);
            if seen.raise() {
                std::process::exit(code().into());
            }
            let (seen, snapshot) = (seen.clone(), snapshot.clone());
            // This loop must be free for a second signal.
            std::thread::spawn(move || watch(&seen, &snapshot));
        }
    });
    interrupt
}

/// Ends the program where the run does not do so by itself.
fn watch(seen: &Interrupt, snapshot: &Snapshot) {
    sleep(GRACE);
    if !seen.is_heard() && !snapshot.is_empty() {
        end(snapshot);
    }
    if seen.is_heard() || !snapshot.is_empty() {
        sleep(LATEST - GRACE);
    }
    if !seen.is_heard() {
        end(snapshot);
    }
    // The run is on its way out, but something takes long.
    let _ = snapshot.save();
}

/// Writes the last state and ends the program, unless the run is writing that state itself.
fn end(snapshot: &Snapshot) {
    match snapshot.save() {
        Ok(Some((time, path))) => {
            let folder = way_on(path.parent().unwrap_or(&path)).display();
            say(&format!(
                "error: interrupted; the state at t = {time:.6e} s is kept: go on with `perifrac resume \
                 {folder}`"
            ));
        }
        Ok(None) if snapshot.is_empty() => {
            say("error: interrupted; what was written is complete");
        }
        Ok(None) => return,
        Err(error) => say(&format!(
            "error: interrupted, and no checkpoint could be written: {error}"
        )),
    }
    std::process::exit(code().into());
}

/// Keeps SIGHUP ignored where it was when the program started, as under `nohup`: a handler would undo that.
/// Threads take over from the first one what is blocked, so this comes before all others.
pub(super) fn keep_hangups_ignored() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    if ignored.unwrap_or(0) >> (Signal::SIGHUP as u32 - 1) & 1 == 1 {
        let mut blocked = SigSet::empty();
        blocked.add(Signal::SIGHUP);
        // What cannot be blocked ends the run as it does anywhere else.
        let _ = blocked.thread_block();
    }
}
