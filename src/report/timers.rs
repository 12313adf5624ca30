//! Wall time per phase.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize};

/// Seconds spent per named phase, in the order in which phases first ran.
///
/// A phase within another one takes its time away from it, so that all phases add up to the time since
/// [`Timers::begin`]. Copies share one clock: the parts of a model and the schemes each keep one. Phases
/// are begun and ended on the thread of the run only.
#[derive(Debug, Clone, Default)]
pub struct Timers {
    clock: Arc<Mutex<Clock>>,
}

#[derive(Debug, Default)]
struct Clock {
    phases: Vec<(Cow<'static, str>, f64)>,
    running: Option<(&'static str, Instant)>,
}

impl Clock {
    fn add(&mut self, phase: Cow<'static, str>, seconds: f64) {
        match self.phases.iter_mut().find(|(name, _)| *name == phase) {
            Some((_, total)) => *total += seconds,
            None => self.phases.push((phase, seconds)),
        }
    }
}

impl Timers {
    /// Runs `work` and adds its time, less that of phases within it, to `phase`.
    pub fn time<T>(&self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let outer = self.switch(Some(phase));
        let result = work();
        self.switch(outer);
        result
    }

    /// Gives all time from now on that is spent in no phase to `phase`.
    pub fn begin(&self, phase: &'static str) {
        self.switch(Some(phase));
    }

    /// Stops the clock.
    pub fn end(&self) {
        self.switch(None);
    }

    /// Ends the running phase and starts the next one; gives the one that ended.
    fn switch(&self, next: Option<&'static str>) -> Option<&'static str> {
        let now = Instant::now();
        let mut clock = self.clock();
        let ended = clock.running.take();
        if let Some((phase, since)) = ended {
            clock.add(phase.into(), now.duration_since(since).as_secs_f64());
        }
        if let Some(phase) = next {
            clock.add(phase.into(), 0.0);
            clock.running = Some((phase, now));
        }
        ended.map(|(phase, _)| phase)
    }

    /// A phase that panicked leaves times that are still good.
    fn clock(&self) -> MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds seconds per phase that earlier parts of a run have spent.
    pub fn add(&self, before: &BTreeMap<String, f64>) {
        let mut clock = self.clock();
        for (phase, seconds) in before {
            clock.add(phase.clone().into(), *seconds);
        }
    }

    /// Seconds per phase, that of the running one up to now.
    pub fn phases(&self) -> BTreeMap<String, f64> {
        let running = self.switch(None);
        self.switch(running);
        let phases = self.iter();
        phases
            .map(|(name, seconds)| (name.into_owned(), seconds))
            .collect()
    }

    /// Seconds of a phase; zero if it never ran.
    pub fn seconds(&self, phase: &str) -> f64 {
        self.iter()
            .find(|(name, _)| *name == phase)
            .map_or(0.0, |(_, seconds)| seconds)
    }

    /// Phases and seconds.
    pub fn iter(&self) -> impl Iterator<Item = (Cow<'static, str>, f64)> + use<> {
        self.clock().phases.clone().into_iter()
    }
}

impl Serialize for Timers {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let phases = self.clock().phases.clone();
        let mut map = serializer.serialize_map(Some(phases.len()))?;
        for (phase, seconds) in &phases {
            map.serialize_entry(phase, seconds)?;
        }
        map.end()
    }
}

/// What was measured, by the names of the phases.
impl<'de> Deserialize<'de> for Timers {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let phases = BTreeMap::<String, f64>::deserialize(deserializer)?;
        let phases = phases.into_iter().map(|(name, time)| (name.into(), time));
        let clock = Clock {
            phases: phases.collect(),
            running: None,
        };
        Ok(Timers {
            clock: Arc::new(Mutex::new(clock)),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_run_that_goes_on_counts_what_it_spent_before() {
        let spent = |text: &str| serde_json::from_str::<Timers>(text).unwrap();
        let now = spent(r#"{"steps": 1.5, "output": 0.25}"#);
        now.add(&spent(r#"{"families": 3.0, "steps": 2.0}"#).phases());
        let all = ["steps", "output", "families"].map(|phase| now.seconds(phase));
        assert_eq!(all.map(f64::to_bits), [3.5, 0.25, 3.0].map(f64::to_bits));
    }

    #[test]
    fn an_inner_phase_takes_its_time_from_the_outer_one_and_all_add_up() {
        let (timers, started) = (Timers::default(), Instant::now());
        timers.begin("other");
        let copy = timers.clone();
        let nap = || sleep(Duration::from_millis(20));
        let found = timers.time("steps", || {
            copy.time("factor", nap);
            nap();
            7
        });
        timers.end();
        let wall = started.elapsed().as_secs_f64();
        let names: Vec<_> = timers.iter().map(|(name, _)| name).collect();
        assert_eq!(
            (found, &names[..]),
            (7, &["other", "steps", "factor"].map(Cow::from)[..])
        );
        assert!(timers.seconds("factor") >= 0.02 && timers.seconds("steps") >= 0.02);
        let sum: f64 = timers.iter().map(|(_, seconds)| seconds).sum();
        assert!(sum <= wall && timers.seconds("steps") <= wall - 0.02);
        nap();
        let after: f64 = timers.iter().map(|(_, seconds)| seconds).sum();
        assert!((after - sum).abs() <= 0.0, "the clock stands still");
    }
}
