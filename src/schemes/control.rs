//! Step control: a proportional-integral controller that avoids needless changes of the step.

use serde::{Deserialize, Serialize};

use crate::plan::{StepRule, TimePlan};

/// Chooses the next step from error estimates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepControl {
    dt: f64,
    tolerance: f64,
    order: f64,
    max: f64,
    fixed: bool,
    worthwhile: f64,
    previous: Option<f64>,
}

/// Share of the step that the controller thinks possible.
const CAUTION: f64 = 0.85;
/// Share of the tolerance that the growth of steps which keep their factor aims at: errors of one sign add up. At 1 the
/// pressure in Mandel's slab was 14 tolerances off in the end, at 0.1 it is 2.5.
const AIM: f64 = 0.1;
/// Growth below which the step stays, so that the factor of the matrix can be kept.
const WORTHWHILE: f64 = 1.6;
const MOST_GROWTH: f64 = 8.0;
/// Growth after a cut where no error tells how long a step may be.
const REGROWTH: f64 = 2.0;
const MOST_CUT: f64 = 0.1;

impl StepControl {
    /// Controller for a scheme whose local error is of the given order; `first` is the first
    /// adaptive step in seconds.
    pub fn new(time: &TimePlan, order: f64, first: f64) -> Self {
        let (dt, fixed) = match time.step {
            StepRule::Fixed(dt) => (dt, true),
            StepRule::Adaptive => (first, false),
        };
        let max = time.max_step.unwrap_or(f64::INFINITY);
        StepControl {
            dt: dt.min(max),
            tolerance: time.tolerance,
            order,
            max,
            fixed,
            worthwhile: WORTHWHILE,
            previous: None,
        }
    }

    /// Steps that something else bounds: they start at `dt` and grow again after a cut, up to `max`, s.
    pub fn bounded(dt: f64, max: f64) -> Self {
        StepControl {
            dt: dt.min(max),
            tolerance: 1.0,
            order: 1.0,
            max,
            fixed: false,
            worthwhile: WORTHWHILE,
            previous: None,
        }
    }

    /// The same where the matrix changes with every step, so that none is worth keeping for it.
    pub fn restless(self) -> Self {
        StepControl {
            worthwhile: 1.0,
            ..self
        }
    }

    /// By what the step may grow, and by what it is cut if that is below 1, after an error of `scaled` tolerances.
    ///
    /// Steps that keep their factor go by this error alone. The part by its change is for steps that change every time:
    /// with it, steps of Terzaghi's column grew only once their error was 1/500 of the tolerance, and what the error rose
    /// by with the growth cut the next step.
    fn factors(&self, scaled: f64) -> [f64; 2] {
        if self.worthwhile > 1.0 {
            let allowed = CAUTION * scaled.powf(-1.0 / self.order);
            return [allowed * AIM.powf(1.0 / self.order), allowed];
        }
        let smooth = self.previous.map_or(1.0, |p: f64| p.powf(0.4 / self.order));
        let exponent = if self.previous.is_some() { 0.7 } else { 1.0 };
        [CAUTION * scaled.powf(-exponent / self.order) * smooth; 2]
    }

    /// Step to try next, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Judges a step of `tried` seconds by its error relative to the field's range; sets the next
    /// step. True accepts.
    ///
    /// A step shortened to end at a stop says nothing about whether the next could be longer.
    pub fn judge(&mut self, relative_error: Option<f64>, tried: f64) -> bool {
        let Some(error) = relative_error.filter(|_| !self.fixed) else {
            if !self.fixed && tried >= 0.999 * self.dt {
                self.dt = (REGROWTH * self.dt).min(self.max);
            }
            return true;
        };
        let scaled = if error.is_finite() {
            (error / self.tolerance).max(1e-10)
        } else {
            1e9
        };
        if scaled > 1.0 {
            self.dt = tried * (CAUTION * scaled.powf(-1.0 / self.order)).clamp(MOST_CUT, 0.7);
            self.previous = None;
            return false;
        }
        if tried < 0.999 * self.dt {
            return true;
        }
        let [growth, cut] = self.factors(scaled);
        self.previous = Some(scaled);
        if growth > self.worthwhile {
            self.dt = (self.dt * growth.min(MOST_GROWTH)).min(self.max);
        } else if cut < 1.0 {
            self.dt *= cut.max(0.5);
        }
        true
    }

    /// Cuts the step after a failure at `tried` seconds; false if that is not allowed or no longer
    /// sensible.
    pub fn cut(&mut self, tried: f64, smallest: f64) -> bool {
        if self.fixed || tried * 0.25 < smallest {
            return false;
        }
        self.dt = tried * 0.25;
        self.previous = None;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control() -> StepControl {
        StepControl {
            dt: 1.0,
            tolerance: 1e-4,
            order: 3.0,
            max: 100.0,
            fixed: false,
            worthwhile: WORTHWHILE,
            previous: None,
        }
    }

    #[test]
    fn a_step_that_is_about_right_is_kept_to_spare_a_factorisation() {
        let mut control = control();
        assert!(control.judge(Some(0.5e-4), 1.0));
        assert!((control.dt() - 1.0).abs() < 0.1 || control.dt() < 1.0);
        assert!(control.judge(Some(0.3e-4), control.dt()));
    }

    /// By hand: an error of 1/200 of the tolerance, a twentieth of what is aimed at, leaves room for steps 20^(1/3) as long.
    #[test]
    fn steps_grow_at_an_error_that_stays_well_below_the_tolerance() {
        let mut control = control();
        for _ in 0..3 {
            let before = control.dt();
            assert!(control.judge(Some(0.005e-4), before));
            let growth = CAUTION * 20.0_f64.cbrt();
            assert!((control.dt() / before - growth).abs() < 1e-12);
        }
    }

    #[test]
    fn an_error_that_rises_with_the_step_but_stays_allowed_keeps_the_step() {
        let mut control = control();
        assert!(control.judge(Some(0.001e-4), 1.0));
        let grown = control.dt();
        assert!(grown > 3.9);
        for _ in 0..5 {
            assert!(control.judge(Some(0.6e-4), control.dt()));
            assert!((control.dt() - grown).abs() < 1e-12);
        }
    }

    #[test]
    fn where_no_matrix_is_kept_the_step_grows_by_little() {
        let mut control = control().restless();
        assert!(control.judge(Some(0.3e-4), 1.0));
        assert!(control.dt() > 1.0 && control.dt() < WORTHWHILE);
    }

    #[test]
    fn a_bad_step_is_rejected_and_cut_and_a_good_one_grows_to_its_bound() {
        let mut control = control();
        assert!(!control.judge(Some(8e-4), 1.0));
        assert!((control.dt() - 0.425).abs() < 1e-12);
        for _ in 0..20 {
            assert!(control.judge(Some(1e-12), control.dt()));
        }
        assert!((control.dt() - 100.0).abs() < 1e-12);
    }
}
