//! What a crack takes when the band of broken points is as wide as the horizon makes it.

use super::{DamagePlan, Normalise};

/// Widths of the band, over the length scale, at which the fracture energy is taken for right.
const FAIR: std::ops::RangeInclusive<f64> = 0.8..=1.25;

/// Ratios δ/Δx of lattices from √5 to 2√2 and from 3 on have families nearly as wide along rows as between
/// them: widths of convex hulls over all angles are 0.87 to 0.97 of 2δ at 2.3 and 0.88 to 0.98 at 3.05, but
/// 0.53 to 0.74 at 1.9, 0.67 to 0.95 at 2.1 and 0.69 to 0.98 at 2.9. Paths of a notched square that is turned
/// by 15 to 20° against the lattice are off by 2° at 2.3 and 3.05, by 17° at 1.9, 11° at 2.1, 5° at 2.9.
const ROUND: [f64; 3] = [2.236_067_977_499_79, 2.0 * std::f64::consts::SQRT_2, 3.0];

/// Differences of δ/Δx that are rounding error.
const ROUNDING: f64 = 1e-9;

/// Width 2δ of the broken band over the length scale ℓ, for a horizon δ of `delta` m: the share of
/// G_c that a crack takes unless it is normalised.
pub fn damage_width(delta: f64, damage: &DamagePlan) -> f64 {
    2.0 * delta / damage.length_scale.unwrap_or(2.0 * delta)
}

/// A warning if cracks take much more or less than the fracture energy; `width` is
/// [`damage_width`].
pub fn width_warning(width: f64, damage: &DamagePlan) -> Option<String> {
    (damage.normalise == Normalise::Off && !FAIR.contains(&width)).then(|| {
        format!(
            "a crack takes 2δ/ℓ = {width:.1} times the fracture energy; set damage.normalise = \
             \"mean\", or tie the horizon to ℓ with horizon.length_scale_ratio = 0.5"
        )
    })
}

/// A warning if what cracks take and where they go depends on their direction to a lattice of points whose
/// horizon is `ratio` spacings.
pub fn ratio_warning(ratio: f64) -> Option<String> {
    let [low, gap, wide] = ROUND;
    let doubtful = ratio < low - ROUNDING || (gap..wide - ROUNDING).contains(&ratio);
    doubtful.then(|| {
        format!(
            "at δ/Δx = {ratio:.2} paths and toughness of cracks depend on their direction to the lattice; \
             horizon.ratio = 2.3 or 3.05 is nearly free of it (√5 to 2√2, or 3 and more)"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hulls lose their corners between 2√2 and 3, where the fourth row is not reached yet.
    #[test]
    fn ratios_whose_families_are_round_raise_no_doubt() {
        for ratio in [5.0_f64.sqrt(), 2.3, 2.8, 3.0, 3.05, 4.05] {
            assert_eq!(ratio_warning(ratio), None, "{ratio}");
        }
        for ratio in [1.9, 2.0, 2.1, 2.23, 2.83, 2.9] {
            assert!(ratio_warning(ratio).is_some(), "{ratio}");
        }
    }
}
