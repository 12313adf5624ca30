//! Progress on standard error: a bar on a terminal, warnings anywhere.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use super::exit;
use crate::run::{Observer, Progress};

/// Shows how a run goes on.
pub(super) struct Console {
    bar: Option<ProgressBar>,
    quiet: bool,
}

/// Resolution of the bar.
const TICKS: u64 = 1000;

impl Console {
    /// A console that shows a bar only on a terminal, and nothing if `quiet`.
    pub(super) fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal() && std::env::var_os("CI").is_none();
        let bar = (terminal && !quiet).then(|| {
            let bar = ProgressBar::new(TICKS);
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} % {msg} {eta}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Console { bar, quiet }
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Console {
    fn warn(&mut self, message: &str) {
        if self.quiet {
            return;
        }
        match &self.bar {
            Some(bar) => bar.println(format!("warning: {message}")),
            None => exit::warn(message),
        }
    }

    fn step(&mut self, progress: &Progress) {
        if let Some(bar) = &self.bar {
            bar.set_position((progress.time / progress.end * TICKS as f64) as u64);
            let passes = progress.passes.map_or(String::new(), |(passes, left)| {
                format!(", {passes} passes to {left:.0e}")
            });
            bar.set_message(format!(
                "t {:.3e} s, Δt {:.2e} s, {} steps, {} rejected, {} iterations{passes}",
                progress.time, progress.dt, progress.steps, progress.rejected, progress.iterations
            ));
        }
    }
}
