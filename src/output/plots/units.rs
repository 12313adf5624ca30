//! Units and scale factors that make numbers on axes short.

/// How the numbers of an axis are shown: `shown = value / divisor`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shown {
    pub divisor: f64,
    /// The unit with its prefix or factor, empty for plain pure numbers.
    pub unit: String,
}

impl Shown {
    fn plain(unit: &str) -> Self {
        Self {
            divisor: 1.0,
            unit: pretty(unit),
        }
    }
}

/// SI units that take a prefix when they lead a unit with the exponent 1.
const PREFIXABLE: [&str; 8] = ["Pa", "m", "s", "N", "J", "W", "V", "Hz"];

/// Seconds in the units of time, from the longest; each is used from the given number of seconds on.
const TIMES: [(&str, f64, f64); 4] = [
    ("yr", 31_557_600.0, 63_115_200.0),
    ("d", 86_400.0, 345_600.0),
    ("h", 3_600.0, 14_400.0),
    ("min", 60.0, 1_000.0),
];

const PREFIXES: [(i32, &str); 9] = [
    (-12, "p"),
    (-9, "n"),
    (-6, "µ"),
    (-3, "m"),
    (0, ""),
    (3, "k"),
    (6, "M"),
    (9, "G"),
    (12, "T"),
];

/// Chooses prefix, unit of time or power of ten so that `largest` (in `unit`) becomes 0.1 to 1000.
pub(super) fn engineering(unit: &str, largest: f64) -> Shown {
    let largest = largest.abs();
    if !largest.is_finite() || (0.1..1000.0).contains(&largest) || largest < 1e-300 {
        return Shown::plain(unit);
    }
    if unit == "s" && largest >= 1.0 {
        return time_unit(largest);
    }
    // The small shift keeps 1000 itself, which rounding could put just below, in the higher class.
    let exponent = 3 * ((largest.log10() + 1e-12) / 3.0).floor() as i32;
    let prefix = PREFIXES.iter().find(|(power, _)| *power == exponent);
    match prefix {
        Some((_, prefix)) if takes_prefix(unit) => Shown {
            divisor: power_of_ten(exponent),
            unit: format!("{prefix}{}", pretty(unit)),
        },
        _ => {
            let unit = format!("×10{} {}", superscript(exponent), pretty(unit));
            Shown {
                divisor: power_of_ten(exponent),
                unit: unit.trim_end().to_owned(),
            }
        }
    }
}

fn power_of_ten(exponent: i32) -> f64 {
    10_f64.powi(exponent)
}

fn time_unit(seconds: f64) -> Shown {
    let unit = TIMES.iter().find(|(_, _, from)| seconds >= *from);
    unit.map_or_else(
        || Shown::plain("s"),
        |(name, length, _)| Shown {
            divisor: *length,
            unit: (*name).to_owned(),
        },
    )
}

/// A time with four digits in a handy unit, such as `2.5 h`.
pub fn readable_time(seconds: f64) -> String {
    let shown = engineering("s", seconds);
    format!("{} {}", short_number(seconds / shown.divisor), shown.unit)
}

/// A number with four significant digits and no trailing zeros.
pub(super) fn short_number(value: f64) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if size > 0.0 && !(1e-4..1e6).contains(&size) {
        let text = format!("{rounded:e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{digits}×10{}", superscript(power.parse().unwrap_or(0))).replace('-', "−");
    }
    rounded.to_string().replace('-', "−")
}

fn takes_prefix(unit: &str) -> bool {
    let lead: String = unit.chars().take_while(|c| c.is_alphabetic()).collect();
    let next = unit[lead.len()..].chars().next();
    let powered = next.is_some_and(|c| c == '^' || c.is_numeric());
    PREFIXABLE.contains(&lead.as_str()) && !powered
}

/// `J/m^2` becomes `J/m²`, `Pa s` becomes `Pa·s`.
fn pretty(unit: &str) -> String {
    let mut text = String::new();
    let mut raised = false;
    for character in unit.trim().chars() {
        match character {
            '^' => raised = true,
            '-' | '0'..='9' if raised => text.push(raise(character)),
            '*' | ' ' => (raised, _) = (false, text.push('·')),
            other => (raised, _) = (false, text.push(other)),
        }
    }
    text
}

/// `-12` becomes `⁻¹²`.
pub(super) fn superscript(number: i32) -> String {
    number.to_string().chars().map(raise).collect()
}

fn raise(character: char) -> char {
    match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => {
            let digit = character.to_digit(10).unwrap_or(0);
            char::from_u32(0x2070 + digit).unwrap_or(character)
        }
        other => other,
    }
}

/// Splits `pressure [Pa]` into name and unit; without brackets at the end the unit is empty.
pub(super) fn split_label(label: &str) -> (&str, &str) {
    let label = label.trim();
    label
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once('['))
        .map_or((label, ""), |(name, unit)| (name.trim_end(), unit.trim()))
}

/// Name and unit as they stand at an axis.
pub(super) fn axis_label(name: &str, unit: &str) -> String {
    if unit.is_empty() {
        name.to_owned()
    } else {
        format!("{name} [{unit}]")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    fn shown(unit: &str, largest: f64) -> (f64, String) {
        let Shown { divisor, unit } = engineering(unit, largest);
        (divisor, unit)
    }

    #[test]
    fn units_get_the_prefix_that_makes_the_numbers_short() {
        assert_eq!(shown("Pa", 3.2e6), (1e6, "MPa".to_owned()));
        assert_eq!(shown("Pa", -25e9), (1e9, "GPa".to_owned()));
        assert_eq!(shown("m", 2e-4).1, "µm");
        assert_eq!(shown("m/s", 2e-3).1, "mm/s");
        assert_eq!(shown("J/m^2", 1000.0), (1e3, "kJ/m²".to_owned()));
        assert_eq!(shown("m", 12.0), (1.0, "m".to_owned()));
        assert_eq!(shown("Pa s", 1e-3).1, "mPa·s");
    }

    #[test]
    fn powers_of_units_get_a_factor_and_never_a_prefix() {
        let (divisor, unit) = shown("m^2", 9.8e-13);
        assert_eq!(unit, "×10⁻¹⁵ m²");
        assert!((divisor / 1e-15 - 1.0).abs() < 1e-12);
        assert_eq!(shown("", 5e6).1, "×10⁶");
        assert_eq!(shown("kg/m^3", 2650.0).1, "×10³ kg/m³");
        assert_eq!(shown("Pa", 1e-20).1, "×10⁻²¹ Pa");
    }

    #[test]
    fn long_times_are_shown_in_calendar_units() {
        assert_eq!(readable_time(0.0), "0 s");
        assert_eq!(readable_time(9000.0), "150 min");
        assert_eq!(readable_time(36_000.0), "10 h");
        assert_eq!(readable_time(2.5e-3), "2.5 ms");
        assert_eq!(readable_time(10.0 * 31_557_600.0), "10 yr");
    }

    #[test]
    fn zero_and_non_finite_extremes_stay_in_the_base_unit() {
        for largest in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(shown("Pa", largest), (1.0, "Pa".to_owned()));
        }
    }

    #[test]
    fn labels_split_at_the_last_bracket() {
        assert_eq!(split_label("pressure [Pa]"), ("pressure", "Pa"));
        assert_eq!(split_label("p [a] [m/s]"), ("p [a]", "m/s"));
        assert_eq!(split_label("steps"), ("steps", ""));
    }

    #[test]
    fn short_numbers_have_four_digits() {
        assert_eq!(short_number(0.1 + 0.2), "0.3");
        assert_eq!(short_number(-123_456.0), "−123500");
        assert_eq!(short_number(1.5e-9), "1.5×10⁻⁹");
    }
}
