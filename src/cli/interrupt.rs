//! Signals that ask the program to end: SIGINT, SIGTERM and SIGHUP.

use std::time::Duration;

use nix::sys::signal::{SigSet, Signal};
use perifrac_solvers::Interrupt;

use super::exit::{INTERRUPTED, say};

/// Time that a run has to notice the first signal. It looks between steps, passes and iterations, so only
/// something that cannot be left, such as a factorisation, takes longer.
const GRACE: Duration = Duration::from_millis(800);

/// A flag that the first signal raises. A second one ends the program at once, and so does the first if
/// nothing has noticed it in time: files are whole at any moment.
pub fn handled() -> Interrupt {
    let interrupt = Interrupt::default();
    let seen = interrupt.clone();
    // Without a handler the program is simply ended at once, as before.
    let _ = ctrlc::set_handler(move || {
        if seen.raise() {
            std::process::exit(INTERRUPTED.into());
        }
        let waited = seen.clone();
        // The handler must be free for a second signal.
        std::thread::spawn(move || {
            std::thread::sleep(GRACE);
            if !waited.is_heard() {
                say("error: interrupted; what was written is complete");
                std::process::exit(INTERRUPTED.into());
            }
        });
    });
    interrupt
}

/// Keeps SIGHUP ignored where it was when the program started, as under `nohup`: a handler would undo that.
/// Threads take over from the first one what is blocked, so this comes before all others.
pub fn keep_hangups_ignored() {
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
