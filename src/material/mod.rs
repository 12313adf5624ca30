//! What points are made of: elasticity, damage, storage and permeability.

mod backus;
mod damage;
mod eigen;
mod elasticity;
mod random_field;
mod storage;

pub use backus::Backus;
pub use damage::{
    CrackPlane, DamageLaw, DamageModel, EnergySplit, Exponent, HourglassRule, PointResponse,
    PointState, Tangent, TangentKind,
};
pub use eigen::eigen;
pub use elasticity::{Elasticity, Lame, unit_strain};
pub use random_field::log_normal;
pub use storage::storage_coefficient;
