//! What can be wrong with a reference solution or a comparison.

use thiserror::Error;

/// A reference solution or a comparison that cannot be formed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ReferenceError {
    /// A parameter that must be finite and above zero is not.
    #[error("{parameter} is {value}; it must be finite and greater than zero")]
    NotPositive {
        /// Name of the parameter, with its unit.
        parameter: &'static str,
        /// Value given.
        value: f64,
    },
    /// A parameter that must be finite is not.
    #[error("{parameter} is {value}; give a finite number")]
    NotFinite {
        /// Name of the parameter, with its unit.
        parameter: &'static str,
        /// Value given.
        value: f64,
    },
    /// A position or a box with a number of axes the solution does not have.
    #[error("{found} axes given for {subject}; give {least} to {most}")]
    WrongDimension {
        /// What the axes belong to.
        subject: &'static str,
        /// Number of axes given.
        found: usize,
        /// Least number allowed.
        least: usize,
        /// Greatest number allowed.
        most: usize,
    },
    /// A field whose only wave has no half-waves between ends held at zero: it is zero everywhere.
    #[error("axis {axis} is held at zero at both ends with 0 half-waves; give at least 1")]
    NoWave {
        /// Index of the axis.
        axis: usize,
    },
    /// Lists that must run over the same points do not.
    #[error("{list} has {found} entries for {expected} points; give one per point")]
    LengthMismatch {
        /// Name of the list.
        list: &'static str,
        /// Number of points.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// A compared value is infinite or NaN.
    #[error(
        "point {point}: computed {numerical}, exact {exact}; exclude singular points, \
         and look for the step in which the computed field lost its values"
    )]
    BadSample {
        /// Index of the point.
        point: usize,
        /// Computed value.
        numerical: f64,
        /// Exact value.
        exact: f64,
    },
    /// A point's volume is negative or not finite.
    #[error("point {point} has volume {volume}; a volume is finite and not negative")]
    BadVolume {
        /// Index of the point.
        point: usize,
        /// Volume found, m³ (m² in 2-D).
        volume: f64,
    },
    /// No point with a volume is left to compare.
    #[error(
        "nothing to compare: {excluded} points are excluded and the rest has no volume; \
         use a finer cloud or a smaller excluded radius"
    )]
    NothingCompared {
        /// Number of points excluded.
        excluded: usize,
    },
}

/// `value` if it is finite and above zero.
pub(super) fn positive(parameter: &'static str, value: f64) -> Result<f64, ReferenceError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ReferenceError::NotPositive { parameter, value })
    }
}

/// `value` if it is finite.
pub(super) fn finite(parameter: &'static str, value: f64) -> Result<f64, ReferenceError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ReferenceError::NotFinite { parameter, value })
    }
}
