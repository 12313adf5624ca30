//! The sections of a scene, one file each: what may be typed, and the rules it must keep.

mod flow;
mod fluid;
mod geometry;
mod gravity;
mod horizon;
mod materials;
mod output;
mod reference;
mod scheme;
mod solver;
mod time;
mod wells;

pub use flow::{
    Boundary, Condition, Flow, FluxCondition, Gradient, Operator, PressureCondition,
    PressureRegion, SealedCondition, Side,
};
pub use fluid::Fluid;
pub use geometry::{
    Blocks, Bounds, FileBounds, Geometry, Graded, Lattice, PointFile, Refinement, Segment,
    SegmentSpacing,
};
pub use gravity::Gravity;
pub use horizon::{Horizon, HorizonSize, Influence};
pub use materials::{
    Distribution, Material, PermeabilityDistribution, PermeabilityField, PermeabilityFile, Storage,
};
pub use output::{Output, Probe, Profile};
pub use reference::{Reference, ReferenceKind};
pub use scheme::{Scheme, SchemeName};
pub use solver::Solver;
pub use time::{Integrator, Mode, TimeControl};
pub use wells::Well;
