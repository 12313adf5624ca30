//! Options that all Krylov backends have.

use crate::registry::{OptionSpec, OptionValue};

const TOLERANCE: OptionSpec = OptionSpec {
    key: "tolerance",
    value: OptionValue::Positive,
    default: "1e-12",
    meaning: "true relative residual to reach",
};
const MAX_ITERATIONS: OptionSpec = OptionSpec {
    key: "max_iterations",
    value: OptionValue::Count,
    default: "10000",
    meaning: "iterations of one solve, over all restarts",
};
const REFACTOR_ABOVE: OptionSpec = OptionSpec {
    key: "refactor_above",
    value: OptionValue::Count,
    default: "12",
    meaning: "stale: renew the factor after a solve with more iterations",
};
const THRESHOLD: OptionSpec = OptionSpec {
    key: "threshold",
    value: OptionValue::Positive,
    default: "0.2",
    meaning: "amg: share of a point's largest coupling below which points are not joined",
};
const SMOOTHER_DEGREE: OptionSpec = OptionSpec {
    key: "smoother_degree",
    value: OptionValue::Count,
    default: "2",
    meaning: "amg: degree of the Chebyshev smoother",
};
const INNER: OptionSpec = OptionSpec {
    key: "inner",
    value: OptionValue::Count,
    default: "1",
    meaning: "schur, fixed-stress: iterations on the displacements per application; more than one \
              asks for fgmres",
};
const RESTART: OptionSpec = OptionSpec {
    key: "restart",
    value: OptionValue::Count,
    default: "60",
    meaning: "vectors of the basis before it is thrown away; memory grows with it",
};

/// The options of a method with short recurrences, for these preconditioners.
pub(super) const fn options(words: &'static [&'static str]) -> [OptionSpec; 7] {
    let preconditioner = OptionSpec {
        key: "preconditioner",
        value: OptionValue::OneOf(words),
        default: "jacobi",
        meaning: "approximate inverse of the matrix that speeds up the iteration",
    };
    [
        preconditioner,
        TOLERANCE,
        MAX_ITERATIONS,
        REFACTOR_ABOVE,
        THRESHOLD,
        SMOOTHER_DEGREE,
        INNER,
    ]
}

/// The options of a method that restarts.
pub(super) const fn options_with_restart(words: &'static [&'static str]) -> [OptionSpec; 8] {
    let [own, tolerance, limit, refactor, threshold, degree, inner] = options(words);
    [
        own, tolerance, limit, refactor, threshold, degree, inner, RESTART,
    ]
}
