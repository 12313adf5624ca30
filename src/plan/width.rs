//! What a crack takes when the band of broken points is as wide as the horizon makes it.

use super::DamagePlan;

/// Widths of the band, over the length scale, at which the fracture energy is taken for right.
const FAIR: std::ops::RangeInclusive<f64> = 0.8..=1.25;

/// Width 2δ of the broken band over the length scale ℓ, for a horizon δ of `delta` m: the share of
/// G_c that a crack takes unless it is normalised.
pub fn damage_width(delta: f64, damage: &DamagePlan) -> f64 {
    2.0 * delta / damage.length_scale
}

/// A warning if cracks take much more or less than the fracture energy; `width` is
/// [`damage_width`].
pub fn width_warning(width: f64, damage: &DamagePlan) -> Option<String> {
    (!damage.normalise && !FAIR.contains(&width)).then(|| {
        format!(
            "a crack takes 2δ/ℓ = {width:.1} times the fracture energy; set damage.normalise = \
             true, or tie the horizon to ℓ with horizon.length_scale_ratio = 0.5"
        )
    })
}
