//! Checks of numbers that came from a file.

use std::path::Path;

use super::{FileError, Place, ValueFault};

/// The numbers a quantity may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Allowed {
    /// Any finite number.
    Finite,
    /// Finite and greater than zero.
    Positive,
    /// Greater than zero and not above a limit.
    Share {
        /// The limit.
        most: f64,
        /// Why it is no more.
        why: &'static str,
    },
    /// From zero to a limit.
    UpTo {
        /// The limit, allowed.
        most: f64,
        /// Why it is no more.
        why: &'static str,
    },
}

/// Fails with the first bad value and the number of them; `place` tells where an entry stands.
pub(super) fn check(
    path: &Path,
    quantity: &'static str,
    allowed: Allowed,
    values: &[f64],
    place: impl Fn(usize) -> Place,
) -> Result<(), FileError> {
    let mut faults = values
        .iter()
        .enumerate()
        .filter_map(|(index, &value)| Some((index, value, fault(value, allowed)?)));
    let Some((index, value, fault)) = faults.next() else {
        return Ok(());
    };
    Err(FileError::Value {
        path: path.to_path_buf(),
        place: place(index),
        quantity,
        value,
        fault,
        bad: 1 + faults.count(),
        total: values.len(),
    })
}

/// What is wrong with a value, if anything is.
pub(crate) fn fault(value: f64, allowed: Allowed) -> Option<ValueFault> {
    if value.is_nan() {
        return Some(ValueFault::Nan);
    }
    if value.is_infinite() {
        return Some(ValueFault::Infinite);
    }
    match allowed {
        Allowed::Positive | Allowed::Share { .. } if value <= 0.0 => Some(ValueFault::NotPositive),
        Allowed::UpTo { .. } if value < 0.0 => Some(ValueFault::Negative),
        Allowed::Share { most, why } | Allowed::UpTo { most, why } if value > most => {
            Some(ValueFault::Above { most, why })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(values: &[f64], allowed: Allowed) -> Option<(usize, ValueFault, usize)> {
        match check(Path::new("a.csv"), "volume", allowed, values, Place::Index) {
            Err(FileError::Value {
                place: Place::Index(index),
                fault,
                bad,
                ..
            }) => Some((index, fault, bad)),
            _ => None,
        }
    }

    #[test]
    fn the_first_offence_is_named_and_all_are_counted() {
        let values = [1.0, 0.0, f64::NAN, -3.0, f64::INFINITY];
        assert_eq!(
            verdict(&values, Allowed::Positive),
            Some((1, ValueFault::NotPositive, 4))
        );
        assert_eq!(
            verdict(&values, Allowed::Finite),
            Some((2, ValueFault::Nan, 2))
        );
        assert_eq!(
            verdict(&[f64::NEG_INFINITY], Allowed::Positive).unwrap().1,
            ValueFault::Infinite
        );
    }

    #[test]
    fn what_is_above_a_limit_is_told_with_it() {
        let why = "it is a share of the volume";
        let share = Allowed::Share { most: 0.8, why };
        assert_eq!(verdict(&[0.8, 1e-9], share), None);
        assert_eq!(
            verdict(&[0.2, 0.0], share).unwrap().1,
            ValueFault::NotPositive
        );
        let above = ValueFault::Above { most: 0.8, why };
        assert_eq!(verdict(&[0.9, 0.2], share), Some((0, above, 1)));
        assert!(
            above.to_string().contains("above 0.8: it is a share"),
            "{above}"
        );
        let ratio = Allowed::UpTo { most: 0.4, why };
        assert_eq!(verdict(&[0.0, 0.4], ratio), None);
        assert_eq!(verdict(&[-0.1], ratio).unwrap().1, ValueFault::Negative);
    }

    #[test]
    fn the_smallest_positive_number_is_positive_and_negative_zero_is_not() {
        assert_eq!(verdict(&[f64::from_bits(1)], Allowed::Positive), None);
        assert!(verdict(&[-0.0], Allowed::Positive).is_some());
    }
}
