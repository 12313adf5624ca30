//! Stopping what runs, from outside.
//!
//! An iteration may take minutes, and whoever waits for it may have enough. The flag that counts belongs
//! to the thread that iterates, for as long as [`Interrupt::during`] says: so no solver and no scheme has
//! to hand it on, and several runs in one program do not stop each other.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::SolveError;

/// A flag that asks whatever runs under it to stop. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<Flags>);

#[derive(Debug, Default)]
struct Flags {
    raised: AtomicBool,
    /// Whether what runs has seen it.
    heard: AtomicBool,
}

thread_local! {
    /// The flag that counts on this thread.
    static CURRENT: RefCell<Option<Interrupt>> = const { RefCell::new(None) };
}

impl Interrupt {
    /// Asks to stop; true if that had been asked before.
    pub fn raise(&self) -> bool {
        self.0.raised.swap(true, Ordering::Relaxed)
    }

    /// Whether it was asked to stop. What asks here must then stop soon, see [`Interrupt::is_heard`].
    pub fn is_raised(&self) -> bool {
        let raised = self.0.raised.load(Ordering::Relaxed);
        if raised {
            self.0.heard.store(true, Ordering::Relaxed);
        }
        raised
    }

    /// Whether what runs has seen the flag and is about to stop by itself.
    pub fn is_heard(&self) -> bool {
        self.0.heard.load(Ordering::Relaxed)
    }

    /// Lets the flag count for all that `work` does on this thread.
    pub fn during<R>(&self, work: impl FnOnce() -> R) -> R {
        let before = CURRENT.replace(Some(self.clone()));
        // Put back on the way out of a panic too: the thread may go on to something else.
        let _restore = Restore(before);
        work()
    }
}

struct Restore(Option<Interrupt>);

impl Drop for Restore {
    fn drop(&mut self) {
        CURRENT.set(self.0.take());
    }
}

/// Whether what this thread does was asked to stop. Costs next to nothing: it is asked in every iteration.
#[must_use]
pub fn interrupted() -> bool {
    CURRENT.with_borrow(|current| current.as_ref().is_some_and(Interrupt::is_raised))
}

/// The same as an error.
pub(crate) fn check() -> Result<(), SolveError> {
    match interrupted() {
        true => Err(SolveError::Interrupted),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_counts_where_and_while_it_is_said_to() {
        let (outer, inner) = (Interrupt::default(), Interrupt::default());
        assert!(!outer.raise() && outer.raise());
        assert!(!interrupted() && !outer.is_heard());
        outer.during(|| {
            inner.during(|| assert!(!interrupted()));
            assert!(interrupted() && check().is_err());
            let elsewhere = std::thread::spawn(interrupted).join();
            assert!(!elsewhere.unwrap_or(true));
        });
        assert!(!interrupted() && outer.is_heard() && !inner.is_heard());
    }

    #[test]
    fn a_panic_ends_what_the_flag_counts_for() {
        let flag = Interrupt::default();
        flag.raise();
        let attempt = std::panic::catch_unwind(|| flag.during(|| panic!("fault")));
        assert!(attempt.is_err() && !interrupted());
    }
}
