//! Where the marks of an axis stand and what they say.

use super::units::{short_number, superscript};

/// Mantissas of the labelled marks of an axis of less than two decades.
const MANTISSAS: [f64; 3] = [1.0, 2.0, 5.0];

/// A labelled mark.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub label: String,
}

/// At most `most + 1` marks at multiples of 1, 2 or 5 times a power of ten, within the range.
pub(super) fn linear(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let raw = (high - low) / most.max(1) as f64;
    if !raw.is_finite() || raw <= 0.0 {
        return Vec::new();
    }
    let magnitude = 10_f64.powf(raw.log10().floor());
    let nice = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|f| f * magnitude >= raw * (1.0 - 1e-9));
    let step = nice.unwrap_or(10.0) * magnitude;
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 17.0) as usize;
    let (first, last) = ((low / step - 1e-6).ceil(), (high / step + 1e-6).floor());
    let count = (last - first + 1.0).clamp(0.0, 1000.0) as usize;
    let tick = |index: usize| {
        let at = (first + index as f64) * step;
        Tick {
            at,
            label: decimal(at, decimals),
        }
    };
    (0..count).map(tick).collect()
}

/// Marks at both ends of a range too short for marks at round numbers.
pub(super) fn ends(low: f64, high: f64) -> Vec<Tick> {
    [low, high]
        .map(|at| Tick {
            at,
            label: short_number(at),
        })
        .to_vec()
}

/// Marks at powers of ten, thinned to at most `most + 1`; short ranges also get 2 and 5 times those,
/// and very short ones the marks of a linear axis. Both limits must be positive.
pub(super) fn logarithmic(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let (first, last) = decades(low, high);
    let count = last - first + 1;
    if count >= 3 {
        let stride = ((count - 1) as usize).div_ceil(most.max(1)).max(1);
        let plain = first >= -3 && last <= 3;
        let label = |power: i32| {
            if plain {
                decimal(10_f64.powi(power), (-power).max(0) as usize)
            } else {
                ten(power)
            }
        };
        let powers = (first..=last).step_by(stride);
        return powers
            .map(|power| Tick {
                at: 10_f64.powi(power),
                label: label(power),
            })
            .collect();
    }
    let mut ticks = Vec::new();
    for power in first - 1..=last {
        for mantissa in MANTISSAS {
            let at = mantissa * 10_f64.powi(power);
            if at >= low * (1.0 - 1e-9) && at <= high * (1.0 + 1e-9) {
                ticks.push(Tick {
                    at,
                    label: scientific(mantissa, power),
                });
            }
        }
    }
    if ticks.len() >= 3 {
        ticks
    } else {
        linear(low, high, most)
    }
}

/// The unlabelled marks at 2 to 9 times the powers of ten; none if they would blur.
pub(super) fn logarithmic_minor(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = decades(low, high);
    if last - first > 9 {
        return Vec::new();
    }
    let all = (first - 1..=last)
        .flat_map(|power| (2..10).map(move |m| f64::from(m) * 10_f64.powi(power)));
    all.filter(|at| (low..=high).contains(at)).collect()
}

fn decades(low: f64, high: f64) -> (i32, i32) {
    (
        (low.log10() - 1e-9).ceil() as i32,
        (high.log10() + 1e-9).floor() as i32,
    )
}

fn ten(power: i32) -> String {
    format!("10{}", superscript(power))
}

fn scientific(mantissa: f64, power: i32) -> String {
    if (-3..=3).contains(&power) {
        return decimal(mantissa * 10_f64.powi(power), (-power).max(0) as usize);
    }
    if mantissa > 1.5 {
        format!("{mantissa}×{}", ten(power))
    } else {
        ten(power)
    }
}

/// Fixed decimals with a true minus sign, and no minus before zero.
fn decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().any(|c| ('1'..='9').contains(&c)) => format!("−{digits}"),
        Some(digits) => digits.to_owned(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn linear_marks_are_round_and_cover_the_range() {
        assert_eq!(
            labels(&linear(0.0, 1.0, 5)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(labels(&linear(-3.0, 12.0, 4)), ["0", "5", "10"]);
        assert_eq!(labels(&linear(-0.05, 0.05, 2)), ["−0.05", "0.00", "0.05"]);
    }

    #[test]
    fn labels_differ_even_for_a_narrow_range_far_from_zero() {
        let ticks = linear(1_000_000.0, 1_000_000.001, 5);
        let mut unique = labels(&ticks);
        unique.dedup();
        assert!(ticks.len() >= 3 && unique.len() == ticks.len(), "{ticks:?}");
    }

    #[test]
    fn the_number_of_marks_is_bounded() {
        for most in 1..12 {
            for (low, high) in [(0.0, 1.0), (-7.3, 19.1), (3.0, 3.001), (-1e-9, 4e-9)] {
                assert!(
                    linear(low, high, most).len() <= most + 1,
                    "{low} {high} {most}"
                );
            }
            assert!(logarithmic(1e-12, 1e7, most).len() <= most + 1);
        }
    }

    #[test]
    fn logarithmic_marks_are_powers_of_ten() {
        assert_eq!(
            labels(&logarithmic(1e-6, 1e-2, 6)),
            ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"]
        );
        assert_eq!(labels(&logarithmic(0.1, 10.0, 6)), ["0.1", "1", "10"]);
        assert_eq!(
            labels(&logarithmic(2e5, 3e6, 6)),
            ["2×10⁵", "5×10⁵", "10⁶", "2×10⁶"]
        );
    }

    #[test]
    fn a_range_within_one_decade_still_has_marks() {
        assert!(logarithmic(3.1, 4.4, 5).len() >= 2);
    }

    #[test]
    fn impossible_ranges_have_no_marks() {
        assert!(linear(1.0, 1.0, 5).is_empty());
        assert!(linear(0.0, f64::NAN, 5).is_empty());
    }
}
