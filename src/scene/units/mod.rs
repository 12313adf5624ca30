//! Physical units: `"10 mD"`, `"1 cP"`, `"2e-10 1/Pa"`, `"3 m^2/s"` to SI values and dimensions.

mod parse;
mod table;
#[cfg(test)]
mod tests;

use std::fmt;

pub use parse::{UnitError, parse};
pub use table::{known_symbols, symbols_of};

/// Exponents of the SI base units a quantity is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct Exponents {
    /// Exponent of the metre.
    pub length: i32,
    /// Exponent of the kilogram.
    pub mass: i32,
    /// Exponent of the second.
    pub time: i32,
    /// Exponent of the kelvin.
    pub temperature: i32,
    /// Exponent of the radian, which numbers without unit are not mistaken for.
    pub angle: i32,
}

/// Named dimensions, for messages that read "found a length".
const NAMES: &[(Exponents, &str)] = &[
    (Exponents::new(0, 0, 0), "a number without unit"),
    (Exponents::new(1, 0, 0), "a length"),
    (Exponents::new(2, 0, 0), "an area"),
    (Exponents::new(3, 0, 0), "a volume"),
    (Exponents::new(0, 1, 0), "a mass"),
    (Exponents::new(0, 0, 1), "a time"),
    (Exponents::new(0, 0, -1), "a frequency"),
    (Exponents::new(-1, 0, 0), "an inverse length"),
    (Exponents::new(1, 0, -1), "a velocity"),
    (Exponents::new(1, 0, -2), "an acceleration"),
    (Exponents::new(2, 0, -1), "a flow rate per metre"),
    (Exponents::new(3, 0, -1), "a flow rate"),
    (Exponents::new(-3, 1, 0), "a density"),
    (Exponents::new(-1, 1, -2), "a pressure"),
    (Exponents::new(1, -1, 2), "an inverse pressure"),
    (Exponents::new(-1, 1, -1), "a viscosity"),
    (Exponents::new(1, 1, -2), "a force"),
    (Exponents::new(-2, 1, -2), "a force per volume"),
    (Exponents::new(2, 1, -2), "an energy"),
    (Exponents::new(2, 1, -3), "a power"),
    (Exponents::new(0, 1, -2), "an energy per area"),
    (
        Exponents {
            length: 0,
            mass: 0,
            time: 0,
            temperature: 1,
            angle: 0,
        },
        "a temperature",
    ),
    (Exponents::ANGLE, "an angle"),
];

impl Exponents {
    /// Exponents of length, mass and time, without temperature.
    pub const fn new(length: i32, mass: i32, time: i32) -> Self {
        Self {
            length,
            mass,
            time,
            temperature: 0,
            angle: 0,
        }
    }

    /// Those of an angle.
    pub const ANGLE: Self = Self {
        angle: 1,
        ..Self::new(0, 0, 0)
    };

    /// The exponents of the product of two quantities, the second one raised to `power`.
    pub const fn times(self, other: Self, power: i32) -> Self {
        Self {
            length: self.length + power * other.length,
            mass: self.mass + power * other.mass,
            time: self.time + power * other.time,
            temperature: self.temperature + power * other.temperature,
            angle: self.angle + power * other.angle,
        }
    }

    /// The dimension in words: "a pressure", or "a quantity in kg m^-4" where it has no name.
    pub fn describe(self) -> String {
        match NAMES.iter().find(|(exponents, _)| *exponents == self) {
            Some((_, name)) => (*name).to_owned(),
            None => format!("a quantity in {self}"),
        }
    }
}

impl fmt::Display for Exponents {
    /// The product of base units, readable by [`parse`]: `kg m^-1 s^-2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bases = [
            ("kg", self.mass),
            ("m", self.length),
            ("s", self.time),
            ("K", self.temperature),
            ("rad", self.angle),
        ];
        let parts: Vec<String> = bases
            .iter()
            .filter(|(_, exponent)| *exponent != 0)
            .map(|&(base, exponent)| match exponent {
                1 => base.to_owned(),
                _ => format!("{base}^{exponent}"),
            })
            .collect();
        f.write_str(
            if parts.is_empty() {
                "1".to_owned()
            } else {
                parts.join(" ")
            }
            .as_str(),
        )
    }
}
