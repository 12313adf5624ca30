//! Notices iterations that get nowhere, the same way for all schemes.

/// Share of the least so far below which an iteration has made progress.
const PROGRESS: f64 = 0.9;

/// How long a residual has not fallen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stagnation {
    least: f64,
    stuck: usize,
}

impl Stagnation {
    /// Nothing seen yet.
    pub(crate) fn new() -> Self {
        Stagnation {
            least: f64::INFINITY,
            stuck: 0,
        }
    }

    /// Takes in the residual of an iteration; gives how many there were since the last progress.
    pub(crate) fn note(&mut self, residual: f64) -> usize {
        self.stuck += 1;
        if residual <= PROGRESS * self.least {
            (self.least, self.stuck) = (residual, 0);
        }
        self.stuck
    }

    /// Progress of another kind.
    pub(crate) fn forgive(&mut self) {
        self.stuck = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_progress_is_progress_and_circles_are_not() {
        let mut slow = Stagnation::new();
        assert!((0..50).all(|k| slow.note(0.97_f64.powi(k)) <= 4));
        let mut circles = Stagnation::new();
        let stuck = (0..20).map(|k| circles.note(if k % 2 == 0 { 1.0 } else { 1.5 }));
        assert_eq!(stuck.max(), Some(19));
        circles.forgive();
        assert_eq!(circles.note(1.0), 1);
        assert_eq!(circles.note(f64::NAN), 2, "no number is no progress");
    }
}
