//! Passes until forces balance, and when there is no hope of it.

use super::{DescentSettings, Stagnation, Trial};
use crate::plan::DamagePlan;
use crate::schemes::{State, StepError, StepReport};

/// What a pass starts with.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Residuals {
    /// Forces, relative to all forces.
    pub forces: f64,
    /// Fluid, relative to what moves; 0 where there is none.
    pub mass: f64,
    /// What of the latter counts as none, and what does once passes make no progress; 0 without fluid.
    pub allowed: [f64; 2],
}

/// Passes of one kind.
pub(crate) trait Passes<const D: usize> {
    /// Where a pass stands.
    type Iterate;

    /// Brings all that follows a state to it, and measures what is out of balance. `found` is what the pass before
    /// evaluated there.
    ///
    /// # Errors
    /// [`StepError`] if the state cannot be evaluated.
    fn place(
        &mut self,
        state: &mut State,
        found: Option<Trial<D>>,
        monitor: &PassMonitor,
    ) -> Result<(Self::Iterate, Residuals), StepError>;

    /// The trial of a place.
    fn trial<'a>(&self, place: &'a Self::Iterate) -> &'a Trial<D>;

    /// Refuses a step that will be rejected, however its passes end.
    ///
    /// # Errors
    /// [`StepError::DamageGrowth`].
    fn check(&self, _state: &State, _place: &Self::Iterate) -> Result<(), StepError> {
        Ok(())
    }

    /// Whether passes that go round in circles are shortened.
    fn shortens(&self) -> bool {
        false
    }

    /// Whether something has to be taken back before a place in balance is where the step ends; passes go on then.
    fn takes_back(&mut self, _place: &Self::Iterate) -> bool {
        false
    }

    /// Moves the state by one pass.
    ///
    /// # Errors
    /// [`StepError`] if the linear system is not solved.
    fn advance(
        &mut self,
        state: &mut State,
        place: Self::Iterate,
        monitor: &PassMonitor,
    ) -> Result<Advance<D>, StepError>;
}

/// What a pass did to the state.
pub(crate) enum Advance<const D: usize> {
    /// It stands where this was evaluated.
    Evaluated(Box<Trial<D>>),
    /// It moved to where nothing was evaluated yet.
    Moved,
    /// Nothing leads on from here.
    Stuck,
}

/// Passes until forces and fluid balance; gives the scale of the forces then, N.
///
/// # Errors
/// [`StepError::DamageNotConverged`] and [`StepError::SplittingNotConverged`] where they do not, and those of the passes.
pub(crate) fn converge<const D: usize, P: Passes<D>>(
    passes: &mut P,
    damage: &DamagePlan,
    state: &mut State,
    report: &mut StepReport,
) -> Result<f64, StepError> {
    let mut monitor = PassMonitor::new(damage);
    let mut found = None;
    for pass in 0..=damage.iterations {
        let (here, left) = passes.place(state, found.take(), &monitor)?;
        report.passes = pass;
        report.residual = Some(left.forces);
        let trial = passes.trial(&here);
        if monitor.accepts(&left) {
            let scale = trial.scale;
            if passes.takes_back(&here) {
                continue;
            }
            return Ok(scale);
        }
        passes.check(state, &here)?;
        let broken = trial.response.damage.iter().sum();
        if !monitor.continues(&left, broken, passes.shortens()) || pass == damage.iterations {
            break;
        }
        match passes.advance(state, here, &monitor)? {
            Advance::Evaluated(next) => found = Some(*next),
            Advance::Moved => {}
            Advance::Stuck => break,
        }
    }
    Err(monitor.failure(state.time, report.passes))
}

/// Where the passes of a step stand.
pub(crate) struct PassMonitor {
    settings: DescentSettings,
    /// Forces out of balance that count as equilibrium.
    tolerance: f64,
    /// Smallest imbalance so far.
    best: f64,
    /// Smallest share of fluid that was out of balance while forces balanced, and what was allowed.
    owed: f64,
    allowed: f64,
    /// Forces out of balance before this pass and the one before.
    imbalance: [f64; 2],
    /// Of the larger of both, forces and fluid, over what is allowed.
    stagnation: Stagnation,
    /// Passes without progress.
    stuck: usize,
    /// Damage summed over points when the crack last made progress.
    broken: f64,
    /// Share of a pass that is taken: passes that go round in circles meet where they are shortened.
    share: f64,
}

impl PassMonitor {
    /// Before the first pass.
    fn new(damage: &DamagePlan) -> Self {
        PassMonitor {
            settings: damage.descent,
            tolerance: damage.tolerance,
            best: f64::INFINITY,
            owed: f64::INFINITY,
            allowed: 0.0,
            imbalance: [f64::INFINITY; 2],
            stagnation: Stagnation::new(),
            stuck: 0,
            broken: f64::NEG_INFINITY,
            share: 1.0,
        }
    }

    /// Whether what is out of balance counts as none.
    fn accepts(&self, left: &Residuals) -> bool {
        let allowed = left.allowed[usize::from(self.is_stuck())];
        left.forces <= self.tolerance && left.mass <= allowed
    }

    /// Takes note of how far off a pass starts and of how many points' worth has broken; false once there is no hope. A
    /// crack that runs is far off for long, but breaks on.
    fn continues(&mut self, left: &Residuals, broken: f64, shortens: bool) -> bool {
        self.best = self.best.min(left.forces);
        self.imbalance = [left.forces, self.imbalance[0]];
        self.allowed = left.allowed[1];
        if left.forces <= self.tolerance {
            self.owed = self.owed.min(left.mass);
        }
        let mut stuck = self.stagnation.note(self.off(left));
        if broken >= self.broken + self.settings.damage_progress {
            self.stagnation.forgive();
            (self.broken, stuck) = (broken, 0);
        }
        if shortens && stuck > 0 && stuck.is_multiple_of(self.settings.stagnant_passes) {
            self.share = (0.5 * self.share).max(self.settings.least_relaxation);
        }
        self.stuck = stuck;
        stuck < self.settings.most_stagnant_passes
    }

    /// The larger of what is out of balance, forces and fluid, over what is allowed.
    pub(crate) fn off(&self, left: &Residuals) -> f64 {
        let mass = left.mass / left.allowed[0].max(f64::MIN_POSITIVE);
        (left.forces / self.tolerance).max(mass)
    }

    /// Whether passes have made no progress for a while.
    pub(crate) fn is_stuck(&self) -> bool {
        self.stuck >= self.settings.stagnant_passes
    }

    /// Share of a pass to take.
    pub(crate) fn share(&self) -> f64 {
        self.share
    }

    /// Forces out of balance before the pass.
    pub(crate) fn imbalance(&self) -> f64 {
        self.imbalance[0]
    }

    /// Forces out of balance, relative to those before the last pass; 0 before the first.
    pub(crate) fn contraction(&self) -> f64 {
        self.imbalance[0] / self.imbalance[1]
    }

    /// Why passes were given up.
    fn failure(&self, time: f64, iterations: usize) -> StepError {
        match self.owed.is_finite() && self.allowed > 0.0 {
            true => StepError::SplittingNotConverged {
                time,
                splitting_residual: self.owed,
                allowed: self.allowed,
                iterations,
            },
            false => StepError::DamageNotConverged {
                time,
                residual: self.best,
                tolerance: self.tolerance,
                iterations,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Setup;

    const TEXT: &str = r#"title = "A square that is pulled"
geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "100 J/m^2" }
mechanics.boundary = { left = { clamped = true }, right = { clamped = true } }
damage = {}
time.end = "1 s"
"#;

    fn fresh() -> PassMonitor {
        let plan = Setup::text(TEXT).plan().unwrap();
        PassMonitor::new(&plan.damage.unwrap())
    }

    fn off(forces: f64) -> Residuals {
        Residuals {
            forces,
            ..Residuals::default()
        }
    }

    #[test]
    fn a_step_is_given_up_without_progress_and_not_while_a_crack_runs() {
        let settings = DescentSettings::default();
        let mut monitor = fresh();
        let passes = (0..500).take_while(|_| monitor.continues(&off(1.0), 0.0, false));
        assert_eq!(passes.count(), settings.most_stagnant_passes);
        let mut monitor = fresh();
        let runs = |k: usize| k as f64 * settings.damage_progress / 50.0;
        assert!((0..500).all(|k| monitor.continues(&off(1.0), runs(k), false)));
    }

    /// Fluid that passes cannot settle is allowed more once they make no progress, and named where it is refused.
    #[test]
    fn fluid_counts_beside_forces_and_is_named_where_it_is_refused() {
        let mut monitor = fresh();
        let tolerance = monitor.tolerance;
        let wet = Residuals {
            forces: tolerance,
            mass: 3e-7,
            allowed: [1e-7, 1e-5],
        };
        assert!(!monitor.accepts(&wet) && monitor.accepts(&off(tolerance)));
        assert!(!monitor.accepts(&off(2.0 * tolerance)));
        assert!(matches!(
            monitor.failure(0.0, 0),
            StepError::DamageNotConverged { .. }
        ));
        let stuck = DescentSettings::default().stagnant_passes;
        for _ in 0..=stuck {
            monitor.continues(&wet, 0.0, true);
        }
        assert!(monitor.accepts(&wet) && monitor.share() < 1.0);
        assert!(matches!(
            monitor.failure(0.0, 0),
            StepError::SplittingNotConverged { splitting_residual, allowed, .. }
                if splitting_residual <= 3e-7 && allowed >= 1e-5
        ));
    }

    #[test]
    fn contraction_is_that_of_the_last_pass() {
        let mut monitor = fresh();
        monitor.continues(&off(1.0), 0.0, false);
        assert!(monitor.contraction() <= 0.0);
        monitor.continues(&off(0.25), 0.0, false);
        assert!((monitor.contraction() - 0.25).abs() < 1e-15);
    }
}
