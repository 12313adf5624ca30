//! From values to colours.

use colorous::{RED_BLUE, VIRIDIS};

use super::axes::Axis;
use super::canvas::Colour;

/// Colour of points without a value that can be shown.
pub(super) const MISSING: Colour = [150, 150, 150];

/// Palette of Okabe and Ito (2008), without the yellow, which is too pale for lines on white.
pub(super) const PALETTE: [Colour; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [25, 25, 25],
];

/// Two limits of opposite sign count as symmetric if they differ by less than this part.
const SYMMETRY: f64 = 0.2;

/// A value range with its colour map.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColourScale {
    pub axis: Axis,
    diverging: bool,
    /// Whether the range was made up because all values agree.
    pub constant: bool,
}

impl ColourScale {
    /// Covers `range` if given, else all `values` that can be shown. Ranges that are symmetric about
    /// zero within 20 % get the diverging map with white at zero.
    pub(super) fn new(values: &[f64], range: Option<(f64, f64)>, logarithmic: bool) -> Self {
        Self::over(values.iter().copied(), range, logarithmic)
    }

    /// The same as [`ColourScale::new`] for values from several places.
    pub(super) fn over(
        values: impl Iterator<Item = f64>,
        range: Option<(f64, f64)>,
        logarithmic: bool,
    ) -> Self {
        let usable = range.filter(|&(low, high)| {
            low.is_finite() && high > low && high.is_finite() && !(logarithmic && low <= 0.0)
        });
        let (axis, constant) = usable.map_or_else(
            || Axis::covering(values, logarithmic),
            |(low, high)| {
                (
                    Axis {
                        low,
                        high,
                        logarithmic,
                    },
                    false,
                )
            },
        );
        let Axis { low, high, .. } = axis;
        let largest = high.max(-low);
        let diverging = !logarithmic
            && !constant
            && low < 0.0
            && high > 0.0
            && (high + low).abs() <= SYMMETRY * largest;
        Self {
            axis,
            diverging,
            constant,
        }
    }

    /// Colour of a value, [`MISSING`] if it cannot be shown; values beyond the range get the colour
    /// of its end.
    pub(super) fn colour(&self, value: f64) -> Colour {
        if !self.axis.shows(value) {
            return MISSING;
        }
        if self.diverging {
            let largest = self.axis.high.max(-self.axis.low);
            let place = (0.5 - 0.5 * value / largest).clamp(0.0, 1.0);
            return RED_BLUE.eval_continuous(place).into_array();
        }
        VIRIDIS
            .eval_continuous(self.axis.fraction(value).clamp(0.0, 1.0))
            .into_array()
    }

    /// What a reader must know of these values besides their colours.
    pub(super) fn remarks(&self, values: impl Iterator<Item = f64>) -> Vec<String> {
        let axis = self.axis;
        let (mut total, mut grey, mut beyond) = (0_usize, 0_usize, 0_usize);
        for value in values {
            total += 1;
            let shown = axis.shows(value);
            grey += usize::from(!shown);
            beyond += usize::from(shown && !(axis.low..=axis.high).contains(&value));
        }
        let mut remarks = Vec::new();
        if total == 0 {
            remarks.push("no points".to_owned());
        }
        if grey > 0 {
            let kind = if axis.logarithmic {
                "not finite or not positive"
            } else {
                "not finite"
            };
            remarks.push(format!("grey: {grey} of {total} values are {kind}"));
        }
        if beyond > 0 {
            remarks.push(format!(
                "{beyond} of {total} values lie beyond the ends of the colour bar"
            ));
        }
        if self.constant {
            remarks.push("all values are equal".to_owned());
        }
        remarks
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn a_symmetric_range_is_white_at_zero_with_red_above_and_blue_below() {
        let scale = ColourScale::new(&[-1.0, 0.9], None, false);
        assert!(scale.diverging);
        assert!(scale.colour(0.0).iter().all(|&c| c > 235));
        let ([red, _, blue], below) = (scale.colour(0.8), scale.colour(-0.8));
        assert!(red > blue && below[2] > below[0]);
    }

    #[test]
    fn one_sided_and_lopsided_ranges_use_viridis() {
        for values in [[0.0, 1.0], [-1.0, 0.5], [-3.0, -1.0]] {
            let scale = ColourScale::new(&values, None, false);
            assert_eq!(scale.colour(values[0]), [68, 1, 84], "{values:?}");
            assert!(scale.colour(values[1])[0] > 240);
        }
    }

    #[test]
    fn values_without_a_place_on_the_scale_are_grey() {
        let scale = ColourScale::new(&[1e-3, 1e3, f64::NAN, -1.0], None, true);
        assert_eq!((scale.axis.low, scale.axis.high), (1e-3, 1e3));
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(scale.colour(value), MISSING);
        }
        assert_ne!(scale.colour(1.0), MISSING);
    }

    #[test]
    fn values_beyond_a_given_range_get_the_colour_of_its_end() {
        let scale = ColourScale::new(&[], Some((0.0, 1.0)), false);
        assert_eq!(scale.colour(7.0), scale.colour(1.0));
        assert_eq!(scale.colour(-7.0), scale.colour(0.0));
    }

    #[test]
    fn rounding_noise_on_a_constant_is_not_blown_up_to_the_whole_map() {
        let scale = ColourScale::new(&[1e6, 1e6 + 1e-6], None, false);
        assert!(scale.constant);
        assert_eq!(scale.colour(1e6), scale.colour(1e6 + 1e-6));
    }
}
