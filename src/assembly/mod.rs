//! From local forms to sparse matrices: pattern once, values as often as coefficients change.

mod consistency;
mod force;
mod operator;
mod pattern;
mod scalar;

pub use consistency::{Consistency, ConsistencyError, consistent_gradient};
pub use operator::ScalarOperator;
pub use pattern::{Pattern, PatternError};
pub use scalar::Refill;
