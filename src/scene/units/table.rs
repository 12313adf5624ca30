//! The units and prefixes the scene language knows.

use super::Exponents;

/// A unit as a factor to SI. The factor is `multiply / divide`, both exact where they can be, so
/// that `35 mm` is the same number as `0.035`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    pub multiply: f64,
    pub divide: f64,
    pub exponents: Exponents,
}

impl Unit {
    /// The unit of plain numbers.
    pub(super) const ONE: Self = Self::si(Exponents::new(0, 0, 0));

    const fn si(exponents: Exponents) -> Self {
        Self::scaled(1.0, 1.0, exponents)
    }

    const fn scaled(multiply: f64, divide: f64, exponents: Exponents) -> Self {
        Self {
            multiply,
            divide,
            exponents,
        }
    }

    /// This unit times another one raised to a whole power.
    pub(super) fn times(self, other: Self, power: i32) -> Self {
        let (up, down) = match power {
            0.. => (other.multiply, other.divide),
            _ => (other.divide, other.multiply),
        };
        Self {
            multiply: self.multiply * up.powi(power.abs()),
            divide: self.divide * down.powi(power.abs()),
            exponents: self.exponents.times(other.exponents, power),
        }
    }
}

const LENGTH: Exponents = Exponents::new(1, 0, 0);
const AREA: Exponents = Exponents::new(2, 0, 0);
const VOLUME: Exponents = Exponents::new(3, 0, 0);
const MASS: Exponents = Exponents::new(0, 1, 0);
const TIME: Exponents = Exponents::new(0, 0, 1);
const PRESSURE: Exponents = Exponents::new(-1, 1, -2);
const VISCOSITY: Exponents = Exponents::new(-1, 1, -1);
const TEMPERATURE: Exponents = Exponents {
    length: 0,
    mass: 0,
    time: 0,
    temperature: 1,
    angle: 0,
};

/// Symbols that take no prefix.
const PLAIN: &[(&str, Unit)] = &[
    ("kg", Unit::si(MASS)),
    ("min", Unit::scaled(60.0, 1.0, TIME)),
    ("h", Unit::scaled(3600.0, 1.0, TIME)),
    ("hour", Unit::scaled(3600.0, 1.0, TIME)),
    ("hours", Unit::scaled(3600.0, 1.0, TIME)),
    ("d", Unit::scaled(86_400.0, 1.0, TIME)),
    ("day", Unit::scaled(86_400.0, 1.0, TIME)),
    ("days", Unit::scaled(86_400.0, 1.0, TIME)),
    // The Julian year of 365.25 days.
    ("a", Unit::scaled(31_557_600.0, 1.0, TIME)),
    ("yr", Unit::scaled(31_557_600.0, 1.0, TIME)),
    ("year", Unit::scaled(31_557_600.0, 1.0, TIME)),
    ("years", Unit::scaled(31_557_600.0, 1.0, TIME)),
    ("psi", Unit::scaled(6_894.757_293_168_361, 1.0, PRESSURE)),
    ("atm", Unit::scaled(101_325.0, 1.0, PRESSURE)),
    ("t", Unit::scaled(1e3, 1.0, MASS)),
    ("rad", Unit::si(Exponents::ANGLE)),
    (
        "deg",
        Unit::scaled(std::f64::consts::PI, 180.0, Exponents::ANGLE),
    ),
    ("%", Unit::scaled(1.0, 100.0, Exponents::new(0, 0, 0))),
];

/// Symbols that take an SI prefix.
const PREFIXABLE: &[(&str, Unit)] = &[
    ("m", Unit::si(LENGTH)),
    ("s", Unit::si(TIME)),
    ("g", Unit::scaled(1.0, 1e3, MASS)),
    ("K", Unit::si(TEMPERATURE)),
    ("Pa", Unit::si(PRESSURE)),
    ("N", Unit::si(Exponents::new(1, 1, -2))),
    ("J", Unit::si(Exponents::new(2, 1, -2))),
    ("W", Unit::si(Exponents::new(2, 1, -3))),
    ("Hz", Unit::si(Exponents::new(0, 0, -1))),
    ("P", Unit::scaled(1.0, 10.0, VISCOSITY)),
    ("D", Unit::scaled(9.869_233, 1e13, AREA)),
    ("darcy", Unit::scaled(9.869_233, 1e13, AREA)),
    ("bar", Unit::scaled(1e5, 1.0, PRESSURE)),
    ("L", Unit::scaled(1.0, 1e3, VOLUME)),
    ("l", Unit::scaled(1.0, 1e3, VOLUME)),
];

/// SI prefixes as `(symbol, multiply, divide)`. The micro sign exists twice in Unicode.
const PREFIXES: &[(&str, f64, f64)] = &[
    ("k", 1e3, 1.0),
    ("M", 1e6, 1.0),
    ("G", 1e9, 1.0),
    ("T", 1e12, 1.0),
    ("h", 1e2, 1.0),
    ("d", 1.0, 1e1),
    ("c", 1.0, 1e2),
    ("m", 1.0, 1e3),
    ("u", 1.0, 1e6),
    ("\u{b5}", 1.0, 1e6),
    ("\u{3bc}", 1.0, 1e6),
    ("n", 1.0, 1e9),
    ("p", 1.0, 1e12),
    ("f", 1.0, 1e15),
];

/// The unit a symbol stands for; whole symbols win over prefixed ones (`min`, `Pa`, `h`).
pub(super) fn lookup(symbol: &str) -> Option<Unit> {
    let whole = PLAIN
        .iter()
        .chain(PREFIXABLE)
        .find(|(name, _)| *name == symbol);
    if let Some(&(_, unit)) = whole {
        return Some(unit);
    }
    PREFIXES.iter().find_map(|&(prefix, multiply, divide)| {
        let base = symbol.strip_prefix(prefix)?;
        let &(_, unit) = PREFIXABLE.iter().find(|(name, _)| *name == base)?;
        Some(Unit::scaled(
            unit.multiply * multiply,
            unit.divide * divide,
            unit.exponents,
        ))
    })
}

/// Symbols, without prefixes, of units that have one of these dimensions.
pub fn symbols_of(dimensions: &[Exponents]) -> Vec<&'static str> {
    let all = PREFIXABLE.iter().chain(PLAIN);
    all.filter(|(_, unit)| dimensions.contains(&unit.exponents))
        .map(|(name, _)| *name)
        .collect()
}

/// Every unit symbol that `parse` accepts, with and without prefix.
pub fn known_symbols() -> Vec<String> {
    let whole = PLAIN
        .iter()
        .chain(PREFIXABLE)
        .map(|(name, _)| (*name).to_owned());
    let prefixed = PREFIXES.iter().flat_map(|(prefix, _, _)| {
        PREFIXABLE
            .iter()
            .map(move |(name, _)| format!("{prefix}{name}"))
    });
    whole.chain(prefixed).collect()
}
