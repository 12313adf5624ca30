//! The transient of two layers as a sum of eigenfunctions.
//!
//! An eigenfunction is A sin(r a₁ ξ) in the near layer and B sin(r a₂ ξ) in the far one, ξ being
//! the depth from the outer end; it decays like e^(−r²t). Continuity asks A sin y₁ = B sin y₂ and
//! A e₁ cos y₁ = −B e₂ cos y₂ with y = r a, hence e₁ cos y₁ sin y₂ + e₂ cos y₂ sin y₁ = 0.
//!
//! Let tan θ = (c/e) tan y in each layer, on the branch with θ = y at every multiple of π/2. Then
//! the condition reads sin(θ₁ + θ₂) = 0, and both θ grow with r: there is exactly one root for each
//! θ₁ + θ₂ = nπ, n = 1, 2, …. None can be missed and close pairs are kept apart, whatever the
//! contrast. As |θ − y| < π/2, the root lies within π of nπ in y₁ + y₂.

use std::f64::consts::PI;

use super::{Layer, Place};

/// One eigenfunction with its share of the transient.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mode {
    /// r a of each layer, rad.
    phases: [f64; 2],
    /// Amplitude in each layer, coefficient included, Pa.
    amplitudes: [f64; 2],
    /// r, 1/√s.
    root: f64,
}

impl Mode {
    /// Decay rate r², 1/s.
    pub(super) fn decay_rate(&self) -> f64 {
        self.root * self.root
    }
}

/// The slowest `count` eigenfunctions for the initial excess (Pa) over the two end pressures.
pub(super) fn modes(layers: &[Layer; 2], excess: [f64; 2], count: u32) -> Vec<Mode> {
    (1..=count)
        .map(|order| mode(layers, excess, root(layers, order)))
        .collect()
}

/// Departure from the steady state at `time`, Pa.
pub(super) fn sum(modes: &[Mode], place: Place, time: f64) -> f64 {
    let relevant = modes
        .iter()
        .take_while(|mode| mode.decay_rate() * time < super::FORGOTTEN);
    relevant
        .map(|mode| {
            let wave = (mode.phases[place.layer] * place.depth).sin();
            mode.amplitudes[place.layer] * wave * (-mode.decay_rate() * time).exp()
        })
        .sum()
}

/// The root r with θ₁ + θ₂ = `order` π, to the last bit by bisection.
fn root(layers: &[Layer; 2], order: u32) -> f64 {
    let root_times = layers.map(|layer| layer.root_time());
    let steepness = (layers[1].effusivity() / layers[0].effusivity()).sqrt();
    let surplus = |r: f64| {
        let (turns_near, rest_near) = phase(r * root_times[0], steepness);
        let (turns_far, rest_far) = phase(r * root_times[1], 1.0 / steepness);
        turns_near + turns_far - f64::from(order) + (rest_near + rest_far) / PI
    };
    let total = root_times[0] + root_times[1];
    let mut low = PI * f64::from(order - 1) / total;
    let mut high = PI * f64::from(order + 1) / total;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if surplus(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// θ with tan θ = `steepness` tan y, as whole multiples of π and a rest within ±π/2.
fn phase(y: f64, steepness: f64) -> (f64, f64) {
    let turns = (y / PI).round();
    let (sine, cosine) = (y - turns * PI).sin_cos();
    (turns, (steepness * sine).atan2(cosine))
}

/// Eigenfunction at a root, scaled by its coefficient.
///
/// With X the eigenfunction, (κX′)′ = −r²SX and the initial excess v₀ linear in each layer with a
/// flux equal in both, Green's identity leaves ∫ S v₀ X = (A e₁ v₀(0) + B e₂ v₀(L))/r. The norm is
/// ∫ S X² = ½ Σ e a A² (1 − sin 2y/2y).
fn mode(layers: &[Layer; 2], excess: [f64; 2], root: f64) -> Mode {
    let effusivities = layers.map(|layer| layer.effusivity());
    let root_times = layers.map(|layer| layer.root_time());
    let phases = root_times.map(|time| root * time);
    let shape = continuous_amplitudes(phases, effusivities);
    let end = |layer: usize| shape[layer] * effusivities[layer];
    let projection = (end(0) * excess[0] + end(1) * excess[1]) / root;
    let share = |layer: usize| {
        let weight = effusivities[layer] * root_times[layer];
        0.5 * weight * shape[layer] * shape[layer] * sine_square_mean(phases[layer])
    };
    let coefficient = projection / (share(0) + share(1));
    Mode {
        phases,
        amplitudes: shape.map(|amplitude| coefficient * amplitude),
        root,
    }
}

/// Amplitudes A, B (up to a factor) that join the layers, from the better conditioned of the
/// continuity of pressure and that of flux.
fn continuous_amplitudes(phases: [f64; 2], effusivities: [f64; 2]) -> [f64; 2] {
    let [(sine_near, cosine_near), (sine_far, cosine_far)] = phases.map(f64::sin_cos);
    // A rounding error in y changes sin y by a relative y/tan y, and cos y by y tan y.
    let pressure_noise = (phases[0] * (cosine_near / sine_near).abs())
        .max(phases[1] * (cosine_far / sine_far).abs());
    let flux_noise = (phases[0] * (sine_near / cosine_near).abs())
        .max(phases[1] * (sine_far / cosine_far).abs());
    let by_flux = flux_noise < pressure_noise;
    let shape = if by_flux {
        [effusivities[1] * cosine_far, -effusivities[0] * cosine_near]
    } else {
        [sine_far, sine_near]
    };
    let greatest = shape[0].abs().max(shape[1].abs());
    shape.map(|amplitude| amplitude / greatest)
}

/// 1 − sin 2y/2y, twice the mean of sin² over (0, y), without cancellation at small y.
fn sine_square_mean(y: f64) -> f64 {
    let double = 2.0 * y;
    if double < 0.1 {
        let square = double * double;
        square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
    } else {
        1.0 - double.sin() / double
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(mobilities: [f64; 2], storages: [f64; 2], thickness: [f64; 2]) -> [Layer; 2] {
        [0, 1].map(|index| Layer {
            thickness: thickness[index],
            mobility: mobilities[index],
            storage: storages[index],
        })
    }

    #[test]
    fn one_material_has_the_roots_of_one_layer() {
        let column = layers([4.0, 4.0], [1.0, 1.0], [0.3, 1.7]);
        for order in 1..50 {
            let expected = f64::from(order) * PI; // L√(S/κ) = 2 · ½ = 1.
            assert!(
                (root(&column, order) / expected - 1.0).abs() < 1e-14,
                "root {order}"
            );
        }
    }

    /// A fine scan of the characteristic function for changes of sign finds the same roots.
    #[test]
    fn a_scan_finds_no_other_roots() {
        for (contrast, thickness) in [
            (30.0, [0.5, 0.5]),
            (1e-3, [0.31, 0.69]),
            (400.0, [0.9, 0.1]),
        ] {
            let column = layers([contrast, 1.0], [1.0, 0.7], thickness);
            let [near, far] = column;
            let condition = |r: f64| {
                let (y, z) = (r * near.root_time(), r * far.root_time());
                near.effusivity() * y.cos() * z.sin() + far.effusivity() * z.cos() * y.sin()
            };
            let found: Vec<f64> = (1..=40).map(|order| root(&column, order)).collect();
            let (step, mut scanned, mut r) = (found[39] / 2e5, 0, found[0] / 1e3);
            while r < found[39] + 0.5 * step {
                if condition(r) * condition(r + step) <= 0.0 {
                    let near_known = found.iter().any(|f| (f - r - 0.5 * step).abs() < step);
                    assert!(near_known, "contrast {contrast}: root {r} missed");
                    scanned += 1;
                }
                r += step;
            }
            assert_eq!(scanned, 40, "contrast {contrast}");
        }
    }

    /// With a₂ = 2a₁ the condition is sin y (2e₁ cos² y + e₂ cos 2y) = 0: a root at every kπ and
    /// a pair about every (k−½)π, ±asin √(e₂/2(e₁+e₂)) from it, closer the greater the contrast.
    #[test]
    fn close_pairs_stay_apart_at_great_contrast() {
        for effusivity in [1.0, 1e4, 1e6, 1e12] {
            let column = layers([effusivity, 1.0], [effusivity, 1.0], [1.0, 2.0]);
            let offset = (0.5 / (1.0 + effusivity)).sqrt().asin();
            for period in 0..20_u32 {
                let middle = (f64::from(period) + 0.5) * PI;
                let expected = [middle - offset, middle + offset, middle + 0.5 * PI];
                for (order, expected) in (3 * period + 1..).zip(expected) {
                    let found = root(&column, order);
                    let error = (found - expected).abs();
                    assert!(
                        error < 1e-15 * (expected + 1.0),
                        "{effusivity} {order}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn eigenfunctions_are_continuous_in_pressure_and_flux() {
        for contrast in [1.0, 1e3, 1e-3, 1e6] {
            let column = layers([contrast, 1.0], [1.0, 0.4], [0.3, 0.7]);
            for mode in modes(&column, [-1.0, 0.5], 50) {
                let [(s0, c0), (s1, c1)] = mode.phases.map(f64::sin_cos);
                let [a, b] = mode.amplitudes;
                let jump = (a * s0 - b * s1).abs() / a.abs().max(b.abs());
                let [e0, e1] = column.map(|layer| layer.effusivity());
                let flux = (a * e0 * c0 + b * e1 * c1).abs() / (a * e0).abs().max((b * e1).abs());
                assert!(jump < 1e-10 && flux < 1e-10, "{contrast}: {jump} {flux}");
            }
        }
    }

    #[test]
    fn the_mean_of_the_square_sine_is_smooth_where_the_formula_changes() {
        for y in [1e-9, 1e-3, 0.049_999, 0.050_001, 0.7] {
            let steps = 20_000;
            let mean: f64 = (0..steps)
                .map(|k| (y * (f64::from(k) + 0.5) / f64::from(steps)).sin().powi(2))
                .sum::<f64>()
                / f64::from(steps);
            let ratio = sine_square_mean(y) / (2.0 * mean);
            assert!((ratio - 1.0).abs() < 1e-8, "y = {y}: {ratio}");
        }
    }
}
