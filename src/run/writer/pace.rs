//! When pictures of outputs are drawn: at once in long runs, at the end of short ones, which draw them again anyway.

use std::time::{Duration, Instant};

use super::Writer;
use crate::model::Model;
use crate::output::OutputError;
use crate::plan::Plan;

/// Outputs that are not drawn yet, and the time that drawing takes.
#[derive(Debug)]
pub(super) struct Pace {
    pending: Vec<usize>,
    last: Instant,
    cost: Duration,
}

/// Shortest time between two drawings: nobody looks at pictures of a run that is over within a second.
const SELDOM: Duration = Duration::from_secs(1);
/// The same in times of the last drawing, which takes a tenth of the run then.
const DRAWING: u32 = 10;

impl Default for Pace {
    fn default() -> Self {
        Pace {
            pending: Vec::new(),
            last: Instant::now(),
            cost: Duration::ZERO,
        }
    }
}

impl Pace {
    /// Takes note of an output.
    pub(super) fn add(&mut self, number: usize) {
        self.pending.push(number);
    }

    /// Whether it is time to draw.
    pub(super) fn is_due(&self) -> bool {
        self.last.elapsed() >= SELDOM.max(DRAWING * self.cost)
    }

    /// Calls `draw` with the outputs that are not drawn yet.
    ///
    /// # Errors
    /// The first of `draw`.
    pub(super) fn draw<E>(&mut self, draw: impl FnMut(usize) -> Result<(), E>) -> Result<(), E> {
        let begun = Instant::now();
        let drawn = std::mem::take(&mut self.pending)
            .into_iter()
            .try_for_each(draw);
        (self.cost, self.last) = (begun.elapsed(), Instant::now());
        drawn
    }
}

impl Writer {
    /// Draws the outputs that are not drawn yet. All of them are drawn in [`Writer::finish`]; a run that fails calls this.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn draw_pending<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
    ) -> Result<(), OutputError> {
        let mut pace = std::mem::take(&mut self.pace);
        let drawn =
            pace.draw(|number| self.pictures(plan, model, |pictures| pictures.of_output(number)));
        self.pace = pace;
        drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_of_a_short_run_wait_and_those_of_a_long_one_do_not() {
        let mut pace = Pace::default();
        pace.add(0);
        pace.add(1);
        assert!(!pace.is_due());
        let before = |seconds| {
            Instant::now()
                .checked_sub(Duration::from_secs(seconds))
                .unwrap()
        };
        pace.last = before(2);
        assert!(pace.is_due());
        let mut drawn = Vec::new();
        let draw = |number| -> Result<(), ()> {
            drawn.push(number);
            Ok(())
        };
        pace.draw(draw).unwrap();
        assert_eq!(drawn, [0, 1]);
        assert!(pace.pending.is_empty() && !pace.is_due());
        (pace.last, pace.cost) = (before(5), Duration::from_secs(1));
        assert!(
            !pace.is_due(),
            "pictures would take more than a tenth of the run"
        );
    }
}
