//! Checks of numbers that came from a file.

use std::path::Path;

use super::{FileError, Place, ValueFault};

/// The numbers a quantity may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Allowed {
    /// Any finite number.
    Finite,
    /// Finite and greater than zero.
    Positive,
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

fn fault(value: f64, allowed: Allowed) -> Option<ValueFault> {
    if value.is_nan() {
        Some(ValueFault::Nan)
    } else if value.is_infinite() {
        Some(ValueFault::Infinite)
    } else {
        (allowed == Allowed::Positive && value <= 0.0).then_some(ValueFault::NotPositive)
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
    fn the_smallest_positive_number_is_positive_and_negative_zero_is_not() {
        assert_eq!(verdict(&[f64::from_bits(1)], Allowed::Positive), None);
        assert!(verdict(&[-0.0], Allowed::Positive).is_some());
    }
}
