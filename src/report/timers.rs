//! Wall time per phase.

use std::time::Instant;

use serde::Serialize;
use serde::ser::SerializeMap;

/// Seconds spent per named phase, in the order in which phases first ran.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timers {
    phases: Vec<(&'static str, f64)>,
}

impl Timers {
    /// Runs `work` and adds its time to `phase`.
    pub fn time<T>(&mut self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(phase, start.elapsed().as_secs_f64());
        result
    }

    /// Adds seconds to a phase.
    pub fn add(&mut self, phase: &'static str, seconds: f64) {
        match self.phases.iter_mut().find(|(name, _)| *name == phase) {
            Some((_, total)) => *total += seconds,
            None => self.phases.push((phase, seconds)),
        }
    }

    /// Seconds of a phase; zero if it never ran.
    pub fn seconds(&self, phase: &str) -> f64 {
        self.phases
            .iter()
            .find(|(name, _)| *name == phase)
            .map_or(0.0, |(_, seconds)| *seconds)
    }

    /// Phases and seconds.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.phases.iter().copied()
    }
}

impl Serialize for Timers {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.phases.len()))?;
        for (phase, seconds) in &self.phases {
            map.serialize_entry(phase, seconds)?;
        }
        map.end()
    }
}
