//! How a step can fail.

use perifrac_solvers::{SolveError, SpecError};

/// A step that cannot be accepted.
#[derive(Debug, thiserror::Error)]
pub enum StepError {
    /// The linear solver gave up.
    #[error("linear solver: {0}")]
    Solve(#[from] SolveError),
    /// The solver could not be built.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// A value is no longer a number.
    #[error("the pressure at point {point} is not finite at t = {time} s")]
    NotFinite {
        /// The point.
        point: usize,
        /// Time, s.
        time: f64,
    },
    /// Explicit steps amplify errors.
    #[error(
        "explicit step unstable at t = {time:.6e} s: the imbalance grew {growth:.1e} times; Δt = \
         {dt:.6e} s is above the stability limit of {limit:.6e} s; use a smaller time.step, leave it \
         out, or use --scheme implicit"
    )]
    Unstable {
        /// Time, s.
        time: f64,
        /// Growth of the imbalance over its largest legitimate value.
        growth: f64,
        /// The step, s.
        dt: f64,
        /// The limit, s.
        limit: f64,
    },
    /// Steps have become too small to get anywhere.
    #[error(
        "the step fell to {dt:.3e} s at t = {time:.6e} s without meeting the tolerance; raise \
         time.tolerance, or look for values that are out of range"
    )]
    TooSmall {
        /// Time, s.
        time: f64,
        /// The step, s.
        dt: f64,
    },
    /// No steady state exists.
    #[error(
        "no steady state: the part of the domain around point {point} is sealed, and {net:.3e} m³/s \
         net (per metre in 2-D) are brought into it; prescribe a pressure somewhere or balance the wells"
    )]
    NoSteadyState {
        /// A point of the part.
        point: usize,
        /// Net rate brought in.
        net: f64,
    },
}
