//! Where something ends along a line.

/// Halvings that find a place to the last bit of the length of its line.
const HALVINGS: usize = 53;

/// Where `holds` changes between a place at which it is true and one at which it is not.
pub fn border((mut low, mut high): (f64, f64), holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match holds(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_is_found_to_the_last_bit_from_either_side() {
        assert!((border((0.0, 1.0), |x| x < 0.3) - 0.3).abs() < 1e-16);
        assert!((border((1.0, 0.0), |x| x > 0.3) - 0.3).abs() < 1e-16);
    }
}
