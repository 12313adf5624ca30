//! Which tangent to try.

use crate::material::TangentKind;
use crate::plan::DamageMethod;

/// Forces out of balance, relative to all forces, from which Newton's tangent is tried.
const NEAR: f64 = 3e-2;
/// Share of a Newton step below which it has failed.
const SHORTEST: f64 = 0.05;
/// Iterations without it after it failed.
const REST: usize = 4;

/// Tries Newton's tangent near balance, and leaves it for a while where it failed.
pub struct TangentPolicy {
    method: DamageMethod,
    /// Iterations left for which it is not tried.
    pub rest: usize,
    /// How often it failed.
    pub failures: u64,
}

impl TangentPolicy {
    /// As the method asks.
    pub fn new(method: DamageMethod) -> Self {
        TangentPolicy {
            method,
            rest: 0,
            failures: 0,
        }
    }

    /// Tangent of the next iteration at a relative imbalance of forces.
    pub fn next(&mut self, imbalance: f64) -> TangentKind {
        self.rest = self.rest.saturating_sub(1);
        match self.method {
            DamageMethod::Alternate => TangentKind::Secant,
            DamageMethod::Newton if self.rest == 0 => TangentKind::Consistent,
            DamageMethod::Auto if self.rest == 0 && imbalance < NEAR => TangentKind::Consistent,
            _ => TangentKind::Bounded,
        }
    }

    /// Judges a direction by how far it led down; `None` if it did not.
    pub fn judge(&mut self, tried: TangentKind, length: Option<f64>) {
        // An indefinite tangent may lead down by next to nothing for ever.
        if tried == TangentKind::Consistent && length.is_none_or(|length| length < SHORTEST) {
            self.failed();
        }
    }

    /// Newton's tangent led nowhere.
    pub fn failed(&mut self) {
        self.failures += 1;
        self.rest = REST;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newton_is_tried_near_balance_and_rests_after_a_failure() {
        let mut policy = TangentPolicy::new(DamageMethod::Auto);
        assert_eq!(policy.next(1.0), TangentKind::Bounded);
        assert_eq!(policy.next(1e-3), TangentKind::Consistent);
        policy.failed();
        // A step of fair length is no failure, one that leads nowhere is.
        policy.rest = 0;
        policy.judge(TangentKind::Consistent, Some(0.3));
        assert_eq!(policy.next(1e-3), TangentKind::Consistent);
        policy.judge(TangentKind::Consistent, Some(1e-9));
        for _ in 1..REST {
            assert_eq!(policy.next(1e-3), TangentKind::Bounded);
        }
        assert_eq!(policy.next(1e-3), TangentKind::Consistent);
        assert_eq!(
            TangentPolicy::new(DamageMethod::Alternate).next(1e-3),
            TangentKind::Secant
        );
    }
}
