//! What points are made of: elasticity, storage and permeability.

mod elasticity;
mod random_field;
mod storage;

pub use elasticity::Elasticity;
pub use random_field::log_normal;
pub use storage::storage_coefficient;
