//! Log-normal random fields, reproducible from a seed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::geometry::Vector;
use crate::parallel;

/// Number of random waves whose sum is the field; their sum is Gaussian to a few per cent.
const WAVES: usize = 256;

/// Standard normal field at `positions`, shape `(n,)`, with covariance exp(−r²/2l²) for correlation
/// length l = `correlation_length` (metres), independent from point to point without one.
fn standard_normal<const D: usize>(
    positions: &[Vector<D>],
    correlation_length: Option<f64>,
    seed: u64,
) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let Some(length) = correlation_length else {
        return positions
            .iter()
            .map(|_| random.sample(StandardNormal))
            .collect();
    };
    let waves: Vec<(Vector<D>, f64)> = (0..WAVES)
        .map(|_| {
            let wave = Vector::from_fn(|_, _| random.sample::<f64, _>(StandardNormal) / length);
            (wave, random.random_range(0.0..std::f64::consts::TAU))
        })
        .collect();
    let amplitude = (2.0 / WAVES as f64).sqrt();
    parallel::map(positions.len(), |point| {
        let own = waves
            .iter()
            .map(|(wave, phase)| (wave.dot(&positions[point]) + phase).cos());
        amplitude * own.sum::<f64>()
    })
}

/// Log-normal field median · 10^(log10_std · z), clipped to `decades` in all around the median.
pub(crate) fn log_normal<const D: usize>(
    positions: &[Vector<D>],
    median: f64,
    log10_std: f64,
    decades: f64,
    correlation_length: Option<f64>,
    seed: u64,
) -> Vec<f64> {
    let half = 0.5 * decades;
    standard_normal(positions, correlation_length, seed)
        .into_iter()
        .map(|z| median * 10_f64.powf((log10_std * z).clamp(-half, half)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(count: usize, spacing: f64) -> Vec<Vector<2>> {
        (0..count)
            .map(|i| Vector::<2>::new(i as f64 * spacing, 0.3))
            .collect()
    }

    #[test]
    fn moments_and_correlation_are_those_asked_for() {
        let positions = line(20_000, 0.5);
        let field = standard_normal(&positions, Some(1.0), 5);
        let count = field.len() as f64;
        let mean = field.iter().sum::<f64>() / count;
        let variance = field.iter().map(|z| z * z).sum::<f64>() / count;
        let lag: f64 = field
            .iter()
            .zip(&field[2..])
            .map(|(a, b)| a * b)
            .sum::<f64>()
            / count;
        assert!(mean.abs() < 0.05 && (variance - 1.0).abs() < 0.1);
        // Two points one correlation length apart.
        assert!((lag - (-0.5_f64).exp()).abs() < 0.1, "{lag}");
    }

    #[test]
    fn the_range_is_clipped_and_the_seed_decides() {
        let positions = line(2000, 0.1);
        let field = log_normal(&positions, 1e-13, 3.0, 6.0, None, 1);
        assert!(field.iter().all(|k| (0.999e-16..1.001e-10).contains(k)));
        assert!(field.iter().any(|&k| k > 0.9e-10) && field.iter().any(|&k| k < 1.1e-16));
        assert_eq!(field, log_normal(&positions, 1e-13, 3.0, 6.0, None, 1));
        assert_ne!(field, log_normal(&positions, 1e-13, 3.0, 6.0, None, 2));
    }
}
