//! What the unit parser reads, and what it refuses.
#![allow(clippy::float_cmp)]

use proptest::prelude::*;

use super::parse::parse;
use super::table;
use super::{Exponents, known_symbols};

fn si(text: &str) -> (f64, Exponents) {
    let (value, exponents) = parse(text).unwrap();
    (value, exponents.unwrap_or_default())
}

#[test]
fn units_convert_to_the_defined_values() {
    let table: &[(&str, f64, Exponents)] = &[
        ("3 m", 3.0, Exponents::new(1, 0, 0)),
        ("35 mm", 0.035, Exponents::new(1, 0, 0)),
        ("7\u{b5}m", 7e-6, Exponents::new(1, 0, 0)),
        ("7 \u{3bc}m", 7e-6, Exponents::new(1, 0, 0)),
        ("2 km", 2e3, Exponents::new(1, 0, 0)),
        ("1 D", 9.869233e-13, Exponents::new(2, 0, 0)),
        ("1 mD", 9.869233e-16, Exponents::new(2, 0, 0)),
        ("1 darcy", 9.869233e-13, Exponents::new(2, 0, 0)),
        ("1 cP", 1e-3, Exponents::new(-1, 1, -1)),
        ("1 P", 0.1, Exponents::new(-1, 1, -1)),
        ("1e-3 Pa s", 1e-3, Exponents::new(-1, 1, -1)),
        ("1 mPa*s", 1e-3, Exponents::new(-1, 1, -1)),
        ("1 Pa.s", 1.0, Exponents::new(-1, 1, -1)),
        ("1 Pa\u{b7}s", 1.0, Exponents::new(-1, 1, -1)),
        ("10 GPa", 1e10, Exponents::new(-1, 1, -2)),
        ("1 bar", 1e5, Exponents::new(-1, 1, -2)),
        ("1 psi", 6894.757293168361, Exponents::new(-1, 1, -2)),
        ("2e-10 1/Pa", 2e-10, Exponents::new(1, -1, 2)),
        ("2e-10/Pa", 2e-10, Exponents::new(1, -1, 2)),
        ("2 1/GPa", 2e-9, Exponents::new(1, -1, 2)),
        ("2 Pa^-1", 2.0, Exponents::new(1, -1, 2)),
        ("2 Pa\u{207b}\u{b9}", 2.0, Exponents::new(1, -1, 2)),
        ("100 J/m^2", 100.0, Exponents::new(0, 1, -2)),
        ("3 m\u{b3}/s", 3.0, Exponents::new(3, 0, -1)),
        ("3 m3/d", 3.0 / 86400.0, Exponents::new(3, 0, -1)),
        ("6 L/min", 1e-4, Exponents::new(3, 0, -1)),
        ("-9.81 m s-2", -9.81, Exponents::new(1, 0, -2)),
        ("1000 kg/m^3", 1000.0, Exponents::new(-3, 1, 0)),
        ("1 g/cm^3", 1000.0, Exponents::new(-3, 1, 0)),
        ("1 kg/(m s^2)", 1.0, Exponents::new(-1, 1, -2)),
        ("1 kg/m/s", 1.0, Exponents::new(-1, 1, -1)),
        ("2 h", 7200.0, Exponents::new(0, 0, 1)),
        ("1 a", 365.25 * 86400.0, Exponents::new(0, 0, 1)),
        ("15 %", 0.15, Exponents::default()),
        ("5 (m/s)^2", 5.0, Exponents::new(2, 0, -2)),
        (" 12 ", 12.0, Exponents::default()),
        ("1.5e3", 1500.0, Exponents::default()),
        (".5 m", 0.5, Exponents::new(1, 0, 0)),
    ];
    for &(text, value, exponents) in table {
        let (found, dimension) = si(text);
        assert!(
            (found - value).abs() <= 4e-16 * value.abs(),
            "{text}: {found} != {value}"
        );
        assert_eq!(dimension, exponents, "{text}");
    }
    assert_eq!(si("35 mm").0, 0.035);
}

#[test]
fn a_mistake_is_named_and_a_remedy_offered() {
    let table = [
        ("3 meter", "unknown unit `meter`", None),
        ("3 Mpa", "unknown unit `Mpa`", Some("did you mean `MPa`?")),
        ("3 mins", "unknown unit `mins`", Some("did you mean `min`?")),
        (
            "3 darcys",
            "unknown unit `darcys`",
            Some("did you mean `darcy`?"),
        ),
        ("1,5 m", "a comma", Some("write a point")),
        ("kg", "expected a number", None),
        ("", "expected a number", None),
        ("inf", "not a finite number", None),
        ("nan", "not a finite number", None),
        ("1e999 m", "not a finite number", None),
        ("1 W/m K", "two ways", Some("parentheses")),
        ("1 kg/m*s", "two ways", Some("parentheses")),
        ("1 m^0.5", "exponent", None),
        ("1 m^", "exponent", None),
        ("1 m^99", "exponent", None),
        ("1 (m", "cannot read the unit", None),
        ("1 m)", "cannot read the unit", None),
        ("1 000 Pa", "cannot read the unit", None),
        ("1 m/", "cannot read the unit", None),
    ];
    for (text, message, help) in table {
        let error = parse(text).unwrap_err();
        assert!(error.to_string().contains(message), "{text}: {error}");
        if let Some(help) = help {
            assert!(
                error.help().unwrap().contains(help),
                "{text}: {:?}",
                error.help()
            );
        }
    }
}

#[test]
fn no_two_units_share_a_symbol() {
    let mut all: Vec<String> = known_symbols();
    all.sort();
    let hidden: Vec<&str> = all
        .windows(2)
        .filter(|pair| pair[0] == pair[1])
        .map(|pair| pair[0].as_str())
        .collect();
    // The kilogram stands in the table by itself, so that it converts without rounding.
    assert_eq!(hidden, ["kg"]);
}

proptest! {
    #[test]
    fn any_number_with_any_unit_scales_linearly(number in -1e6_f64..1e6, index in 0_usize..400) {
        let symbols = known_symbols();
        let symbol = &symbols[index % symbols.len()];
        let unit = table::lookup(symbol).unwrap();
        let (value, exponents) = parse(&format!("{number:e} {symbol}")).unwrap();
        prop_assert_eq!(value, number * unit.multiply / unit.divide);
        prop_assert_eq!(exponents, Some(unit.exponents));
        let (inverse, opposite) = parse(&format!("1/{symbol}")).unwrap();
        prop_assert!((inverse * unit.multiply / unit.divide - 1.0).abs() < 1e-14);
        prop_assert_eq!(opposite, Some(Exponents::default().times(unit.exponents, -1)));
    }

    #[test]
    fn the_written_dimension_reads_back(l in -9..=9, m in -9..=9, t in -9..=9) {
        let exponents = Exponents::new(l, m, t);
        let (_, found) = parse(&format!("1 {exponents}")).unwrap();
        prop_assert_eq!(found.unwrap_or_default(), exponents);
    }

    #[test]
    fn no_text_makes_the_parser_panic(text in "\\PC{0,24}") {
        let _ = parse(&text);
    }

    #[test]
    fn no_text_of_unit_characters_makes_the_parser_panic(text in "[0-9eE.+^*/() mPaskD\u{b2}\u{207b}-]{0,24}") {
        let _ = parse(&text);
    }
}
