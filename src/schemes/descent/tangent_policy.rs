//! Which tangent to try.

use crate::material::TangentKind;
use crate::plan::{DamageMethod, DescentSettings};

/// Tries Newton's tangent near balance, and leaves it for a while where it failed.
pub(crate) struct TangentPolicy {
    method: DamageMethod,
    settings: DescentSettings,
    /// Iterations left for which it is not tried.
    pub rest: usize,
    /// How often it failed.
    pub failures: u64,
}

impl TangentPolicy {
    /// As the method asks.
    pub(crate) fn new(method: DamageMethod, settings: DescentSettings) -> Self {
        TangentPolicy {
            method,
            settings,
            rest: 0,
            failures: 0,
        }
    }

    /// Tangent of the next iteration at a relative imbalance of forces.
    pub(crate) fn next(&mut self, imbalance: f64) -> TangentKind {
        self.rest = self.rest.saturating_sub(1);
        match self.method {
            DamageMethod::Alternate => TangentKind::Secant,
            DamageMethod::Newton if self.rest == 0 => TangentKind::Consistent,
            DamageMethod::Auto if self.rest == 0 && imbalance < self.settings.near_balance => {
                TangentKind::Consistent
            }
            _ => TangentKind::Bounded,
        }
    }

    /// Judges a direction by how far it led down; `None` if it did not.
    pub(crate) fn judge(&mut self, tried: TangentKind, length: Option<f64>) {
        // An indefinite tangent may lead down by next to nothing for ever.
        if tried == TangentKind::Consistent
            && length.is_none_or(|length| length < self.settings.least_newton_step)
        {
            self.failed();
        }
    }

    /// Newton's tangent led nowhere.
    pub(crate) fn failed(&mut self) {
        self.failures += 1;
        self.rest = self.settings.newton_rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newton_is_tried_near_balance_and_rests_after_a_failure() {
        let settings = DescentSettings::default();
        let mut policy = TangentPolicy::new(DamageMethod::Auto, settings);
        assert_eq!(policy.next(1.0), TangentKind::Bounded);
        assert_eq!(policy.next(1e-3), TangentKind::Consistent);
        policy.failed();
        // A step of fair length is no failure, one that leads nowhere is.
        policy.rest = 0;
        policy.judge(TangentKind::Consistent, Some(0.3));
        assert_eq!(policy.next(1e-3), TangentKind::Consistent);
        policy.judge(TangentKind::Consistent, Some(1e-9));
        for _ in 1..settings.newton_rest {
            assert_eq!(policy.next(1e-3), TangentKind::Bounded);
        }
        assert_eq!(policy.next(1e-3), TangentKind::Consistent);
        assert_eq!(
            TangentPolicy::new(DamageMethod::Alternate, settings).next(1e-3),
            TangentKind::Secant
        );
    }
}
