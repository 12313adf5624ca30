//! From local forms to sparse matrices: pattern once, values as often as coefficients change.

mod consistency;
mod elastic;
mod force;
mod operator;
mod pattern;
mod repetition;
mod scalar;
mod uniform_flow;

pub use consistency::{
    Consistency, ConsistencyError, Planes, consistent_gradient, natural_extension, side_layer,
};
pub use elastic::{Moduli, fill_rows, fill_stiffness};
pub use operator::ScalarOperator;
pub use pattern::{Pattern, PatternError, matrix_bytes};
pub use repetition::Repetition;
pub use scalar::Refill;
pub use uniform_flow::uniform_flow_error;
