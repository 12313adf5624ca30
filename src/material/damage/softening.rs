//! How damage grows with what drives it: g = (1 − s)^m for m = 2 (the paper) and 3/2.
//!
//! All are minimisers s of g(s) X + c s² for a drive X and a strength c, J/m³.

use serde::Serialize;

/// Exponent m of the degradation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Exponent {
    /// 3/2: what a crack takes is used up where rock breaks (98.8 % at X = 10 c; 90.9 % with 2).
    ThreeHalves,
    /// 2, Eq. 25.
    Two,
}

impl Exponent {
    /// m.
    pub fn value(self) -> f64 {
        match self {
            Exponent::ThreeHalves => 1.5,
            Exponent::Two => 2.0,
        }
    }

    /// Damage s at a drive X ≥ 0.
    pub fn damage(self, drive: f64, toughness: f64) -> f64 {
        match self {
            Exponent::Two => drive / (drive + toughness),
            Exponent::ThreeHalves => 1.0 - root(drive / toughness).powi(2),
        }
    }

    /// The drive X that leads to a damage.
    pub fn drive(self, damage: f64, toughness: f64) -> f64 {
        match self {
            Exponent::Two => damage / (1.0 - damage) * toughness,
            Exponent::ThreeHalves => 4.0 * toughness * damage / (3.0 * (1.0 - damage).sqrt()),
        }
    }

    /// (1 − s)^m.
    pub fn integrity(self, damage: f64) -> f64 {
        match self {
            Exponent::Two => (1.0 - damage).powi(2),
            Exponent::ThreeHalves => (1.0 - damage).max(0.0).powf(1.5),
        }
    }

    /// −d(1 − s)^m/dX, m³/J.
    pub fn softening(self, drive: f64, toughness: f64) -> f64 {
        match self {
            Exponent::Two => 2.0 * (1.0 - self.damage(drive, toughness)).powi(3) / toughness,
            Exponent::ThreeHalves => {
                // dr/dx = −1.5 r/R.
                let x = drive / toughness;
                4.5 * root(x).powi(3) / (long(x) * toughness)
            }
        }
    }
}

/// R = √(2.25 x² + 16) with x = X/c.
fn long(x: f64) -> f64 {
    (2.25 * x * x + 16.0).sqrt()
}

/// r = √(1 − s) = (R − 1.5 x)/4, written without a difference of large numbers.
fn root(x: f64) -> f64 {
    4.0 / (long(x) + 1.5 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The energy g X + c s² is smallest at the damage, softening is the derivative of the integrity, and the
    /// drive leads back.
    #[test]
    fn damage_minimises_the_energy_and_softening_is_a_derivative() {
        let c = 450.0;
        for exponent in [Exponent::ThreeHalves, Exponent::Two] {
            for x in [0.0, 0.01, 0.3, 1.0, 7.0, 1e3, 1e6] {
                let drive = x * c;
                let damage = exponent.damage(drive, c);
                let energy = |s: f64| exponent.integrity(s) * drive + c * s * s;
                for off in [-1e-3, 1e-3] {
                    let other = (damage + off).clamp(0.0, 1.0);
                    assert!(energy(other) >= energy(damage), "{exponent:?} {x}");
                }
                let step = 1e-4 * (drive + c);
                let at = |x: f64| exponent.integrity(exponent.damage(x, c));
                let slope = (at((drive - step).max(0.0)) - at(drive + step))
                    / (drive + step - (drive - step).max(0.0));
                let exact = exponent.softening(drive, c);
                let off = if x > 0.0 { 1e-4 } else { 1e-3 };
                assert!(exact > 0.0, "{exponent:?} {x}");
                // Beyond, rounding of 1 − s is all of a difference.
                if x < 1e5 {
                    assert!((slope - exact).abs() <= off * exact, "{exponent:?} {x}");
                    assert!((exponent.drive(damage, c) - drive).abs() <= 1e-6 * (drive + c));
                }
            }
        }
    }

    /// Exponent 3/2, maximum of g √(2X) by hand: a bar of modulus E peaks at 0.573 √(E c) at D = 0.451 c, s = 0.286.
    #[test]
    fn a_bar_with_the_exponent_three_halves_peaks_where_the_closed_form_says() {
        let stress = |x: f64| {
            let exponent = Exponent::ThreeHalves;
            exponent.integrity(exponent.damage(x, 1.0)) * (2.0 * x).sqrt()
        };
        let places = (1..20_000).map(|k| f64::from(k) * 1e-4);
        let peak = places.max_by(|a, b| stress(*a).total_cmp(&stress(*b)));
        let peak = peak.unwrap_or(0.0);
        assert!((peak - 0.451).abs() < 2e-3, "{peak}");
        assert!((stress(peak) - 0.573).abs() < 1e-3, "{}", stress(peak));
        assert!((Exponent::ThreeHalves.damage(peak, 1.0) - 0.286).abs() < 2e-3);
    }
}
