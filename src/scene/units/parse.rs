//! The parser of quantities: a number, then an optional product of units.
//!
//! Units are multiplied by a space, `*` or `·` and divided by `/`. A factor may carry a whole
//! exponent (`m^2`, `m2`, `m²`, `s^-1`). Nothing may be multiplied after a division without
//! parentheses, because `kg/m s` means two things to two readers.

use thiserror::Error;

use super::table::{self, Unit};
use super::{Exponents, known_symbols};
use crate::scene::suggest::closest;

/// Why a text is no quantity.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UnitError {
    /// The text does not start with a number.
    #[error("expected a number with a unit, such as \"3 m\", found \"{text}\"")]
    NoNumber {
        /// The whole text.
        text: String,
    },
    /// The number is infinite, not a number or too large for a 64-bit float.
    #[error("\"{text}\" is not a finite number")]
    NotFinite {
        /// The whole text.
        text: String,
    },
    /// A decimal comma, or a comma between thousands.
    #[error("a comma cannot stand in the number of \"{text}\"")]
    Comma {
        /// The whole text.
        text: String,
    },
    /// No unit has this symbol.
    #[error("unknown unit `{symbol}` in \"{text}\"")]
    UnknownUnit {
        /// The symbol as typed.
        symbol: String,
        /// The whole text.
        text: String,
    },
    /// A multiplication after a division, without parentheses.
    #[error("the unit in \"{text}\" can be read in two ways")]
    Ambiguous {
        /// The whole text.
        text: String,
    },
    /// An exponent that is missing, not a whole number, or beyond ±9.
    #[error("the exponent in \"{text}\" must be a whole number from -9 to 9")]
    Exponent {
        /// The whole text.
        text: String,
    },
    /// Something else that is not a product of units.
    #[error("cannot read the unit in \"{text}\" at `{rest}`")]
    Syntax {
        /// What could not be read.
        rest: String,
        /// The whole text.
        text: String,
    },
}

impl UnitError {
    /// What to do about it.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Comma { .. } => Some("write a point for decimals: \"1.5 m\"".to_owned()),
            Self::Ambiguous { .. } => {
                Some("put what is divided by in parentheses: \"kg/(m s)\"".to_owned())
            }
            Self::UnknownUnit { symbol, .. } => {
                let known = known_symbols();
                closest(symbol, known.iter().map(String::as_str))
                    .map(|unit| format!("did you mean `{unit}`?"))
            }
            _ => None,
        }
    }
}

/// Reads `"<number> <units>"`; the value in SI and its dimension.
///
/// A number without unit is returned as it is, with no dimension.
///
/// # Errors
/// [`UnitError`] says what is wrong and, by [`UnitError::help`], what to write instead.
pub fn parse(text: &str) -> Result<(f64, Option<Exponents>), UnitError> {
    let trimmed = text.trim();
    let length = number_length(trimmed);
    let (number, units) = trimmed.split_at(length);
    let Ok(number) = number.parse::<f64>() else {
        return Err(
            match trimmed
                .trim_start_matches(['+', '-'])
                .to_lowercase()
                .as_str()
            {
                "inf" | "infinity" | "nan" => UnitError::NotFinite {
                    text: text.to_owned(),
                },
                _ => UnitError::NoNumber {
                    text: text.to_owned(),
                },
            },
        );
    };
    let (value, exponents) = if units.trim().is_empty() {
        (number, None)
    } else {
        let unit = Parser { text, rest: units }.whole()?;
        (number * unit.multiply / unit.divide, Some(unit.exponents))
    };
    if value.is_finite() {
        Ok((value, exponents))
    } else {
        Err(UnitError::NotFinite {
            text: text.to_owned(),
        })
    }
}

/// Bytes of the decimal number the text starts with. An `e` belongs to it only if an exponent
/// follows, so that a unit may start with that letter.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let mut end = digits(usize::from(matches!(bytes.first(), Some(b'+' | b'-'))));
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    end
}

/// What joins a factor to the ones before it.
#[derive(Clone, Copy, PartialEq)]
enum Join {
    Times,
    Over,
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
}

impl Parser<'_> {
    fn whole(mut self) -> Result<Unit, UnitError> {
        if self.rest.starts_with(',') {
            return Err(UnitError::Comma {
                text: self.text.to_owned(),
            });
        }
        let unit = self.product()?;
        if self.rest.is_empty() {
            Ok(unit)
        } else {
            Err(self.syntax())
        }
    }

    fn product(&mut self) -> Result<Unit, UnitError> {
        let mut unit = Unit::ONE;
        let mut divided = false;
        loop {
            self.rest = self.rest.trim_start();
            if self.rest.is_empty() || self.rest.starts_with(')') {
                return Ok(unit);
            }
            let join = self.join();
            if divided && join == Join::Times {
                return Err(UnitError::Ambiguous {
                    text: self.text.to_owned(),
                });
            }
            divided |= join == Join::Over;
            let factor = self.factor()?;
            unit = unit.times(factor, if join == Join::Over { -1 } else { 1 });
        }
    }

    fn join(&mut self) -> Join {
        let join = if self.rest.starts_with('/') {
            Join::Over
        } else {
            Join::Times
        };
        if let Some(rest) = self
            .rest
            .strip_prefix(['/', '*', '.', '\u{b7}', '\u{22c5}'])
        {
            self.rest = rest.trim_start();
        }
        join
    }

    fn factor(&mut self) -> Result<Unit, UnitError> {
        let base = if let Some(rest) = self.rest.strip_prefix('(') {
            self.rest = rest;
            let unit = self.product()?;
            self.rest = self.rest.strip_prefix(')').ok_or_else(|| self.syntax())?;
            unit
        } else if let Some(rest) = self.rest.strip_prefix('1') {
            self.rest = rest;
            return Ok(Unit::ONE);
        } else {
            self.symbol()?
        };
        Ok(Unit::ONE.times(base, self.exponent()?))
    }

    fn symbol(&mut self) -> Result<Unit, UnitError> {
        let is_symbol = |c: char| (c.is_alphabetic() || c == '%') && superscript(c).is_none();
        let end = self.rest.find(|c| !is_symbol(c)).unwrap_or(self.rest.len());
        let (symbol, rest) = self.rest.split_at(end);
        if symbol.is_empty() {
            return Err(self.syntax());
        }
        self.rest = rest;
        table::lookup(symbol).ok_or_else(|| UnitError::UnknownUnit {
            symbol: symbol.to_owned(),
            text: self.text.to_owned(),
        })
    }

    /// The exponent after a factor: `^-1`, `-1`, `2` or superscripts; 1 if there is none.
    fn exponent(&mut self) -> Result<i32, UnitError> {
        let explicit = self.rest.strip_prefix('^');
        let tail = explicit.unwrap_or(self.rest);
        let end = tail
            .find(|c: char| !(c.is_ascii_digit() || c == '-' || superscript(c).is_some()))
            .unwrap_or(tail.len());
        let (digits, rest) = tail.split_at(end);
        if digits.is_empty() && explicit.is_none() {
            return Ok(1);
        }
        let plain: String = digits
            .chars()
            .map(|c| superscript(c).unwrap_or(c))
            .collect();
        let fraction = rest
            .strip_prefix('.')
            .is_some_and(|r| r.starts_with(char::is_numeric));
        self.rest = rest;
        match plain.parse::<i32>() {
            Ok(exponent) if exponent.abs() <= 9 && !fraction => Ok(exponent),
            _ => Err(UnitError::Exponent {
                text: self.text.to_owned(),
            }),
        }
    }

    fn syntax(&self) -> UnitError {
        UnitError::Syntax {
            rest: self.rest.to_owned(),
            text: self.text.to_owned(),
        }
    }
}

fn superscript(c: char) -> Option<char> {
    Some(match c {
        '\u{2070}' => '0',
        '\u{b9}' => '1',
        '\u{b2}' => '2',
        '\u{b3}' => '3',
        '\u{2074}' => '4',
        '\u{2075}' => '5',
        '\u{2076}' => '6',
        '\u{2077}' => '7',
        '\u{2078}' => '8',
        '\u{2079}' => '9',
        '\u{207b}' => '-',
        _ => return None,
    })
}
