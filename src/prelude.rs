//! What a program builds with: `use perifrac::prelude::*`.
//!
//! A [`Setup`] makes a [`Plan`] from a scene, and [`run`] or [`run_job`] runs it. What wants to step
//! by itself makes a [`Model`], its scheme with [`build_scheme`], and calls [`Scheme::step`].
//!
//! ```
//! use perifrac::prelude::*;
//!
//! let plan = Setup::text(
//!     r#"
//!     title = "A square that drains to the left"
//!     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
//!     fluid.viscosity = "1 mPa s"
//!     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
//!     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
//!     time.end = "0.3 s"
//!     "#,
//! )
//! .plan()?;
//! let (summary, state) = run(&plan, None, &mut (), &Interrupt::default())?;
//! assert!(summary.balance.mass < 1e-8);
//! assert!(state.pressure.iter().all(|p| (0.0..1e5).contains(p)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[doc(inline)]
pub use crate::geometry::{Cloud, Domain, Vector};
#[doc(inline)]
pub use crate::model::{FlowModel, Model, ModelError, SolidModel};
#[doc(inline)]
pub use crate::output::{CheckpointError, OutputError};
pub use crate::plan::{
    Effect, FieldPlan, Load, OwnEffect, PermeabilityPlan, Plan, PointTable, Points, Setup,
    TableError, resolve,
};
pub use crate::reference::{ErrorNorms, ExactDisplacement, ExactPressure};
#[doc(inline)]
pub use crate::report::{Balance, Timers};
#[doc(inline)]
pub use crate::run::{
    Checkpoint, CheckpointRule, Examined, FieldError, FieldValues, Interrupt, Job, Observer,
    Progress, RunError, Settings, Summary, View, Writer, examine, locate, run, run_job,
};
#[doc(inline)]
pub use crate::scene::{Diagnostic, LoadedScene, SceneErrors, load_file, load_str};
#[doc(inline)]
pub use crate::schemes::{
    Rejection, Scheme, SchemeCounters, State, StepError, StepLimit, StepReport,
    build as build_scheme, solve_steady,
};
