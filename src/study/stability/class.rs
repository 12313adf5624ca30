//! How a run of the map ended.

use crate::study::{Measured, Status, profile};

/// Error above which a run that reached its end is inaccurate.
pub(super) const INACCURATE: f64 = 0.05;
/// Error above which a run that reached its end has diverged all the same.
const DIVERGED: f64 = 1.0;
/// Growth of the largest pressure over that at the start which no response of a rock comes near.
const GROWN: f64 = 2.0;
/// Share of the pressure at the start below which the exact field is zero for all purposes: errors are
/// then relative to this share.
const FADED: f64 = 0.01;
/// Undershoot over the range of the pressure, or swing over its size at the start, that counts as
/// oscillation.
pub(super) const OVERSHOOT: f64 = 0.05;
/// Steps that undershoot, or turns of the pressure, that count as oscillation.
const OFTEN: usize = 3;

/// Exit code of a run that did not converge or was unstable.
const UNSTABLE: i32 = 4;

/// How a run went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    Converged,
    Inaccurate,
    Oscillating,
    Diverged,
    Refused,
    Unfinished,
}

impl Class {
    /// Classes of runs that say something of stability, in the order of legends.
    pub(super) const TOLD: [Class; 4] = [
        Class::Converged,
        Class::Inaccurate,
        Class::Oscillating,
        Class::Diverged,
    ];

    /// Whether the run says something of stability.
    pub(super) fn is_told(self) -> bool {
        Class::TOLD.contains(&self)
    }

    /// The class of a run.
    pub(super) fn of(run: &Measured) -> Class {
        match run.first().status {
            Status::Done => {}
            Status::Refused => return Class::Refused,
            Status::Failed if run.first().code == Some(UNSTABLE) => return Class::Diverged,
            _ => return Class::Unfinished,
        }
        let extremes = Extremes::of(run);
        match Class::error_of(run) {
            error if error.is_nan() && extremes.high.is_empty() => Class::Unfinished,
            _ if extremes.grew() => Class::Diverged,
            error if error > DIVERGED => Class::Diverged,
            _ if extremes.oscillate() => Class::Oscillating,
            error if error > INACCURATE => Class::Inaccurate,
            _ => Class::Converged,
        }
    }

    /// Largest error of the fields at the end over their ranges; NaN without an exact solution. The range
    /// of a pressure that has drained is not below a share of the pressure at the start.
    pub(super) fn error_of(run: &Measured) -> f64 {
        let start = Extremes::of(run).start();
        let pressure = run.error_of("pressure", |error| error.l2);
        let range = run.error_of("pressure", |error| error.range);
        let floor = range / range.max(FADED * start);
        let displacement = run.error_of("displacement", |error| error.l2);
        (pressure * floor).max(displacement)
    }

    /// Whether nothing grew that the exact solution has not; swings may be there, if they fade.
    pub(super) fn is_stable(self) -> bool {
        matches!(
            self,
            Class::Converged | Class::Inaccurate | Class::Oscillating
        )
    }

    /// As in legends.
    pub(super) fn name(self) -> &'static str {
        match self {
            Class::Converged => "converged",
            Class::Inaccurate => "inaccurate",
            Class::Oscillating => "oscillating",
            Class::Diverged => "diverged",
            Class::Refused => "refused",
            Class::Unfinished => "unfinished",
        }
    }
}

/// Smallest and largest pressure after every step, the start first, Pa.
struct Extremes<'a> {
    low: &'a [f64],
    high: &'a [f64],
}

impl<'a> Extremes<'a> {
    fn of(run: &'a Measured) -> Self {
        let fields = &run.first().fields;
        let series = |name: &str| -> &'a [f64] {
            let own = fields.iter().find(|(field, _)| field == name);
            own.map_or(&[], |(_, values)| values)
        };
        Extremes {
            low: series(profile::LOWEST),
            high: series(profile::HIGHEST),
        }
    }

    /// Size of the pressure at the start, Pa; 0 if unknown.
    fn start(&self) -> f64 {
        self.size(0)
    }

    fn size(&self, step: usize) -> f64 {
        let at = |series: &[f64]| series.get(step).copied().unwrap_or(0.0).abs();
        at(self.low).max(at(self.high))
    }

    fn grew(&self) -> bool {
        let last = self.size(self.high.len().saturating_sub(1));
        self.start() > 0.0 && last > GROWN * self.start()
    }

    fn oscillate(&self) -> bool {
        self.undershoots() >= OFTEN || self.turns(self.low).max(self.turns(self.high)) >= OFTEN
    }

    /// Steps after which the pressure is on both sides of zero, where a load puts it on one and drains
    /// and seals keep it there.
    fn undershoots(&self) -> usize {
        let pairs = self.low.iter().zip(self.high).skip(1);
        let below = pairs.filter(|(low, high)| {
            let smaller = low.abs().min(high.abs());
            **low < 0.0 && **high > 0.0 && smaller > OVERSHOOT * (*high - *low)
        });
        below.count()
    }

    /// How often a series turns by more than a share of the pressure at the start, from one step to
    /// the next.
    fn turns(&self, series: &[f64]) -> usize {
        let least = OVERSHOOT * self.start();
        let changes: Vec<f64> = series.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let turn = |pair: &&[f64]| {
            pair[0] * pair[1] < 0.0
                && pair[0].abs().min(pair[1].abs()) > least.max(f64::MIN_POSITIVE)
        };
        changes.windows(2).filter(turn).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Row, Variant};

    /// A run that reached its end with these pressures.
    fn run(low: impl Fn(i32) -> f64, high: impl Fn(i32) -> f64) -> Class {
        let mut row = Row::unmeasured(String::new(), 0, Status::Done, String::new());
        let series = |of: &dyn Fn(i32) -> f64| (0..80).map(of).collect();
        row.fields = vec![
            (profile::LOWEST.to_owned(), series(&low)),
            (profile::HIGHEST.to_owned(), series(&high)),
        ];
        Class::of(&Measured::new(Variant::default(), vec![row]))
    }

    /// What stopped for another reason, was cut off or left nothing to judge by says nothing of stability.
    #[test]
    fn only_runs_that_ended_or_became_unstable_are_told() {
        let of = |status, code| {
            let mut row = Row::unmeasured(String::new(), 0, status, String::new());
            row.code = code;
            Class::of(&Measured::new(Variant::default(), vec![row]))
        };
        assert_eq!(of(Status::Failed, Some(UNSTABLE)), Class::Diverged);
        for (status, code) in [
            (Status::Done, Some(0)),
            (Status::Failed, Some(1)),
            (Status::Failed, None),
            (Status::TimedOut, None),
            (Status::Skipped, None),
            (Status::NotRun, None),
            (Status::Refused, Some(3)),
        ] {
            assert!(!of(status, code).is_told(), "{status:?}");
        }
    }

    fn fade(step: i32) -> f64 {
        1e4 * 0.95_f64.powi(step)
    }

    #[test]
    fn what_drains_quietly_has_converged() {
        assert_eq!(run(|_| 0.0, fade), Class::Converged);
        // Rounding and a little undershoot at the drain are no oscillation.
        assert_eq!(run(|k| -0.01 * fade(k), fade), Class::Converged);
        assert_eq!(run(|k| 1e-9 * f64::from(k % 2), fade), Class::Converged);
    }

    /// The lagged split multiplies its error by a negative factor in every step.
    #[test]
    fn swings_in_time_that_fade_are_oscillation_and_those_that_grow_are_divergence() {
        let swing = |factor: f64| move |k: i32| fade(k) + 3e3 * factor.powi(k);
        assert_eq!(run(|_| 0.0, swing(-0.9)), Class::Oscillating);
        assert_eq!(run(|_| 0.0, swing(-1.1)), Class::Diverged);
        assert!(Class::Oscillating.is_stable() && !Class::Diverged.is_stable());
    }

    /// Without a stabilising storage a load that ends somewhere leaves pressures of both signs.
    #[test]
    fn swings_in_space_are_oscillation() {
        assert_eq!(run(|k| -0.4 * fade(k), fade), Class::Oscillating);
        // One step of it is the start, not the scheme.
        let once = |k: i32| if k < 2 { -0.4 * fade(k) } else { 0.0 };
        assert_eq!(run(once, fade), Class::Converged);
    }

    /// Half a strip footing on next to undrained clay, with steps a hundred times shorter than
    /// Δx²/6 c_v; its pressure is on both sides of zero unless a stabilising storage calms it.
    fn footing(stabilisation: &str) -> Class {
        let overrides = [
            "geometry.spacing=0.4",
            "time={end=120, step=6}",
            "output={times=[], plots=false}",
            stabilisation,
        ];
        let overrides: Vec<String> = overrides.map(str::to_owned).into();
        let scene = crate::cases::find("footing").unwrap().scene;
        let nowhere = std::path::Path::new("");
        let loaded = crate::scene::load_str("footing", scene, nowhere, &overrides).unwrap();
        let plan = crate::plan::resolve(&loaded, "footing").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let mut writer = crate::run::Writer::create(folder.path(), "").unwrap();
        let interrupt = crate::run::Interrupt::default();
        crate::run::run(&plan, Some(&mut writer), &mut (), &interrupt).unwrap();
        let mut row = Row::unmeasured(String::new(), 0, Status::Done, String::new());
        row.fields = profile::fields(folder.path(), profile::RecordedOutput::Extremes);
        assert_eq!(row.fields.len(), 2);
        Class::of(&Measured::new(Variant::default(), vec![row]))
    }

    #[test]
    fn a_footing_without_a_stabilising_storage_oscillates() {
        assert_eq!(footing("coupling.stabilisation=0"), Class::Oscillating);
        assert_eq!(footing("coupling.stabilisation=0.5"), Class::Converged);
    }
}
