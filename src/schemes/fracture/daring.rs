//! Which tangent to try.

use crate::material::Softening;
use crate::plan::DamageMethod;

/// Forces out of balance, relative to all forces, from which Newton's tangent is tried.
const NEAR: f64 = 3e-2;
/// Share of a Newton step below which it has failed.
const SHORTEST: f64 = 0.05;
/// Iterations without it after it failed.
const REST: usize = 4;

/// Tries Newton's tangent near balance, and leaves it for a while where it failed.
pub struct Daring {
    method: DamageMethod,
    /// Iterations left for which it is not tried.
    pub rest: usize,
    /// How often it failed.
    pub failures: u64,
}

impl Daring {
    /// As the method asks.
    pub fn new(method: DamageMethod) -> Self {
        Daring {
            method,
            rest: 0,
            failures: 0,
        }
    }

    /// Tangent of the next iteration at a relative imbalance of forces.
    pub fn next(&mut self, imbalance: f64) -> Softening {
        self.rest = self.rest.saturating_sub(1);
        match self.method {
            DamageMethod::Alternate => Softening::Fixed,
            DamageMethod::Newton if self.rest == 0 => Softening::Exact,
            DamageMethod::Auto if self.rest == 0 && imbalance < NEAR => Softening::Exact,
            _ => Softening::Bounded,
        }
    }

    /// Judges a direction by how far it led down; `None` if it did not.
    pub fn judge(&mut self, tried: Softening, length: Option<f64>) {
        // An indefinite tangent may lead down by next to nothing for ever.
        if tried == Softening::Exact && length.is_none_or(|length| length < SHORTEST) {
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
        let mut daring = Daring::new(DamageMethod::Auto);
        assert_eq!(daring.next(1.0), Softening::Bounded);
        assert_eq!(daring.next(1e-3), Softening::Exact);
        daring.failed();
        // A step of fair length is no failure, one that leads nowhere is.
        daring.rest = 0;
        daring.judge(Softening::Exact, Some(0.3));
        assert_eq!(daring.next(1e-3), Softening::Exact);
        daring.judge(Softening::Exact, Some(1e-9));
        for _ in 1..REST {
            assert_eq!(daring.next(1e-3), Softening::Bounded);
        }
        assert_eq!(daring.next(1e-3), Softening::Exact);
        assert_eq!(
            Daring::new(DamageMethod::Alternate).next(1e-3),
            Softening::Fixed
        );
    }
}
