//! What points are made of: elasticity, damage, storage and permeability.

mod backus;
mod damage;
mod eigen;
mod elasticity;
mod random_field;
mod storage;

pub(crate) use backus::Backus;
pub(crate) use damage::{CrackPlane, DamageLaw, PointResponse, PointState, Tangent, TangentKind};
pub use damage::{DamageModel, EnergySplit, Exponent, HourglassRule};
pub(crate) use eigen::eigen;
pub(crate) use elasticity::{Elasticity, Lame, unit_strain};
pub(crate) use random_field::log_normal;
pub(crate) use storage::storage_coefficient;
