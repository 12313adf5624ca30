//! What points are made of: storage and permeability.

mod random_field;
mod storage;

pub use random_field::log_normal;
pub use storage::storage_coefficient;
