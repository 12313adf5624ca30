//! The sections of a scene, one file each: what may be typed, and the rules it must keep.

mod audit;
mod coupling;
mod cracks;
mod damage;
mod fields;
mod flow;
mod fluid;
mod fracture_flow;
mod geometry;
mod gravity;
mod horizon;
mod initial;
mod materials;
mod mechanics;
mod output;
mod reference;
mod scheme;
mod sides;
mod solver;
mod start;
mod time;
mod wells;

pub use audit::Audit;
pub use coupling::Coupling;
pub use cracks::{Crack, CrackDisc, CrackKind, Injection};
pub(crate) use cracks::{disc_in_plane, points_in_space};
pub use damage::{Damage, DamageMethod, DamageModel, EnergySplit, Hourglass, Normalise};
pub use fields::{Distribution, Field, FieldDistribution, FieldFile, ReadField, Typed};
pub use flow::{
    Condition, Flow, FluxCondition, Gradient, Operator, PressureCondition, PressureRegion,
    SealedCondition,
};
pub use fluid::Fluid;
pub use fracture_flow::{Aperture, FractureFlow, Transmissivity};
pub(crate) use geometry::thickness_in_space;
pub use geometry::{
    Blocks, Bounds, FileBounds, Geometry, Graded, Lattice, MeshFile, PointFile, Refinement,
    Segment, SegmentSpacing,
};
pub use gravity::Gravity;
pub use horizon::{Horizon, HorizonSize, Influence};
pub use initial::{Initial, InitialPressure, StressGradient, StressKind, StressRegion};
pub use materials::{Material, PermeabilityField, PermeabilityTensor, PrincipalPermeability};
pub use mechanics::{InitialStress, Interfaces, Mechanics, Motion, Support, TractionLoad};
pub use output::{Format, Output, Probe, Profile};
pub use reference::{Reference, ReferenceKind};
pub use scheme::{Acceleration, AdrDamping, Scheme, SchemeName, SchemeStart, SolidMethod};
pub use sides::{Boundary, Side};
pub use solver::Solver;
pub use start::{Start, StartClock, StartDisplacement};
pub use time::{Integrator, Mode, TimeControl};
pub use wells::Well;
