//! The transient of two layers by inverting its Laplace transform.
//!
//! Along a cotangent contour (Talbot; constants of Weideman, SIAM J. Numer. Anal. 44, 2006) the
//! midpoint rule converges like 3.9⁻ᴺ, whatever the contrast and however early the time.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::{Layer, Place};

/// Number of nodes on the whole contour; half of them are evaluated.
const NODES: u32 = 24;

/// Rise of the pressure over its initial value (Pa) at `time` (s), for given rises (Pa) at the two
/// ends.
pub(super) fn rise(layers: &[Layer; 2], rises: [f64; 2], place: Place, time: f64) -> f64 {
    let nodes = f64::from(NODES);
    let sum: f64 = (0..NODES / 2)
        .map(|node| {
            let (zeta, slope) = contour(PI * f64::from(2 * node + 1) / nodes);
            let root = (zeta * nodes).sqrt() / time.sqrt();
            let image = transform(layers, rises, place, root);
            ((zeta * nodes).exp() * image * slope / zeta).im
        })
        .sum();
    2.0 * sum / nodes
}

/// Point ζ of the contour z = N ζ/t and its derivative at an angle in (0, π).
fn contour(angle: f64) -> (Complex64, Complex64) {
    let (sine, cosine) = (0.6407 * angle).sin_cos();
    let cotangent = cosine / sine;
    let point = Complex64::new(0.5017 * angle * cotangent - 0.6122, 0.2645 * angle);
    let slope = 0.5017 * (cotangent - 0.6407 * angle / (sine * sine));
    (point, Complex64::new(slope, 0.2645))
}

/// s times the transform of the rise (Pa), with `root` = √s.
fn transform(layers: &[Layer; 2], rises: [f64; 2], place: Place, root: Complex64) -> Complex64 {
    let effusivities = layers.map(|layer| layer.effusivity());
    let alphas = layers.map(|layer| root * layer.root_time());
    // A layer's flux is e√s (V coth α − v/sinh α) for interface value V and end value v.
    let driving = [0, 1].map(|index| {
        effusivities[index] * rises[index] * 2.0 * (-alphas[index]).exp() / decay(alphas[index])
    });
    let yielding = [0, 1].map(|index| {
        let alpha = alphas[index];
        effusivities[index] * (1.0 + (-2.0 * alpha).exp()) / decay(alpha)
    });
    let interface = (driving[0] + driving[1]) / (yielding[0] + yielding[1]);
    let Place { layer, depth } = place;
    let from_end = sinh_ratio(alphas[layer], 1.0 - depth, depth);
    rises[layer] * from_end + interface * sinh_ratio(alphas[layer], depth, 1.0 - depth)
}

/// sinh(fα)/sinh(α) for 0 ≤ f ≤ 1. The `rest` 1 − f is given too, because at an early time the
/// digits lost in forming it here would be seen.
fn sinh_ratio(alpha: Complex64, fraction: f64, rest: f64) -> Complex64 {
    (-alpha * rest).exp() * decay(alpha * fraction) / decay(alpha)
}

/// 1 − e⁻²ᵅ without cancellation at small α.
fn decay(alpha: Complex64) -> Complex64 {
    let Complex64 { re, im } = -2.0 * alpha;
    let half_sine = (0.5 * im).sin();
    let real = re.exp_m1() * im.cos() - 2.0 * half_sine * half_sine;
    -Complex64::new(real, re.exp() * im.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_space(mobility: f64, storage: f64) -> [Layer; 2] {
        let thick = Layer {
            thickness: 1e3,
            mobility,
            storage,
        };
        [
            thick,
            Layer {
                thickness: 1.0,
                ..thick
            },
        ]
    }

    /// Far from the other boundary the rise is erfc(x/2√(Dt)); erfc(½) and erfc(1) from tables.
    #[test]
    fn a_thick_layer_behaves_like_a_half_space() {
        let column = half_space(3.0, 0.5);
        for (similarity, expected) in [
            (0.5, 0.479_500_122_186_953_5),
            (1.0, 0.157_299_207_050_285_13),
        ] {
            for time in [1e-12, 1e-3, 2.0] {
                let depth = 2.0 * similarity * (6.0_f64 * time).sqrt() / 1e3;
                let found = rise(&column, [1.0, 0.0], Place { layer: 0, depth }, time);
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{time}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn the_ratio_of_sinhs_neither_cancels_nor_overflows() {
        let small = Complex64::new(1e-9, 2e-9);
        assert!((sinh_ratio(small, 0.25, 0.75) - 0.25).norm() < 1e-15);
        let moderate = Complex64::new(0.8, 1.1);
        let expected = (moderate * 0.3).sinh() / moderate.sinh();
        assert!((sinh_ratio(moderate, 0.3, 0.7) - expected).norm() < 1e-14);
        assert!(sinh_ratio(Complex64::new(1e6, 1e6), 0.5, 0.5).norm() < 1e-300);
    }

    #[test]
    fn a_constant_transform_gives_a_constant() {
        let column = half_space(1.0, 1.0);
        let found = rise(
            &column,
            [2.5, 2.5],
            Place {
                layer: 1,
                depth: 0.0,
            },
            7.0,
        );
        assert!((found - 2.5).abs() < 1e-12, "{found}");
    }
}
