//! The exponential integral E₁.

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Beyond this argument e⁻ˣ is zero in double precision.
const UNDERFLOW: f64 = 750.0;

/// Exponential integral E₁(x) = ∫ₓ^∞ e⁻ᵗ/t dt, to about 1e-15 of its value.
///
/// Power series (DLMF 6.6.2) up to 1, continued fraction (DLMF 6.9.1) beyond. Infinite at 0, NaN
/// below 0 (and for NaN), 0 where the value underflows.
#[must_use]
pub fn exponential_integral(x: f64) -> f64 {
    if x.is_nan() || x < 0.0 {
        f64::NAN
    } else if x <= 1.0 {
        series(x)
    } else if x > UNDERFLOW {
        0.0
    } else {
        (-x).exp() * continued_fraction(x)
    }
}

/// −γ − ln x − Σ (−x)ᵏ/(k·k!).
fn series(x: f64) -> f64 {
    let mut sum = 0.0;
    let mut power = 1.0;
    for k in 1..=30 {
        let k = f64::from(k);
        power *= -x / k;
        sum += power / k;
        if power.abs() < 1e-18 * x {
            break;
        }
    }
    -EULER_GAMMA - x.ln() - sum
}

/// eˣ E₁(x) = 1/(x+1−1/(x+3−4/(x+5−…))), by the ratio form of Steed's forward recurrence.
fn continued_fraction(x: f64) -> f64 {
    let mut denominator = x + 1.0;
    let mut reciprocal = 1.0 / denominator;
    let mut increment = reciprocal;
    let mut value = reciprocal;
    for k in 1..=500 {
        let numerator = -f64::from(k * k);
        denominator += 2.0;
        reciprocal = 1.0 / (denominator + numerator * reciprocal);
        increment *= denominator * reciprocal - 1.0;
        value += increment;
        if increment.abs() <= 1e-17 * value {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_tabulated_values_to_1e_13() {
        let table = [
            (1e-12, 27.053805451028015),
            (0.01, 4.037_929_576_538_114),
            (0.1, 1.8229239584193907),
            (0.5, 0.559_773_594_776_160_8),
            (1.0, 0.21938393439552027),
            (1.5, 0.10001958240663265),
            (2.0, 0.04890051070806112),
            (5.0, 0.0011482955912753258),
            (10.0, 4.156_968_929_685_325e-6),
            (50.0, 3.783264029550459e-24),
            (500.0, 1.4220767822536384e-220),
        ];
        for (x, expected) in table {
            let found = exponential_integral(x);
            assert!(
                (found / expected - 1.0).abs() < 1e-13,
                "E1({x}) = {found}, not {expected}"
            );
        }
    }

    #[test]
    fn the_two_expansions_meet_at_their_border() {
        let (below, above) = (series(1.0), (-1.0_f64).exp() * continued_fraction(1.0));
        assert!((below / above - 1.0).abs() < 2e-15, "{below} {above}");
    }

    #[test]
    fn the_derivative_is_minus_exp_over_x() {
        for x in [0.003, 0.4, 1.7, 12.0] {
            let h = 1e-4 * x;
            let slope = (exponential_integral(x + h) - exponential_integral(x - h)) / (2.0 * h);
            let expected = -(-x).exp() / x;
            assert!(
                (slope / expected - 1.0).abs() < 1e-6,
                "x = {x}: {slope} {expected}"
            );
        }
    }

    #[test]
    fn the_ends_of_the_range_are_quiet() {
        assert!(exponential_integral(0.0).is_infinite());
        assert!(exponential_integral(-1.0).is_nan());
        assert!(exponential_integral(f64::NAN).is_nan());
        assert!(exponential_integral(1e4).abs() < f64::MIN_POSITIVE);
        assert!(exponential_integral(f64::INFINITY).abs() < f64::MIN_POSITIVE);
    }
}
