//! The plan: a scene resolved to SI units and active effects. Nothing downstream reads the scene.

#[doc(hidden)]
pub mod capability;
mod demand;
mod exact;
mod files;
mod lattice;
mod own;
mod resolve;
mod setup;
mod types;
mod width;

pub use crate::geometry::generate::{Refinement, Segment};
pub use crate::geometry::{Horizon, Influence, Shape};
pub use crate::load::Load;
pub use exact::{
    exact_displacement, exact_flux, exact_opening, exact_pressure, exact_well_pressure,
    manufactured,
};
pub use files::{
    FileError, PointFields, PointSet, PointTable, TableError, check_length, read_array, read_fields,
};
pub use lattice::lattice;
pub use own::{ActsOn, Effect, OwnEffect, Points};
pub use resolve::{resolve, resolve_any, resolve_for};
pub use setup::Setup;
#[cfg(feature = "study")]
pub(crate) use types::with_contrast;
pub use types::{
    Acceleration, AdrDamping, ApertureRule, AuditPlan, CouplingPlan, CrackKind, CrackPlace,
    CrackPlan, DamageMethod, DamageModel, DamagePlan, DescentSettings, ElasticityPlan, EnergySplit,
    Exponent, FieldPlan, FlowPlan, FluidPlan, FractureFlowPlan, GeometryPlan, GradientChoice,
    GravityPlan, HourglassRule, InitialPlan, InjectionPlan, Integrator, MaterialPlan,
    MechanicsPlan, Normalise, OperatorChoice, OutputPlan, PermeabilityPlan, Plan, PorousPlan,
    Probe, Profile, ReferenceKind, ReferencePlan, RegionPressure, SchemeChoice, SchemeOptions,
    SchemeStart, SideCondition, SolidMethod, StartPlan, StepRule, StoragePlan, Support, TimeMode,
    TimePlan, TractionPlan, TransmissivityRule, WellDrive, WellPlan, Wellbore,
};
pub use width::{damage_width, ratio_warning, width_warning};
