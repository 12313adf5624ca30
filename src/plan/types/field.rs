//! A property of the rock that may vary from point to point.

/// Standard deviations between which drawn values are expected; 1 in 16 000 is outside.
const SPREAD: f64 = 4.0;

/// Where a property of a material comes from, in its SI unit.
#[derive(Debug, Clone, PartialEq)]
pub enum FieldPlan {
    /// One value.
    Uniform(f64),
    /// Values from a file.
    Table {
        /// The file, for messages.
        path: String,
        /// Values, x fastest.
        values: Vec<f64>,
        /// Cells along each axis of an array that is laid over the domain; `None` for one value per point of
        /// the cloud.
        cells: Option<Vec<usize>>,
    },
    /// Log-normal field. Two of them with the same seed and correlation length draw the same normal numbers.
    LogNormal {
        /// Median.
        median: f64,
        /// Standard deviation of the decimal logarithm.
        log10_std: f64,
        /// Total range in decades, to which values are clipped; infinite for none.
        decades: f64,
        /// Correlation length, m; `None` for independent points.
        correlation_length: Option<f64>,
        /// Seed.
        seed: u64,
    },
}

impl FieldPlan {
    /// The value, if it is the same everywhere.
    pub fn uniform(&self) -> Option<f64> {
        match self {
            Self::Uniform(value) => Some(*value),
            Self::Table { .. } | Self::LogNormal { .. } => None,
        }
    }

    /// Smallest and largest value: of a random field four standard deviations from the median, or where it is clipped.
    pub fn range(&self) -> [f64; 2] {
        match self {
            Self::Uniform(value) => [*value; 2],
            Self::Table { values, .. } => [
                values.iter().copied().fold(f64::INFINITY, f64::min),
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ],
            Self::LogNormal {
                median,
                log10_std,
                decades,
                ..
            } => {
                let half = (SPREAD * log10_std).min(0.5 * decades);
                [-half, half].map(|power| median * 10_f64.powf(power))
            }
        }
    }
}

/// Positive values with their logarithms stretched about the middle of their range, until the largest is
/// `contrast` times the smallest; `None` if they are all the same.
pub(crate) fn with_contrast(values: &[f64], contrast: f64) -> Option<Vec<f64>> {
    let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
    let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
    let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (middle, stretch) = (0.5 * (low + high), contrast.ln() / (high - low));
    let stretched = logs
        .iter()
        .map(|log| (middle + stretch * (log - middle)).exp());
    (high > low).then(|| stretched.collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn a_range_holds_what_a_field_has() {
        assert_eq!(FieldPlan::Uniform(3.0).range(), [3.0, 3.0]);
        let table = FieldPlan::Table {
            path: "e.csv".to_owned(),
            values: vec![2.0, 5.0, 1.0],
            cells: None,
        };
        assert_eq!((table.range(), table.uniform()), ([1.0, 5.0], None));
        let drawn = |decades| FieldPlan::LogNormal {
            median: 1e9,
            log10_std: 0.5,
            decades,
            correlation_length: None,
            seed: 0,
        };
        assert_eq!(drawn(f64::INFINITY).range(), [1e7, 1e11]);
        assert_eq!(drawn(2.0).range(), [1e8, 1e10]);
    }

    #[test]
    fn a_contrast_keeps_the_middle_and_the_order_of_values() {
        let stretched = with_contrast(&[1.0, 1e2, 1e4], 1e8).unwrap();
        for (found, wanted) in stretched.iter().zip([1e-2, 1e2, 1e6]) {
            assert!((found / wanted - 1.0).abs() < 1e-13);
        }
        let turned = with_contrast(&[1.0, 1e2, 1e4], 1e-4).unwrap();
        assert!((turned[0] / 1e4 - 1.0).abs() < 1e-13 && (turned[2] - 1.0).abs() < 1e-13);
        assert!(with_contrast(&[3.0, 3.0], 10.0).is_none());
    }
}
