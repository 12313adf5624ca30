//! From local forms to sparse matrices: pattern once, values as often as coefficients change.

mod consistency;
mod elastic;
mod force;
mod operator;
mod pattern;
mod repetition;
mod scalar;
mod uniform_flow;

pub(crate) use consistency::{
    Consistency, ConsistencyError, Planes, consistent_gradient, natural_extension, side_layer,
};
pub(crate) use elastic::{Moduli, fill_rows, fill_stiffness};
pub(crate) use operator::ScalarOperator;
pub(crate) use pattern::{Pattern, PatternError, matrix_bytes};
pub(crate) use repetition::Repetition;
pub(crate) use scalar::Refill;
pub(crate) use uniform_flow::uniform_flow_error;
